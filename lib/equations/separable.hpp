// Equations that are a sum over their unknowns, with everything else known:
//
//   Phi_i = g_i + sum_j s_ij (a_ij x_j + b_ij)^2 + l_ij x_j
//
// Distances to known points and products with known vectors: most irreducible groups are of this kind.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "equations/program.hpp"

namespace assur {

// Coefficients and registers are those of a Program; a form's register stands for what is known of it.
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
  std::vector<Known> known, moving_known;  // moving: of them, those whose register has a rate
};

// input_moves: inputs, 0 if it never changes. Empty if the program is not of this kind.
[[nodiscard]] std::optional<Separable> separate(const Program& program, std::span<const std::uint8_t> input_moves);

}  // namespace assur
