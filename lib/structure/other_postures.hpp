// What the redundant and undetermined parts of a system are like at other postures than the start: whether an equation
// that was dropped follows from those that were kept, and how many freedoms there are without the drivers.
#pragma once

#include <vector>

#include "assur/structure.hpp"
#include "scene/system.hpp"

namespace assur {

// Parts of a system that are not regular at the start posture, or not by their structure.
struct DoubtfulParts {
  std::vector<Index> equations;  // all of them, those among known coordinates as well
  std::vector<Index> kept;       // an independent set of them
  std::vector<Index> unknowns;
};

// Judges `checks`, which out.redundant lists in the same order, and says so in out.notes; sets out.mobility and
// out.mobility_at_start. q is the start posture at `time`.
void look_at_other_postures(const System& system, const DoubtfulParts& parts, const std::vector<double>& q, double time,
                            Structure& out);

// Of an equation that does not hold: |Phi| / |grad Phi|, SI units, and whether that is a length.
struct Violation {
  double by = 0;
  bool is_length = false;
};
[[nodiscard]] bool is_length(const System& system, Index equation);
[[nodiscard]] Violation violation(const System& system, Index equation, const std::vector<double>& q);

}  // namespace assur
