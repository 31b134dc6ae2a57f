// Columns of results by name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// Index of a column. Throws Error (input), with a suggestion or all names, if there is no such column.
[[nodiscard]] std::size_t column_index(const std::vector<std::string>& columns, std::string_view column);

// Rates and accelerations of a row that are NaN: their number, and the first of them.
struct Missing {
  std::array<std::int32_t, 4> first{};
  std::size_t count = 0;
};
[[nodiscard]] Missing missing_from(std::span<const double> row);
// A sentence about them; "": there are none.
[[nodiscard]] std::string without_derivatives(const std::vector<std::string>& columns, const Missing& missing);

}  // namespace assur
