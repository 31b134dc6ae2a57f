// Examines redundant and undetermined parts of a system at other postures than the start: does a dropped equation
// follow from the kept ones, and how many degrees of freedom are there without the drivers?
#pragma once

#include <vector>

#include "equations/system.hpp"
#include "start/findings.hpp"

namespace assur {

// Parts of a system that are singular at the start posture or structurally singular.
struct DoubtfulParts {
  std::vector<Index> equations;  // all equations, including those among known coordinates
  std::vector<Index> kept;       // an independent subset of the equations
  std::vector<Index> unknowns;
};

// Sets the kind of each redundant equation (out.redundant, in the order of out.checks) and adds notes; sets
// out.mobility and out.mobility_at_start. q is the start posture at `time`.
void look_at_other_postures(const System& system, const DoubtfulParts& parts, const std::vector<double>& q, double time,
                            StartFindings& out);

// Violation of an equation: |Phi| / |grad Phi|, SI units; is_length: in m.
struct Violation {
  double by = 0;
  bool is_length = false;
};
[[nodiscard]] bool is_length(const System& system, Index equation);
[[nodiscard]] Violation violation(const System& system, Index equation, const std::vector<double>& q);

}  // namespace assur
