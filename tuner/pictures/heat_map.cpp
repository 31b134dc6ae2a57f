#include "pictures/heat_map.hpp"

#include <algorithm>

#include "pictures/html.hpp"
#include "pictures/plot.hpp"
#include "pictures/svg.hpp"

namespace assur::pictures {
namespace {

constexpr double kTop = 30, kBottom = 46, kGap = 2;
constexpr double kMostFill = 0.7, kLeastFill = 0.12;  // opacity of a cell: the text above it stays legible
constexpr double kDot = 3;
constexpr double kLine = 13;  // from one line of a cell to the next

std::string fill(const HeatMap::Kind& kind) {
  const double opacity = kLeastFill + (kMostFill - kLeastFill) * std::clamp(kind.strength, 0.0, 1.0);
  return "fill=\"currentColor\" fill-opacity=\"" + std::to_string(opacity).substr(0, 4) + "\" class=\"c" +
         std::to_string(kind.colour % Series::kColours) + "\"";
}

std::string text(std::string_view css_class, double x, double y, std::string_view anchor, std::string_view what) {
  std::string out = "<text class=\"";
  out.append(css_class).append("\" x=\"").append(at(x)).append("\" y=\"").append(at(y));
  return out.append("\" text-anchor=\"").append(anchor).append("\">").append(escaped(what)).append("</text>\n");
}

std::string dot(double x, double y) {
  return "<circle class=\"measured\" cx=\"" + at(x) + "\" cy=\"" + at(y) + "\" r=\"" + at(kDot) + "\"/>";
}

std::string rectangle(double x, double y, double w, double h, const HeatMap::Kind& kind, std::string_view about) {
  return "<rect x=\"" + at(x) + "\" y=\"" + at(y) + "\" width=\"" + at(w) + "\" height=\"" + at(h) + "\" " +
         fill(kind) + "><title>" + escaped(about) + "</title></rect>\n";
}

// The text in one line or, broken at its first blank, two; else the kind's name; nothing where that has no room either.
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
  // Names of columns that would touch stand in two lines in turn.
  const bool tight = std::any_of(map.columns.begin(), map.columns.end(),
                                 [w](const std::string& column) { return width(column) > w - 2 * kGap; });
  const double second = tight ? kLine : 0;
  std::string out = "<svg class=\"plot heat " + std::string(css_class) + "\" viewBox=\"0 0 " + at(all_width) + " " +
                    at(foot + kBottom + second) + "\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"" +
                    escaped(map.title) + "\">\n";
  for (std::size_t r = 0; r < map.rows.size(); ++r) {
    const double y = foot - static_cast<double>(r + 1) * h;
    out += text("tick", left - 6, y + h / 2 + 4, "end", map.rows[r]);
    for (std::size_t c = 0; c < map.columns.size(); ++c) {
      const HeatMap::Cell& cell = map.cells[r * map.columns.size() + c];
      if (cell.kind < 0) continue;
      const double x = left + static_cast<double>(c) * w;
      out += rectangle(x, y, w - kGap, h - kGap, map.kinds[static_cast<std::size_t>(cell.kind)], cell.about);
      const auto lines = lines_for(cell.text, map.kinds[static_cast<std::size_t>(cell.kind)].name, w - 6 * kGap, h);
      const bool fits = !lines.empty();
      double base = y + h / 2 + 4 - kLine / 2 * (static_cast<double>(lines.size()) - 1);
      for (const std::string& line : lines) {
        out += text("cell", x + w / 2 - 1, base, "middle", line);
        base += kLine;
      }
      if (cell.marked) out += fits ? dot(x + 6, y + 6) : dot(x + w / 2 - 1, y + h / 2 - 1);
    }
  }
  for (std::size_t c = 0; c < map.columns.size(); ++c) {
    out += text("tick", left + (static_cast<double>(c) + 0.5) * w, foot + 16 + (c % 2 == 0 ? 0 : second), "middle",
                map.columns[c]);
  }
  out += text("title", all_width, foot + 36 + second, "end", map.x_title) + text("title", 2, 14, "start", map.y_title);
  return out + "</svg>\n";
}

std::string legend(const HeatMap& map) {
  constexpr std::string_view kKey =
      "<li><svg class=\"plot key\" viewBox=\"0 0 24 18\" width=\"24\" height=\"18\" aria-hidden=\"true\">";
  std::string out = "<ul class=\"legend\">\n";
  for (const HeatMap::Kind& kind : map.kinds) {
    out.append(kKey).append(rectangle(3, 1, 18, 16, kind, kind.name));
    out.append("</svg>").append(escaped(kind.name)).append("</li>\n");
  }
  if (!map.mark.empty())
    out.append(kKey).append(dot(12, 9)).append("</svg>").append(escaped(map.mark)).append("</li>\n");
  return out + "</ul>\n";
}

}  // namespace

std::string figure(const HeatMap& map) {
  return "<figure>\n" + draw(map, 960, 34, "wide") + draw(map, 360, 26, "narrow") + legend(map) + "</figure>\n";
}

std::string_view heat_map_style() {
  return R"(
.heat .cell { font-size: 12px; } .heat .measured, .key .measured { fill: var(--ink); }
)";
}

}  // namespace assur::pictures
