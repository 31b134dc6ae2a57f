// Columns of results by name.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// Throws Error (input) for a name that is none, with what may be meant or all that there are.
[[nodiscard]] std::size_t column_index(const std::vector<std::string>& columns, std::string_view column);

// Which rates and accelerations of a row are NaN, and why that may be; "": none.
[[nodiscard]] std::string without_derivatives(const std::vector<std::string>& columns, std::span<const double> row);

}  // namespace assur
