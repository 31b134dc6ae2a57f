// Gears whose equations also hold at other teeth.
#pragma once

#include <optional>
#include <vector>

#include "assur/structure.hpp"
#include "structure/walk.hpp"

namespace assur {

// True if a posture and the drivers' angles up to whole turns do not determine the teeth that mesh.
[[nodiscard]] bool count_turns(const System& system);

// The numbers of a gear for a class; empty: the callback is none.
[[nodiscard]] std::optional<GroupClass::Gear> gear_of_class(const CallbackBlock& block);
// Fills the gears of a class, whose callbacks are those of the system.
void find_gears(const System& system, GroupClass& group_class);

// The parts with such gears, and all parts whose unknowns they read.
[[nodiscard]] std::vector<WalkedPart> parts_of_gears(const System& system, const std::vector<WalkedPart>& parts);

}  // namespace assur
