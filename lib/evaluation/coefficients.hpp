// The numbers of a group for the program of its class.
#pragma once

#include <cstdint>
#include <span>

#include "structure/grouped_system.hpp"

namespace assur {

// Indices of the coefficients 0 and 1 of a pack, which follow those of the class.
[[nodiscard]] inline std::int32_t zero_coefficient(const GroupClass& c) {
  return static_cast<std::int32_t>(c.coefficients.size());
}
[[nodiscard]] inline std::int32_t one_coefficient(const GroupClass& c) { return zero_coefficient(c) + 1; }

// True if all terms of an equation may vanish at once: unless each is a sum of squares and a constant, or an angle.
[[nodiscard]] bool terms_may_vanish(const GroupClass& group_class);

// Coefficients of instances side by side. constants: of the group x lanes; out: coefficients of the class x lanes
void bind_coefficients(const GroupClass& group_class, const double* constants, double* out, std::size_t lanes);

// Row-wise Lipschitz constants of the Jacobian of each irreducible block in the maximum norm:
// |J_i.(x) - J_i.(y)|_1 <= lipschitz_i |x - y|_inf, columns of the row's block only. Row i is
// sum_j,l |d2 Phi_i / dq_j dq_l| over the block's unknowns j and all moving coordinates l. Infinite for rows of
// callbacks and gears. Of instances side by side; coefficients: as bound; out: equations x lanes; lanes: at most
// kMostLanes
void lipschitz(const GroupClass& group_class, const double* coefficients, double* out, std::size_t lanes);

}  // namespace assur
