// Shapes with all operation counts that predictions of time need.
#pragma once

#include <cstdint>

#include "assur/backend.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// Shape of `count` matrices with one pattern. Operations: products of the factorisation, and one for each entry of L +
// U. Counting takes the time of a few hundred sparse factorisations. Matrices with more than 24 nonzeros in a row, on
// average, are counted as full.
[[nodiscard]] Shape shape_of(const Pattern& pattern, std::int32_t count = 1);

// Shape of the groups of a class, with the terms of their equations.
[[nodiscard]] Shape shape_of(const GroupClass& group_class, std::int32_t groups = 1);

}  // namespace assur
