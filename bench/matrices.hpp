// Matrices that solvers are timed with.
#pragma once

#include <string_view>
#include <vector>

#include "backends/matrices.hpp"

namespace assur::bench {

// `count` matrices of one pattern with different values (large matrices repeat the values of a few). "ring" and
// "dense": the matrices of order n of the tests. "legs", n = 15: Jacobians of the groups SG_HS of platforms at their
// start postures.
[[nodiscard]] std::vector<test::Matrix> make_matrices(std::string_view kind, int n, int count);

}  // namespace assur::bench
