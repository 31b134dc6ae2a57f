// What is no error but should be known, for `inspect` and `run`.
#pragma once

#include <vector>

#include "assur/structure.hpp"
#include "output/page.hpp"

namespace assur::output {

// Of the scene (a vector that had to be normalised, ...), then of its start posture.
[[nodiscard]] std::vector<Diagnostic> notes(const Scene& scene, const Structure& structure);

void print_notes(Page& page, const Scene& scene, const Structure& structure);

}  // namespace assur::output
