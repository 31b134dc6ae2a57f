// Shapes with all operation counts that predictions of time need.
#pragma once

#include <cstdint>
#include <vector>

#include "assur/backend.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// Shape of `count` matrices with one pattern. Operations: products of the factorisation, and one for each entry of L +
// U. Counting takes the time of a few hundred sparse factorisations. Matrices with more than 24 nonzeros in a row, on
// average, are counted as full.
[[nodiscard]] Shape shape_of(const Pattern& pattern, std::int32_t count = 1);

// Shape of the groups of a class, with the terms of their equations.
[[nodiscard]] Shape shape_of(const GroupClass& group_class, std::int32_t groups = 1);

// Shape of every class with its groups, in the order of the classes.
[[nodiscard]] std::vector<Shape> class_shapes(const GroupedSystem& structure);

// Sizes of what a step does besides its groups.
struct AroundCounts {
  std::int64_t unknowns = 0;  // which are predicted
  std::int64_t columns = 0;   // of the outputs
  // Terms of linear outputs. Any other output, and terms of watched equations, count as some of them.
  std::int64_t pieces = 0;
};
[[nodiscard]] AroundCounts around_counts(const GroupedSystem& structure);

// Shape of a whole step, for Kernel::step: sums over all groups. Steps that differ in their groups, levels or outputs
// have different patterns. shapes: class_shapes()
[[nodiscard]] Shape shape_of_step(const GroupedSystem& structure, const std::vector<Shape>& shapes);

}  // namespace assur
