// The columns of a trajectory, put together as they are plotted.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "assur/structure.hpp"

namespace assur::pictures {

// A scalar, or a point or vector with its components; or one of their derivatives.
struct Quantity {
  std::string output;                // "C", "rocker_angle": what it is the value or a derivative of
  std::string title;                 // "C, velocity"
  std::string unit;                  // "m/s"; empty: none
  std::vector<std::size_t> columns;  // indices into Trajectory::columns()
};

// Everything that the scene's outputs name, in the order in which it is shown: as asked for; of a scene that wants
// everything scalars come first, such as its measures.
[[nodiscard]] std::vector<Quantity> quantities(const Structure& structure);

}  // namespace assur::pictures
