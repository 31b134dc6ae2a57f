// Plots: points and lines over two axes, as SVG within a page.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace assur::pictures {

struct Axis {
  std::string title;
  bool logarithmic = false;
  std::function<std::string(double)> text;  // text of a tick
};

struct Point {
  double x = 0, y = 0;
  std::string about = {};  // tooltip
  std::string label = {};  // shown beside the point if there is room
};

struct Series {
  enum class Mark : std::uint8_t { none, dot, square, triangle, cross, plus, diamond };
  // steps: first along x, then along y. bars: from each x to the next one with height y; the last point only ends a
  // bar.
  enum class Line : std::uint8_t { none, straight, steps, bars };

  std::string name;  // in the legend; empty: no entry
  std::vector<Point> points;
  int colour = 0;  // 0 to kColours - 1; kInk: that of the text
  Mark mark = Mark::dot;
  Line line = Line::none;

  static constexpr int kColours = 6, kInk = -1;
};

// A vertical line at a special x, with a text.
struct Guide {
  double x = 0;
  std::string text;
};

struct Plot {
  std::string title;  // text for screen readers
  Axis x, y;
  std::vector<Series> series;
  std::vector<Guide> guides;
};

struct Size {
  int width = 960, height = 560;  // units of the picture: pixels if it is not scaled
};

// Draws the plot. Leaves out points that an axis cannot show: not finite, or not above 0 on a logarithmic axis. The
// axes contain all other points and the guides.
[[nodiscard]] std::string drawn(const Plot& plot, Size size = {});

// A <figure> with legend, and with two pictures for wide and narrow windows.
[[nodiscard]] std::string figure(const Plot& plot);

// CSS for the elements of plots and heat maps, in light and dark colours.
[[nodiscard]] std::string_view plot_style();

}  // namespace assur::pictures
