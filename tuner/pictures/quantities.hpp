// Groups the columns of a trajectory for plotting.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "assur/structure.hpp"

namespace assur::pictures {

// A scalar, or a point or vector with its components; or one of their derivatives.
struct Quantity {
  std::string output;                // "C", "rocker_angle": the output
  std::string title;                 // "C, velocity"
  std::string unit;                  // "m/s"; empty: none
  std::vector<std::size_t> columns;  // indices into Trajectory::columns()
};

// All outputs of a scene in the order of the plots: the order in which they are named; without named outputs, scalars
// such as measures come first.
[[nodiscard]] std::vector<Quantity> quantities(const Structure& structure);

}  // namespace assur::pictures
