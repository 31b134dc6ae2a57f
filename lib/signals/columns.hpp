// Columns of results by name.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// Index of a column. Throws Error (input), with a suggestion or all names, if there is no such column.
[[nodiscard]] std::size_t column_index(const std::vector<std::string>& columns, std::string_view column);

// A sentence about the rates and accelerations of a row that are NaN; "": there are none.
[[nodiscard]] std::string without_derivatives(const std::vector<std::string>& columns, std::span<const double> row);

}  // namespace assur
