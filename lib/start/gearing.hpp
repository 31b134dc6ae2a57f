// Gears whose equations also hold at other teeth.
#pragma once

#include <vector>

#include "start/walk.hpp"

namespace assur {

// True if a posture and the drivers' angles up to whole turns do not determine the teeth that mesh.
[[nodiscard]] bool count_turns(const System& system);

// The parts with such gears, and all parts whose unknowns they read.
[[nodiscard]] std::vector<WalkedPart> parts_of_gears(const System& system, const std::vector<WalkedPart>& parts);

}  // namespace assur
