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

void ErrorsCsv::write(double t, std::int64_t substeps, const Structure& structure, std::span<const ErrorsRow> rows) {
  for (const ErrorsRow& row : rows) {
    const GroupFigures& f = row.figures;
    out_ << t << ",\"" << structure.groups[static_cast<std::size_t>(f.group)].name << "\"," << f.residual << ','
         << f.estimated_error;
    cell(out_, row.error);
    out_ << ',' << f.condition;
    cell(out_, row.iterations);
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
