#include "output/errors_csv.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

namespace assur::output {
namespace {

// 17 digits, so that a time finds its row in the trajectory.
constexpr int kDigits = 17;

template <class T>
void cell(std::ostream& out, const std::optional<T>& value) {
  out << ',';
  if (value) out << *value;
}

}  // namespace

ErrorsCsv::ErrorsCsv(std::string file) : file_(std::move(file)) {
  errno = 0;
  out_.open(file_);
  if (!out_) fail();
  out_.precision(kDigits);
  out_ << "t,group,residual,estimated,error,condition,iterations,substeps\n";
}

void ErrorsCsv::write(double t, std::int64_t substeps, const Structure& structure,
                      std::span<const measure::GroupFigures> figures) {
  for (std::size_t g = 0; g < figures.size(); ++g) {
    const measure::GroupFigures& f = figures[g];
    out_ << t << ",\"" << structure.groups[g].name << "\"," << f.residual;
    cell(out_, f.estimated);
    cell(out_, f.error);
    cell(out_, f.condition);
    cell(out_, f.iterations);
    out_ << ',' << substeps << '\n';
  }
  if (!out_) fail();
}

void ErrorsCsv::close() {
  errno = 0;
  out_.close();
  if (!out_) fail();
}

void ErrorsCsv::fail() const {
  const std::string why = errno != 0 ? std::strerror(errno) : "unknown reason";
  throw Error(Error::Kind::environment, {{"--errors", "cannot write " + file_ + ": " + why}});
}

}  // namespace assur::output
