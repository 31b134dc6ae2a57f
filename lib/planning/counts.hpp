// The shape of what is to be solved, with everything counted that its time depends on.
#pragma once

#include <cstdint>

#include "assur/backend.hpp"
#include "assur/structure.hpp"

namespace assur {

// Of `count` matrices with one pattern. Operations: products of the factorisation, and one for each of its entries.
// Counting takes the time of a few hundred sparse factorisations;
// matrices with more than 24 nonzeros a row count as full.
[[nodiscard]] Shape shape_of(const Pattern& pattern, std::int32_t count = 1);

// Of the groups of a class, with the terms of their equations.
[[nodiscard]] Shape shape_of(const GroupClass& group_class, std::int32_t groups = 1);

}  // namespace assur
