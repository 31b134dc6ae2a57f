// Random planar linkages of dyads. Linkage k is a function of the seed and of k alone.
#pragma once

#include <cstdint>

#include "assur/fleet.hpp"

namespace assur::sweep {

// Numbers of joints, both included.
struct JointCounts {
  int least = 5, most = 20;

  // The smallest linkage is a four-bar: two grounds, a crank and a dyad.
  static constexpr int kFewest = 4, kMost = 1000;
};

// A crank about the origin turns once in a second; the other joints lie in the square from -1 to 1 m at time 0. A fifth
// of them are grounds; the others are dyads on two random joints that come before, and not flat at time 0.
void random_linkage(std::uint64_t seed, std::uint64_t k, JointCounts counts, Linkage& out);

}  // namespace assur::sweep
