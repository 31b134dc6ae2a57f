#include "commands/errors_csv.hpp"

namespace assur::output {
namespace {

// With 17 digits a time reads back as the same double as in the CSV of the motion.
constexpr int kDigits = 17;

template <class T>
void cell(std::ostream& out, const std::optional<T>& value) {
  out << ',';
  if (value) out << *value;
}

}  // namespace

ErrorsCsv::ErrorsCsv(const std::string& file) : file_("--errors", file) {
  file_.stream().precision(kDigits);
  file_.stream() << "t,group,residual,estimated,error,condition,iterations,substeps\n";
}

void ErrorsCsv::write(double t, std::int64_t substeps, const GroupedSystem& structure,
                      std::span<const ErrorsRow> rows) {
  std::ostream& out = file_.stream();
  for (const ErrorsRow& row : rows) {
    const GroupFigures& f = row.figures;
    out << t << ",\"" << structure.groups[static_cast<std::size_t>(f.group)].name << "\"," << f.residual << ','
        << f.estimated_error;
    cell(out, row.error);
    out << ',' << f.condition;
    cell(out, row.iterations);
    out << ',' << substeps << '\n';
  }
  file_.check();
}

void ErrorsCsv::close() { file_.put(); }

}  // namespace assur::output
