// Heat maps: one of several answers for each cell of a grid, as SVG within a page.
#pragma once

#include <string>
#include <vector>

namespace assur::pictures {

struct HeatMap {
  struct Kind {
    std::string name;     // in the legend
    int colour = 0;       // see Series
    double strength = 1;  // saturation of the colour, 0 to 1
  };
  struct Cell {
    int kind = -1;           // index into kinds; -1: empty
    std::string text = {};   // shown if there is room, else the name of the kind
    std::string about = {};  // tooltip
    bool marked = false;
  };

  std::string title;  // text for screen readers
  std::string x_title, y_title;
  std::vector<std::string> columns, rows;  // columns from left to right, rows from below
  std::vector<Cell> cells;                 // rows x columns
  std::vector<Kind> kinds;
  std::string mark;  // meaning of marked cells
};

// A <figure> with legend, for wide and narrow windows like that of a Plot.
[[nodiscard]] std::string figure(const HeatMap& map);

}  // namespace assur::pictures
