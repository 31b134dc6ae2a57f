// Where everything lies: known and static coordinates first, each in its own place; then the unknowns of the packs as
// [pack][coordinate][lane].
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "group/group_solver.hpp"

namespace assur {

struct Layout {
  std::vector<std::int32_t> address;  // coordinates of the system -> index into the state arrays; -1: not computed
  std::size_t first_unknown = 0;
  std::size_t size = 0;
  std::vector<std::unique_ptr<GroupSolver>> solvers;  // classes
  std::vector<Pack> packs;                            // by level
};

// One for each class; lanes: instead of those that the plan has, 0: as planned.
// Throws Error (environment) if a backend of the plan cannot run here.
[[nodiscard]] std::vector<std::unique_ptr<GroupSolver>> make_solvers(const Prepared& prepared, int lanes = 0);

// Groups of one class on one level side by side, up to as many as the strategy has lanes.
// Throws Error (environment) if a backend of the plan cannot run here.
[[nodiscard]] Layout lay_out(const Prepared& prepared);

// For instances of the whole structure side by side, one in each lane: every group is a pack, and addresses, those of
// known coordinates as well, are of lane 0, the other lanes next to it. Nothing is bound to the lanes yet.
[[nodiscard]] Layout lay_out_side_by_side(const Prepared& prepared, int lanes);

}  // namespace assur
