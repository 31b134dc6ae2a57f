// How wrong coordinates are that stand still: they were solved once, with the start posture. What was left in their
// equations, and perturbations as large as their rounding, carried through all of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "assur/structure.hpp"

namespace assur {

class StaticErrors {
 public:
  // A loaded plan has no equations of what stands still: then there is nothing here.
  StaticErrors(const System& system, const Structure& structure);

  // Structure::static_coordinates, or none.
  [[nodiscard]] std::span<const std::int32_t> coordinates() const { return coordinates_; }

  // errors[k * coordinates + i]: of coordinate i, for k = 0 from what was left in the equations, for k = 1 ... probes
  // from their rounding, with signs drawn by seed + k. q: all coordinates of a system of this structure; only what
  // stands still is read. Infinite where the matrix is singular.
  [[nodiscard]] std::vector<double> draw(const System& system, const std::vector<double>& q, std::size_t probes,
                                         std::uint64_t seed) const;

 private:
  std::vector<std::int32_t> coordinates_, equations_;
};

}  // namespace assur
