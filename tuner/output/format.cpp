#include "output/format.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "decimal.hpp"

namespace assur::output {
namespace {

bool starts_code_point(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; }

}  // namespace

std::string grouped(std::int64_t count) {
  std::string text = std::to_string(count);
  const std::ptrdiff_t digits_begin = count < 0 ? 1 : 0;
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > digits_begin; at -= 3) {
    text.insert(static_cast<std::size_t>(at), 1, ',');
  }
  return text;
}

std::string counted(std::int64_t count, std::string_view noun) {
  std::string text = grouped(count) + " " + std::string(noun);
  if (count == 1) return text;
  return text + (text.ends_with("s") ? "es" : "s");
}

std::string duration(double seconds) {
  struct Unit {
    double size;
    const char* name;
  };
  constexpr std::array kUnits = {Unit{1, " s"}, Unit{1e-3, " ms"}, Unit{1e-6, " µs"}, Unit{1e-9, " ns"}};
  const auto unit = std::find_if(kUnits.begin(), kUnits.end() - 1,
                                 [&](const Unit& u) { return std::abs(seconds) >= u.size * 0.9995; });
  const double value = seconds / unit->size;
  return assur::fixed(value, std::abs(value) < 9.995 ? 2 : std::abs(value) < 99.95 ? 1 : 0) + unit->name;
}

std::string one_line(std::string text) {
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos;) text.replace(at, 1, "; ");
  return text;
}

std::string number(double value) { return general(value, 6); }

std::string fixed(double value) { return assur::fixed(value, 2); }

std::string error_figure(double value) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return "not finite";
  return value == 0 ? "0" : scientific(value, 1);
}

std::string listed(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i == 0 ? "" : ", ") + names[i];
  if (names.size() > most) text += " and " + grouped(names.size() - most) + " more";
  return text;
}

std::size_t display_width(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), starts_code_point));
}

std::string shortened(const std::string& text, std::size_t most) {
  if (display_width(text) <= most) return text;
  std::size_t end = 0, columns = 0;
  for (; end < text.size(); ++end) {
    if (starts_code_point(text[end]) && columns++ == most - 3) break;
  }
  return text.substr(0, end) + "...";
}

std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  std::string line;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (word.empty()) continue;
    if (!line.empty() && display_width(line) + 1 + display_width(word) > width) {
      lines.push_back(std::move(line));
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  if (!line.empty() || lines.empty()) lines.push_back(std::move(line));
  return lines;
}

}  // namespace assur::output
