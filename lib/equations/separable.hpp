// Separable equations: sums over the unknowns, in which no product has two different unknowns:
//
//   Phi_i = g_i + sum_j s_ij (a_ij x_j + b_ij)^2 + l_ij x_j
//
// Most irreducible groups are of this kind: distances to known points, and dot products with known vectors.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "equations/coefficients.hpp"

namespace assur {

// Coefficients and registers are those of a class; the register of a form holds its known part.
struct Separable {
  static constexpr std::int32_t kNone = -1;

  struct Square {
    std::int32_t s = kNone;  // coefficient; kNone: 0
    std::int32_t a = kNone;  // coefficient; kNone: 1
    std::int32_t b = kNone;  // register; kNone: 0
  };
  struct Linear {  // part of l: coefficient * slope * register
    std::int32_t equation, unknown, coefficient;
    std::int32_t slope;  // coefficient; kNone: 1
    std::int32_t reg;
  };
  struct Known {  // part of g: coefficient * register
    std::int32_t equation, coefficient, reg;
  };

  std::vector<Square> squares;  // n x n, by rows
  std::vector<Linear> linear, moving_linear;
  std::vector<Known> known, moving_known;  // moving: the part whose register has a rate
};

// The separable form of a class; empty if there is none.
[[nodiscard]] std::optional<Separable> separate(const GroupClass& group_class);

// True for distances: each equation is a sum of (b_ij + x_j)^2, or of (b_ij - x_j)^2, and a constant g_i.
[[nodiscard]] bool measures_distances(const Separable& separable, const GroupClass& group_class);

}  // namespace assur
