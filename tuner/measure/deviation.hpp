// How far one motion is from another.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace assur::measure {

// The largest difference over the largest value of all columns of its kind (coordinates, velocities, ...); 0 only for
// the same bits. Rows of `columns` each; infinite if the lengths differ or are 0.
[[nodiscard]] double deviation(const std::vector<std::string>& columns, std::span<const double> a,
                               std::span<const double> b);

}  // namespace assur::measure
