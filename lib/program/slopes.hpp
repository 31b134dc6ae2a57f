// The slopes of the equations of a class along inputs that other groups compute, for steps of all levels at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "equations/coefficients.hpp"
#include "equations/separable.hpp"

namespace assur {

struct Slopes {
  static constexpr std::int32_t kNone = -1;

  // Addend of a slope: share * coefficient * slope * factor.
  struct Term {
    std::int32_t coefficient, slope, share;  // coefficients
    std::int32_t square, unknown;            // factor: 2 u_ij, x_j, or 1 (both kNone)
  };
  // An equation that reads such an input. Entries with the same row and part read the same group everywhere.
  struct Entry {
    std::int32_t row, input;
    std::size_t begin, end;  // terms
    std::int32_t part = 0;
  };

  std::vector<std::int32_t> equations;  // coupled rows -> equations
  std::vector<Entry> entries;           // by rows, and then by parts
  std::vector<Term> terms;

  [[nodiscard]] std::int32_t rows() const { return static_cast<std::int32_t>(equations.size()); }
};

// computed: inputs, 1 if another group computes the input in some group of the class.
[[nodiscard]] Slopes slopes_of(const GroupClass& group_class, const Separable& separable,
                               std::span<const std::uint8_t> computed);

}  // namespace assur
