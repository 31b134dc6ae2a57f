// Inputs and unknowns of one group at the start posture of its structure.
#pragma once

#include <vector>

#include "evaluation/coefficients.hpp"
#include "structure/grouped_system.hpp"

namespace assur::measure {

struct Posture {
  std::vector<double> coefficients;  // of the group_class
  std::vector<double> inputs, unknowns;
};

[[nodiscard]] Posture posture(const GroupedSystem& structure, const GroupClass& group_class, const SolvedGroup& group);

}  // namespace assur::measure
