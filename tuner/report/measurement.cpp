#include "report/measurement.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "decimal.hpp"
#include "numbers.hpp"
#include "output/format.hpp"

namespace assur::report {

std::string value_text(const Measurement& m) {
  if (!std::isfinite(m.value)) return "-";
  if (m.unit == "s") return output::duration(m.value);
  return general(m.value, 3) + (m.unit == "1" || m.unit.empty() ? "" : " " + m.unit);
}

std::string percent(double share) { return fixed(100 * share, std::abs(share) < 0.0995 ? 1 : 0) + " %"; }

std::string about(const Measurement& m) {
  std::string text = m.strategy.empty() ? m.item : m.strategy;
  text += ": " + value_text(m) + "; ";
  if (m.repetitions > 0) {
    text += output::counted(m.repetitions, "repetition") + ", ";
    if (m.repetitions > 1) text += "spread " + percent(m.spread) + ", ";
  }
  if (!std::isnan(m.error)) text += "error " + output::error_figure(m.error) + ", ";
  return text + m.origin;
}

pictures::HtmlTable table_of(const std::vector<Measurement>& measurements, std::size_t most) {
  using enum pictures::HtmlTable::Column;
  pictures::HtmlTable table{{"what", "strategy", "quantity", "value", "repetitions", "spread", "error", "origin"},
                            {text, text, text, number, number, number, number, words},
                            {}};
  for (const Measurement& m : measurements) {
    if (table.rows.size() == most) break;
    const bool repeated = m.repetitions > 0;
    table.rows.push_back({{m.item, m.strategy, m.quantity, value_text(m), repeated ? std::to_string(m.repetitions) : "",
                           m.repetitions > 1 ? percent(m.spread) : "",
                           std::isnan(m.error) ? "" : output::error_figure(m.error), m.origin}});
  }
  return table;
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return kNan;
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return kNan;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::string paragraph(std::string_view text, std::string_view css_class) {
  std::string out = "<p";
  if (!css_class.empty()) out.append(" class=\"").append(css_class).append("\"");
  return out.append(">").append(pictures::escaped(text)).append("</p>\n");
}

}  // namespace assur::report
