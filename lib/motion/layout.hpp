// Layout of the state arrays: known and static coordinates first, each at its own index, or at the index of the one
// that it copies; then the unknowns of the packs as [pack][coordinate][lane].
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "groups/group_solver.hpp"
#include "plan/preparation.hpp"

namespace assur {

// Addresses, solvers and packs of a structure.
struct Layout {
  std::vector<std::int32_t> address;  // coordinates of the system -> index into the state arrays; -1: not computed
  std::size_t first_unknown = 0;
  std::size_t size = 0;
  std::vector<std::unique_ptr<GroupSolver>> solvers;  // classes
  std::vector<Pack> packs;                            // by level
  std::vector<ChangePointPosture> change_points;      // packs; they exist where the mechanism stands on a change point
};

// Makes one solver for each class. lanes: replaces W of the plan; 0: as planned. code: null, or machine code for small
// steps. Throws Error (environment) if a backend of the plan cannot run here.
[[nodiscard]] std::vector<std::unique_ptr<GroupSolver>> make_solvers(const Preparation& prepared, int lanes,
                                                                     StepCode* code);

// A layout in which groups of one class on one level are side by side, up to W of them in a pack. With +together every
// group is a pack of one lane, and the unknowns of the groups of one class follow each other. Its solvers use no
// machine code yet. Throws Error (environment) if a backend of the plan cannot run here.
[[nodiscard]] Layout lay_out(const Preparation& prepared);

// A layout for several instances of the whole structure, one in each lane. Every group is a pack. Addresses, also of
// known coordinates, are those of lane 0; the other lanes follow. No instance is bound to the lanes yet.
[[nodiscard]] Layout lay_out_side_by_side(const Preparation& prepared, int lanes);

}  // namespace assur
