// The posture closest to the equations of a scene that cannot be assembled.
#pragma once

#include <string>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// A constraint that does not hold there.
struct ViolatedConstraint {
  std::string name;  // name of the constraint, else System::equation_name()
  double by = 0;     // largest |Phi| / |grad Phi| of its equations, SI units
  bool is_length = false;
};

// The result of closest_posture().
struct ClosestPosture {
  std::vector<double> q;                     // all coordinates, internal units; drivers have the values of their laws
  std::vector<ViolatedConstraint> violated;  // the largest first
};

// Minimises the sum of squares of all equations, from the guess. The system is that of a scene that cannot be
// assembled.
[[nodiscard]] ClosestPosture closest_posture(const System& system);

}  // namespace assur
