#include "report/measurement_csv.hpp"

#include <cmath>
#include <string>

namespace assur::report {
namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + '"';
}

}  // namespace

void write_csv(std::ostream& out, std::span<const Section> sections) {
  out.precision(17);
  out << "section,item,strategy,quantity,unit,value,repetitions,spread,error,origin\n";
  for (const Section& section : sections) {
    for (const Measurement& m : section.measurements) {
      out << quoted(m.section) << ',' << quoted(m.item) << ',' << quoted(m.strategy) << ',' << quoted(m.quantity) << ','
          << quoted(m.unit) << ',';
      if (!std::isnan(m.value)) out << m.value;
      out << ',' << m.repetitions << ',';
      if (m.repetitions > 1) out << m.spread;
      out << ',';
      if (!std::isnan(m.error)) out << m.error;
      out << ',' << quoted(m.origin) << '\n';
    }
  }
}

}  // namespace assur::report
