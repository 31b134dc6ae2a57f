#include "tuning/sample_csv.hpp"

#include <cmath>
#include <string>

#include "decimal.hpp"
#include "dispatch/pace.hpp"

namespace assur::tuning {
namespace {

std::string number(double value) { return std::isnan(value) ? "" : general(value, 17); }

}  // namespace

void write_csv(std::ostream& out, std::span<const Sample> samples) {
  out << "kernel,n,nnz,fill,operations,depth,terms,pattern,one_program,groups,strategy,seconds,spread,repetitions,"
         "backward_error,forward_error,raw_seconds,slowness\n";
  for (const Sample& s : samples) {
    const Shape& h = s.shape;
    out << name(s.kernel) << ',' << h.n << ',' << h.nnz << ',' << h.fill << ',' << h.operations << ',' << h.depth << ','
        << h.terms << ',' << h.pattern << ',' << (h.one_program ? 1 : 0) << ',' << h.groups << ','
        << to_string(s.strategy) << ',' << number(s.seconds) << ',' << number(s.spread) << ',' << s.repetitions << ','
        << number(s.backward_error) << ',' << number(s.forward_error) << ',' << number(slowed(s, s.slowness).seconds)
        << ',' << number(s.slowness) << '\n';
  }
}

}  // namespace assur::tuning
