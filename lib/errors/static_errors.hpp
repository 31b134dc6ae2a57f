// Errors of static coordinates, which were solved once with the start posture: the residuals of their equations, and
// perturbations as large as rounding, carried through all of these equations.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "structure/grouped_system.hpp"

namespace assur {

// The static coordinates of a structure.
class StaticErrors {
 public:
  // A loaded plan has no equations of static coordinates; the list is then empty.
  StaticErrors(const System& system, const GroupedSystem& structure);

  // GroupedSystem::static_coordinates, or an empty list.
  [[nodiscard]] std::span<const std::int32_t> coordinates() const { return coordinates_; }

  // Errors [k * coordinates + i] of coordinate i: for k = 0 from the residuals of the equations, for k = 1 ... probes
  // from rounding, with signs drawn by seed + k. q: all coordinates of a system of this structure, of which the static
  // ones are read. known [(k - 1) * size of q + c]: error of the driven coordinate c; 0 for all others. Infinite if the
  // matrix is singular.
  [[nodiscard]] std::vector<double> draw(const System& system, const std::vector<double>& q,
                                         std::span<const double> known, std::size_t probes, std::uint64_t seed) const;

 private:
  std::vector<std::int32_t> coordinates_, equations_;
};

}  // namespace assur
