// Output of `assur inspect`.
#pragma once

#include <cstdint>
#include <map>

#include "assur/motion_range.hpp"
#include "output/json.hpp"
#include "output/page.hpp"
#include "structure/grouped_system.hpp"

namespace assur::output {

// Irreducible groups after the elimination of linear equations.
struct Irreducible {
  std::int64_t groups = 0, eliminated = 0;
  std::map<std::int32_t, std::int64_t> sizes;  // unknowns of a group -> groups
  LeftOut left_out;                            // parts that a run in this formulation leaves out
};

// The irreducible groups of a structure in the formulation `irreducible`.
[[nodiscard]] Irreducible irreducible(const GroupedSystem& s);

[[nodiscard]] Json to_json(const Scene& scene, const GroupedSystem& s, const Irreducible& split);

void print(Page& page, const Scene& scene, const GroupedSystem& s, const Irreducible& split);

[[nodiscard]] Json to_json(const MotionRange& range);
void print(Page& page, const MotionRange& range);

}  // namespace assur::output
