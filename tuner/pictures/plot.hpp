// Pictures of numbers: points and lines over two axes, as SVG that stands in a page.
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
  std::function<std::string(double)> text;  // of a tick
};

struct Point {
  double x = 0, y = 0;
  std::string about = {};  // shown where the pointer rests
  std::string label = {};  // beside the point, where there is room
};

struct Series {
  enum class Mark : std::uint8_t { none, dot, square, triangle, cross, plus, diamond };
  // steps: first along x, then along y. bars: from each x to the next one, as high as y; the last point only ends them.
  enum class Line : std::uint8_t { none, straight, steps, bars };

  std::string name;  // in the legend; empty: not there
  std::vector<Point> points;
  int colour = 0;  // of kColours; kInk: that of the text
  Mark mark = Mark::dot;
  Line line = Line::none;

  static constexpr int kColours = 6, kInk = -1;
};

// A value of x that means something.
struct Guide {
  double x = 0;
  std::string text;
};

struct Plot {
  std::string title;  // what is read to who cannot see it
  Axis x, y;
  std::vector<Series> series;
  std::vector<Guide> guides;
};

struct Size {
  int width = 960, height = 560;  // of the picture's own units: pixels where it is not scaled
};

// Points that an axis cannot show (not finite, or not above 0 where it is logarithmic) are left out. The axes span all
// others and the guides.
[[nodiscard]] std::string drawn(const Plot& plot, Size size = {});

// A <figure> with its legend, and the picture twice, for wide and narrow windows.
[[nodiscard]] std::string figure(const Plot& plot);

// What the classes of these elements, and of those of heat maps, look like, light and dark.
[[nodiscard]] std::string_view plot_style();

}  // namespace assur::pictures
