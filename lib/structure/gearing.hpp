// Gears whose equations also hold at other teeth.
#pragma once

#include "structure/blocks.hpp"

namespace assur {

// How fast gears turn.
struct Gearing {
  bool count_turns = false;  // a posture and the drivers' angles up to whole turns do not determine the tooth
  int teeth = 1;             // System::teeth
  double per_metre = 0;      // largest angle of a pinion for each metre of its rack, rad/m
};
[[nodiscard]] Gearing gearing(const System& system);

// The blocks with gears that count turns, and all blocks whose unknowns they read.
[[nodiscard]] Blocks blocks_of_gears(const System& system, const Blocks& blocks);

}  // namespace assur
