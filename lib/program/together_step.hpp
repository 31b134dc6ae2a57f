// The step of all groups of a class at once, whatever their levels, in passes. Each group is linearised at the
// prediction, with inputs that other groups have not corrected yet:
//   J dx + H dh = -Phi      =>      dx = own + sum_k column_k load_k,   own = -J^-1 Phi,   column_k = J^-1 e_k
// Row k is an equation that reads unknowns of other groups, and load_k = -(H dh)_k is the effect of their changes on
// it. With the changes of those groups inserted, the loads of all groups are a linear recurrence through the levels:
//   load_k = -(H own)_k + sum_j gain_kj load_j,   gain_kj = -(H column_j)_k
// The rates and the accelerations have the same columns and gains at the solved posture, with their own right-hand
// sides. A pass reads and writes numbers of its own group only; between passes, motion/together.hpp brings what other
// groups computed, and runs the recurrence.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "backends/lanes_elimination.hpp"
#include "evaluation/coefficients.hpp"
#include "program/group_step.hpp"
#include "program/step_program.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

enum class TogetherPass : std::uint8_t {
  begin,          // scales; then as linearise
  linearise,      // equations, factors, own changes, columns and couplings
  approach,       // whether the first change is small enough: Memory::change, and Memory::sources of other groups
  rates,          // own rates: Memory::input_rates without those that groups compute
  accelerations,  // own accelerations, likewise, but with all input rates; measures the rates
  finish,         // measures the accelerations, with Memory::loads of those of other groups; the branch test
  anchors,        // see renew_anchors(); of kTogetherLanes groups only, because few of a class need one at a time
};
inline constexpr std::size_t kTogetherPasses = 7;

// Each lane tells GroupFigures. In place of its iterations, which are those of all lanes: 1 as long as its equations
// are not solved.
inline constexpr GroupFigure kOpen = GroupFigure::iterations;

inline constexpr int kTogetherLanes = 8;
// Number k of the group in lane l lies at [k stride + l].
struct TogetherShape {
  std::size_t stride;
  int lanes;  // a multiple of kTogetherLanes

  [[nodiscard]] int lanes_of(TogetherPass pass) const { return pass == TogetherPass::anchors ? kTogetherLanes : lanes; }
};

// What the equations of a class read of other groups.
struct Couplings {
  // -H of an equation and an input. Entries with the same row and part read the same group everywhere.
  struct Coupling {
    std::int32_t row, input;
    std::int32_t part = 0;
  };

  std::vector<std::int32_t> equations;  // coupled rows -> equations
  std::vector<Coupling> entries;        // by rows, and then by parts

  [[nodiscard]] std::int32_t rows() const { return static_cast<std::int32_t>(equations.size()); }
};
// Of each class: its inputs that another group computes in some group of the class.
[[nodiscard]] std::vector<Couplings> couplings_of(const GroupedSystem& structure);

// What the passes of a class need.
struct TogetherClass {
  const GroupClass& group_class;
  std::span<const std::int32_t> reads;  // coordinates of the branch test, as registers
  const Couplings& couplings;
  const lanes::Elimination& elimination;  // for more than kWithoutPivots unknowns
};

// Numbers of a group in Memory::work.
[[nodiscard]] std::size_t work_of_together_step(const GroupClass& group_class);
// For a class that why_not_together() allows.
[[nodiscard]] StepProgram together_program(TogetherPass pass, const TogetherClass& of, const TogetherShape& shape);

}  // namespace assur
