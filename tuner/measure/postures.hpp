// Inputs and unknowns of one group at the start posture of its structure.
#pragma once

#include <vector>

#include "assur/structure.hpp"
#include "evaluation/coefficients.hpp"

namespace assur::measure {

struct Posture {
  std::vector<double> coefficients;  // of the group_class
  std::vector<double> inputs, unknowns;
};

[[nodiscard]] Posture posture(const Structure& structure, const GroupClass& group_class, const Group& group);

}  // namespace assur::measure
