// Matrices that solvers are timed with.
#pragma once

#include <string_view>
#include <vector>

#include "backends/matrices.hpp"

namespace assur::bench {

// `count` matrices of one pattern, values of each its own (of large ones, those of a few repeat): "ring" and "dense" of
// order n as the tests have them; "legs", n = 15: Jacobians of the groups SG_HS of platforms at their start postures.
[[nodiscard]] std::vector<test::Matrix> make_matrices(std::string_view kind, int n, int count);

}  // namespace assur::bench
