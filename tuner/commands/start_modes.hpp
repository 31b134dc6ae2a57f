// The assembly modes in which a run starts: --start-mode and --guess.
#pragma once

#include <vector>

#include "assur/modes.hpp"
#include "commands/commands.hpp"

namespace assur::command {

// The choices of both options, in solving order. Throws Error: input if a group, a mode or a point does not exist, or
// if a group is chosen twice; otherwise as assembly_modes() does.
[[nodiscard]] std::vector<ModeChoice> chosen_modes(const Scene& scene, const ModeOptions& options);

// prepare(), or prepare_in_modes() if there are choices.
[[nodiscard]] Prepared prepare(const Scene& scene, const PrepareOptions& how, const std::vector<ModeChoice>& chosen);

}  // namespace assur::command
