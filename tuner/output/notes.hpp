// What is no error but should be known.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/structure.hpp"
#include "output/page.hpp"

namespace assur::output {

// In order of importance: of the start posture (another one than meant), of its drivers, then of the scene (vectors
// that had to be normalised).
[[nodiscard]] std::vector<Diagnostic> notes(const Scene& scene, const Structure& structure);

// Why libraries are slower than they could be here, and what helps; once, however many solvers share one.
[[nodiscard]] std::vector<std::string> slowed(std::span<const Backend> table);

void print_notes(Page& page, const Scene& scene, const Structure& structure);

}  // namespace assur::output
