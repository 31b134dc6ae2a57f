// What is solved side by side.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "assur/backend.hpp"
#include "equations/lane_array.hpp"
#include "equations/program.hpp"
#include "simulation/lane_kernels.hpp"

namespace assur {

// W instances of a class. All arrays are owned by the simulator; lanes beyond `used` repeat lane 0.
struct Pack {
  std::int32_t group_class = 0;
  std::int32_t level = 0;
  std::int32_t used = 1;                 // lanes that hold a group
  std::vector<std::int32_t> groups;      // used: indices into Structure::groups
  std::size_t unknowns = 0;              // address of the first unknown in the state arrays
  std::vector<std::int32_t> inputs;      // inputs x W addresses in the state arrays
  std::vector<InputRow> input_rows;      // inputs: the same, where one address tells all
  LaneArray coefficients;                // (coefficients, 0, 1) x W
  LaneArray lipschitz;                   // equations x W
  LaneArray anchor;                      // by block, what it reads x W: where omega was measured
  LaneArray anchor_rates;                // the same: the rates there
  LaneArray anchor_time;                 // blocks: s; NaN: unknown, or no rates were asked for
  LaneArray omega;                       // blocks x W
  LaneArray ball_used;                   // blocks: part of the ball used at the last posture inside it
  LaneArray swaps;                       // of a small step: see SmallLu
  std::unique_ptr<LinearSolver> solver;  // with pivots or factors of its own; null: the class's serves
  bool factored = false;                 // +reuse=run: `solver` holds factors of an earlier posture
};

// Among the coefficients of a pack, after those of the program.
[[nodiscard]] inline std::int32_t zero_coefficient(const Program& p) {
  return static_cast<std::int32_t>(p.coefficients.size());
}
[[nodiscard]] inline std::int32_t one_coefficient(const Program& p) { return zero_coefficient(p) + 1; }

}  // namespace assur
