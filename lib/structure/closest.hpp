// The posture that comes closest to the equations where none satisfies them.
#pragma once

#include <string>
#include <vector>

#include "assur/structure.hpp"

namespace assur {

struct ViolatedConstraint {
  std::string name;  // of a constraint, or as System::equation_name() has it
  double by = 0;     // |Phi| / |grad Phi|, the worst of its equations, SI units
  bool is_length = false;
};

struct ClosestPosture {
  std::vector<double> q;                     // all coordinates, internal units; drivers have the values of their laws
  std::vector<ViolatedConstraint> violated;  // the largest first
};

// Least squares of all equations at once, from the guess. `structure`: of a scene that cannot be assembled.
[[nodiscard]] ClosestPosture closest_posture(const Structure& structure);

}  // namespace assur
