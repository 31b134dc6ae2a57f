// Heat maps: which of several answers holds in each cell of a grid, as SVG that stands in a page.
#pragma once

#include <string>
#include <vector>

namespace assur::pictures {

struct HeatMap {
  struct Kind {
    std::string name;     // in the legend
    int colour = 0;       // as of Series
    double strength = 1;  // 0 to 1: how much of the colour
  };
  struct Cell {
    int kind = -1;           // of kinds; -1: empty
    std::string text = {};   // where there is room; where there is less, the name of the kind
    std::string about = {};  // shown where the pointer rests
    bool marked = false;
  };

  std::string title;  // what is read to who cannot see it
  std::string x_title, y_title;
  std::vector<std::string> columns, rows;  // left to right, from below
  std::vector<Cell> cells;                 // rows x columns
  std::vector<Kind> kinds;
  std::string mark;  // what a marked cell means
};

// A <figure> with its legend, for wide and narrow windows as that of a Plot.
[[nodiscard]] std::string figure(const HeatMap& map);

}  // namespace assur::pictures
