#include "check/twin.hpp"

#include <cmath>
#include <optional>

#include "output/format.hpp"

namespace assur::check {

std::string other_bits(const Trajectory& a, const Trajectory& b) {
  if (a.rows() != b.rows() || a.columns() != b.columns()) return "the twin has other rows or columns";
  for (std::size_t c = 0; c < a.columns().size(); ++c) {
    std::optional<int> power;
    for (std::size_t k = 0; k < a.rows(); ++k) {
      if (a(k, c) == 0 && b(k, c) == 0) continue;
      int of_a = 0, of_b = 0;
      const bool same_digits = std::frexp(a(k, c), &of_a) == std::frexp(b(k, c), &of_b);
      if (!power) power = of_a - of_b;
      if (!same_digits || *power != of_a - of_b) {
        return a.columns()[c] + " differs in some bits in the twin's row " +
               output::grouped(static_cast<std::int64_t>(k));
      }
    }
  }
  return "";
}

}  // namespace assur::check
