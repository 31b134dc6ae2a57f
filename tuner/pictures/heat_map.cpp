#include "pictures/heat_map.hpp"

#include <algorithm>

#include "pictures/plot.hpp"
#include "pictures/svg.hpp"

namespace assur::pictures {
namespace {

using svg::at;
using svg::width;

constexpr double kTop = 30, kBottom = 46, kGap = 2;
constexpr double kMostFill = 0.7, kLeastFill = 0.12;  // opacity of a cell, so that its text is legible
constexpr double kDot = 3;
constexpr double kLine = 13;  // distance of the lines in a cell

std::string fill(const HeatMap::Kind& kind) {
  const double opacity = kLeastFill + (kMostFill - kLeastFill) * std::clamp(kind.strength, 0.0, 1.0);
  return " fill=\"currentColor\" fill-opacity=\"" + std::to_string(opacity).substr(0, 4) + "\" class=\"c" +
         std::to_string(kind.colour % Series::kColours) + "\"";
}

std::string dot(double x, double y) {
  return "<circle class=\"measured\" cx=\"" + at(x) + "\" cy=\"" + at(y) + "\" r=\"" + at(kDot) + "\"/>";
}

// The text in one line, or in two, broken at its first blank. If these do not fit, the name of the kind, or nothing.
std::vector<std::string> lines_for(const std::string& text, const std::string& kind, double w, double h) {
  if (width(text) < w) return {text};
  const std::size_t blank = text.find(' ');
  if (blank != std::string::npos && h > 2 * kLine) {
    const std::string first = text.substr(0, blank), rest = text.substr(blank + 1);
    if (std::max(width(first), width(rest)) < w) return {first, rest};
  }
  if (width(kind) < w) return {kind};
  return {};
}

std::string draw(const HeatMap& map, double all_width, double cell_height, std::string_view css_class) {
  double left = 0;
  for (const std::string& row : map.rows) left = std::max(left, width(row));
  left += 10;
  const auto rows = static_cast<double>(map.rows.size());
  const double w = (all_width - left) / static_cast<double>(map.columns.size()), h = cell_height;
  const double foot = kTop + rows * h;
  // If names of columns would touch, every second one moves to a second line.
  const bool tight = std::any_of(map.columns.begin(), map.columns.end(),
                                 [w](const std::string& column) { return width(column) > w - 2 * kGap; });
  const double second = tight ? kLine : 0;
  std::string out;
  for (std::size_t r = 0; r < map.rows.size(); ++r) {
    const double y = foot - static_cast<double>(r + 1) * h;
    out += svg::text("tick", left - 6, y + h / 2 + 4, "end", map.rows[r]);
    for (std::size_t c = 0; c < map.columns.size(); ++c) {
      const HeatMap::Cell& cell = map.cells[r * map.columns.size() + c];
      if (cell.kind < 0) continue;
      const double x = left + static_cast<double>(c) * w;
      const HeatMap::Kind& kind = map.kinds[static_cast<std::size_t>(cell.kind)];
      out += svg::rectangle(x, y, w - kGap, h - kGap, cell.about, fill(kind));
      const auto lines = lines_for(cell.text, kind.name, w - 6 * kGap, h);
      const bool fits = !lines.empty();
      double base = y + h / 2 + 4 - kLine / 2 * (static_cast<double>(lines.size()) - 1);
      for (const std::string& line : lines) {
        out += svg::text("cell", x + w / 2 - 1, base, "middle", line);
        base += kLine;
      }
      if (cell.marked) out += fits ? dot(x + 6, y + 6) : dot(x + w / 2 - 1, y + h / 2 - 1);
    }
  }
  for (std::size_t c = 0; c < map.columns.size(); ++c) {
    out += svg::text("tick", left + (static_cast<double>(c) + 0.5) * w, foot + 16 + (c % 2 == 0 ? 0 : second), "middle",
                     map.columns[c]);
  }
  out += svg::text("title", all_width, foot + 36 + second, "end", map.x_title) +
         svg::text("title", 2, 14, "start", map.y_title);
  return svg::picture("heat " + std::string(css_class), all_width, foot + kBottom + second, map.title, out);
}

std::string keys(const HeatMap& map) {
  std::string out;
  for (const HeatMap::Kind& kind : map.kinds) {
    out += svg::key(svg::rectangle(3, 1, 18, 16, kind.name, fill(kind)), kind.name);
  }
  return out + (map.mark.empty() ? "" : svg::key(dot(12, 9), map.mark));
}

}  // namespace

std::string figure(const HeatMap& map) {
  return svg::figure(draw(map, 960, 34, "wide"), draw(map, 360, 26, "narrow"), keys(map));
}

}  // namespace assur::pictures
