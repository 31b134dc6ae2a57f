// Notes: findings that are not errors.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "output/page.hpp"
#include "structure/grouped_system.hpp"

namespace assur::output {

// Notes in order of importance: about the start posture (another one than intended), its drivers, and the scene
// (normalised vectors).
[[nodiscard]] std::vector<Diagnostic> notes(const Scene& scene, const GroupedSystem& structure);

// Reasons why libraries are slower here than they could be, with remedies; one for each library.
[[nodiscard]] std::vector<std::string> slowed(std::span<const Backend> table);

void print_notes(Page& page, const Scene& scene, const GroupedSystem& structure);

}  // namespace assur::output
