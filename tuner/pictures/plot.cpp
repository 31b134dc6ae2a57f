#include "pictures/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pictures/html.hpp"
#include "pictures/svg.hpp"
#include "pictures/ticks.hpp"

namespace assur::pictures {
namespace {

using svg::at;
using svg::kLetter;
using svg::kLine;
using svg::width;

constexpr Size kWide{960, 560}, kNarrow{360, 400};
constexpr double kTop = 34, kRight = 14, kBottom = 46;  // margins: title of y, end of the last tick, title of x
constexpr double kMark = 4.5;                           // half the size of a mark
constexpr double kBold = 1.25, kGap = 2;                // width of bold letters relative to others; gap beside a label
constexpr double kPixelsOfTick = 62, kLinesOfTick = 34;

std::string colour_class(int colour) { return colour < 0 ? "ink" : "c" + std::to_string(colour % Series::kColours); }

// The outline of a mark around (x, y), about 2 r wide.
std::string mark(Series::Mark kind, double x, double y, double r) {
  const auto polygon = [&](std::initializer_list<std::pair<double, double>> corners) {
    std::string points;
    for (const auto& [dx, dy] : corners) points += at(x + dx * r) + "," + at(y + dy * r) + " ";
    return "<polygon points=\"" + points + "\">";
  };
  const auto strokes = [](const std::string& path) { return "<path d=\"M" + path + "\">"; };
  switch (kind) {
    case Series::Mark::none:
      return "";
    case Series::Mark::dot:
      return "<circle cx=\"" + at(x) + "\" cy=\"" + at(y) + "\" r=\"" + at(r) + "\">";
    case Series::Mark::square:
      return polygon({{-0.9, -0.9}, {0.9, -0.9}, {0.9, 0.9}, {-0.9, 0.9}});
    case Series::Mark::triangle:
      return polygon({{0, -1.2}, {1.1, 0.8}, {-1.1, 0.8}});
    case Series::Mark::diamond:
      return polygon({{0, -1.9}, {1.5, 0}, {0, 1.9}, {-1.5, 0}});
    case Series::Mark::cross:
      return strokes(at(x - r) + " " + at(y - r) + "L" + at(x + r) + " " + at(y + r) + "M" + at(x - r) + " " +
                     at(y + r) + "L" + at(x + r) + " " + at(y - r));
    case Series::Mark::plus:
      return strokes(at(x - 1.3 * r) + " " + at(y) + "H" + at(x + 1.3 * r) + "M" + at(x) + " " + at(y - 1.3 * r) + "V" +
                     at(y + 1.3 * r));
  }
  return "";
}

std::string marked(const Series& s, double x, double y, double r, const std::string& about) {
  const std::string shape = mark(s.mark, x, y, r);
  if (shape.empty()) return "";
  const std::string element = shape.substr(1, shape.find(' ') - 1);
  return shape + (about.empty() ? "" : "<title>" + escaped(about) + "</title>") + "</" + element + ">\n";
}

// An axis with its range of pixels.
struct Scale {
  const Axis& axis;
  Ticks ticks;
  double from = 0, to = 0;  // pixels of low and high

  [[nodiscard]] bool shows(double value) const { return std::isfinite(value) && (!axis.logarithmic || value > 0); }
  [[nodiscard]] double operator()(double value) const {
    const double share = axis.logarithmic ? std::log(value / ticks.low) / std::log(ticks.high / ticks.low)
                                          : (value - ticks.low) / (ticks.high - ticks.low);
    return from + share * (to - from);
  }
};

Scale scale(const Axis& axis, const std::vector<double>& values, int most) {
  Scale out{axis, {}, 0, 0};
  std::optional<std::pair<double, double>> span;
  for (const double v : values) {
    if (!out.shows(v)) continue;
    span = span ? std::pair(std::min(span->first, v), std::max(span->second, v)) : std::pair(v, v);
  }
  if (!span) span = axis.logarithmic ? std::pair(0.1, 1.0) : std::pair(0.0, 1.0);
  out.ticks = axis.logarithmic ? logarithmic_ticks(span->first, span->second, most)
                               : linear_ticks(span->first, span->second, most);
  return out;
}

class Picture {
 public:
  Picture(const Plot& plot, Size size)
      : plot_(plot),
        size_(size),
        x_(scale(plot.x, values(true), static_cast<int>(size.width / kPixelsOfTick))),
        y_(scale(plot.y, values(false), static_cast<int>(size.height / kLinesOfTick))) {
    double left = 0;
    for (const double t : y_.ticks.at) left = std::max(left, width(plot.y.text(t)));
    x_.from = left + 14;
    x_.to = size.width - kRight;
    y_.from = size.height - kBottom;
    y_.to = kTop;
  }

  std::string draw(std::string_view css_class) {
    draw_axes();
    for (const Guide& g : plot_.guides) draw_guide(g);
    for (const Series& s : plot_.series) draw_line(s);
    for (const Series& s : plot_.series) draw_marks(s);
    for (const Series& s : plot_.series) draw_labels(s);
    return svg::picture(css_class, size_.width, size_.height, plot_.title, out_);
  }

 private:
  [[nodiscard]] std::vector<double> values(bool of_x) const {
    std::vector<double> all;
    for (const Series& s : plot_.series) {
      for (const Point& p : s.points) all.push_back(of_x ? p.x : p.y);
    }
    for (const Guide& g : plot_.guides) {
      if (of_x) all.push_back(g.x);
    }
    return all;
  }

  void draw_axes() {
    double free_from = -1e9;  // x at which the next label of a tick may begin
    for (const double t : x_.ticks.at) {
      out_ += svg::line("grid", x_(t), y_.from, x_(t), y_.to);
      const std::string what = plot_.x.text(t);
      const double half = width(what) / 2;
      const double middle = std::min(x_(t), size_.width - half);
      if (middle - half < free_from) continue;
      out_ += svg::text("tick", middle, y_.from + 17, "middle", what);
      free_from = middle + half + kLetter;
    }
    for (const double t : y_.ticks.at) {
      out_ += svg::line("grid", x_.from, y_(t), x_.to, y_(t));
      out_ += svg::text("tick", x_.from - 6, y_(t) + 4, "end", plot_.y.text(t));
    }
    out_ += svg::text("title", x_.to, size_.height - 8, "end", plot_.x.title);
    out_ += svg::text("title", 2, 14, "start", plot_.y.title);
  }

  struct Box {
    double x, y, w, h;
    [[nodiscard]] bool overlaps(const Box& o) const {
      return x < o.x + o.w && o.x < x + w && y < o.y + o.h && o.y < y + h;
    }
  };

  // Occupies a box; false if it overlaps another one.
  bool take(const Box& box) {
    if (std::any_of(taken_.begin(), taken_.end(), [&](const Box& b) { return b.overlaps(box); })) return false;
    taken_.push_back(box);
    return true;
  }

  void draw_guide(const Guide& guide) {
    if (!x_.shows(guide.x)) return;
    out_ += svg::line("guide", x_(guide.x), y_.from, x_(guide.x), y_.to - 2);
    const double half = width(guide.text) / 2, middle = std::clamp(x_(guide.x), x_.from + half, x_.to - half);
    if (take({middle - half, y_.to - 5 - kLine, 2 * half, kLine})) {
      out_ += svg::text("tick", middle, y_.to - 5, "middle", guide.text);
    }
  }

  [[nodiscard]] bool shows(const Point& p) const { return x_.shows(p.x) && y_.shows(p.y); }

  void draw_line(const Series& s) {
    if (s.line == Series::Line::none) return;
    if (s.line == Series::Line::bars) return draw_bars(s);
    std::string path;
    for (const Point& p : s.points) {
      if (!shows(p)) continue;
      if (path.empty()) {
        path = "M" + at(x_(p.x)) + " " + at(y_(p.y));
      } else if (s.line == Series::Line::steps) {
        path += "H" + at(x_(p.x)) + "V" + at(y_(p.y));
      } else {
        path += "L" + at(x_(p.x)) + " " + at(y_(p.y));
      }
    }
    if (!path.empty()) out_ += "<path class=\"line " + colour_class(s.colour) + "\" d=\"" + path + "\"/>\n";
  }

  void draw_bars(const Series& s) {
    out_ += "<g class=\"bars " + colour_class(s.colour) + "\">\n";
    for (std::size_t i = 0; i + 1 < s.points.size(); ++i) {
      const Point &here = s.points[i], &next = s.points[i + 1];
      if (!shows(here) || !x_.shows(next.x)) continue;
      out_ += svg::rectangle(x_(here.x), y_(here.y), x_(next.x) - x_(here.x), y_.from - y_(here.y), here.about);
    }
    out_ += "</g>\n";
  }

  void draw_marks(const Series& s) {
    if (s.mark == Series::Mark::none) return;
    out_ += "<g class=\"mark " + colour_class(s.colour) + "\">\n";
    for (const Point& p : s.points) {
      if (!shows(p)) continue;
      out_ += marked(s, x_(p.x), y_(p.y), kMark, p.about);
      marks_.push_back({x_(p.x) - kMark, y_(p.y) - kMark, 2 * kMark, 2 * kMark});
    }
    out_ += "</g>\n";
  }

  // Puts each label beside its point, within the axes, where it covers neither marks nor labels; else above or below,
  // where it covers no label; else omits it.
  void draw_labels(const Series& s) {
    for (const Point& p : s.points) {
      if (p.label.empty() || !shows(p)) continue;
      const double w = kBold * width(p.label), beside = w / 2 + 10;
      const std::array<std::pair<double, double>, 8> places = {
          {{0, -9}, {0, 19}, {beside, 5}, {-beside, 5}, {beside, -11}, {-beside, -11}, {beside, 21}, {-beside, 21}}};
      const auto is_placed = [&](std::size_t most, bool on_marks) {
        for (std::size_t i = 0; i < most; ++i) {
          const auto [dx, dy] = places[i];
          const double x = x_(p.x) + dx, y = y_(p.y) + dy;
          const Box box{x - w / 2 - kGap, y - kLine + 2, w + 2 * kGap, kLine};
          if (box.x < x_.from - kGap - 2 || box.x + box.w > x_.to || box.y < y_.to || box.y + box.h > y_.from) continue;
          const auto overlaps = [&](const Box& mark) { return mark.overlaps(box); };
          if (!on_marks && std::any_of(marks_.begin(), marks_.end(), overlaps)) continue;
          if (!take(box)) continue;
          out_ += svg::text("label", x, y, "middle", p.label);
          return true;
        }
        return false;
      };
      if (!is_placed(places.size(), false)) (void)is_placed(2, true);
    }
  }

  const Plot& plot_;
  Size size_;
  Scale x_, y_;
  std::vector<Box> taken_, marks_;
  std::string out_;
};

// The legend: the mark or a piece of the line, and the name.
std::string keys(const Plot& plot) {
  std::string out;
  for (const Series& s : plot.series) {
    if (s.name.empty()) continue;
    const std::string colour = colour_class(s.colour);
    out += svg::key((s.line == Series::Line::none ? "" : "<path class=\"line " + colour + "\" d=\"M1 9H23\"/>") +
                        "<g class=\"mark " + colour + "\">" + marked(s, 12, 9, kMark, "") + "</g>",
                    s.name);
  }
  return out;
}

}  // namespace

std::string drawn(const Plot& plot, Size size) { return Picture(plot, size).draw(""); }

std::string figure(const Plot& plot) {
  return svg::figure(Picture(plot, kWide).draw("wide"), Picture(plot, kNarrow).draw("narrow"), keys(plot));
}

std::string_view plot_style() {
  return R"(
figure { margin: 1rem 0; }
.plot { display: block; width: 100%; height: auto; overflow: visible; font: 13px system-ui, sans-serif; }
.plot.narrow { display: none; }
@media (max-width: 640px) { .plot.wide { display: none; } .plot.narrow { display: block; } }
.plot.key { display: inline-block; width: 24px; height: 18px; vertical-align: -4px; margin-right: 0.35rem; }
.plot text { fill: var(--ink); stroke: none; }
.plot .tick { fill: var(--faint); }
.plot .title { font-weight: 600; }
.plot .label { font-weight: 700; paint-order: stroke; stroke: var(--paper); stroke-width: 3px; }
.plot .grid { stroke: var(--rule); stroke-width: 1; }
.plot .guide { stroke: var(--faint); stroke-width: 1; stroke-dasharray: 2 4; }
.plot .line { fill: none; stroke: currentColor; stroke-width: 1; }
.plot .line.ink { stroke-width: 2; }
.plot .bars { fill: currentColor; fill-opacity: 0.35; stroke: currentColor; stroke-width: 0.5; }
.plot .mark { fill: currentColor; fill-opacity: 0.35; stroke: currentColor; stroke-width: 1.5; }
.plot .ink { color: var(--ink); } .plot .mark.ink { fill: none; stroke-width: 2; }
.plot .c0 { color: var(--c0); } .plot .c1 { color: var(--c1); } .plot .c2 { color: var(--c2); }
.plot .c3 { color: var(--c3); } .plot .c4 { color: var(--c4); } .plot .c5 { color: var(--c5); }
.heat .cell { font-size: 12px; } .heat .measured, .key .measured { fill: var(--ink); }
)";
}

}  // namespace assur::pictures
