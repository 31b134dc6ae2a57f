#include "tuning/sample_csv.hpp"

#include <cmath>
#include <cstdio>
#include <string>

namespace assur::tuning {
namespace {

std::string number(double value) {
  if (std::isnan(value)) return "";
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.17g", value);
  return digits;
}

}  // namespace

void write_csv(std::ostream& out, std::span<const Sample> samples) {
  out << "kernel,n,nnz,fill,operations,terms,pattern,groups,strategy,seconds,spread,repetitions,backward_error,"
         "forward_error\n";
  for (const Sample& s : samples) {
    const Shape& h = s.shape;
    out << name(s.kernel) << ',' << h.n << ',' << h.nnz << ',' << h.fill << ',' << h.operations << ',' << h.terms << ','
        << h.pattern << ',' << h.groups << ',' << to_string(s.strategy) << ',' << number(s.seconds) << ','
        << number(s.spread) << ',' << s.repetitions << ',' << number(s.backward_error) << ',' << number(s.forward_error)
        << '\n';
  }
}

}  // namespace assur::tuning
