// Difference of two motions.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace assur::measure {

// The largest difference, relative to the largest value of all columns of the same kind (coordinates, velocities, ...);
// 0 only if all bits are equal. a, b: rows x columns; infinite if the lengths differ or are 0.
[[nodiscard]] double deviation(const std::vector<std::string>& columns, std::span<const double> a,
                               std::span<const double> b);

}  // namespace assur::measure
