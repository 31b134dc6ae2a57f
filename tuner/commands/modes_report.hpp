// Output of `assur inspect --modes`.
#pragma once

#include <vector>

#include "assur/modes.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

[[nodiscard]] Json to_json(const Scene& scene, const std::vector<AssemblyModes>& groups);

void print(Page& page, const Scene& scene, const std::vector<AssemblyModes>& groups);

}  // namespace assur::output
