// Mechanisms that are written twice: with joints, and by hand with points, vectors and constraints, with the fewest
// unknowns that were found. Both have the same outputs.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "assur/scene.hpp"

namespace assur::test {

struct WrittenTwice {
  std::string name;
  Scene joints, by_hand;
};

[[nodiscard]] std::vector<WrittenTwice> plane_mechanisms_by_hand();
[[nodiscard]] std::vector<WrittenTwice> space_mechanisms_by_hand();
// Four hinges whose axes meet in one point. away: distances of the hinges from this point, in the order of the loop.
[[nodiscard]] WrittenTwice spherical_four_bar(const std::array<double, 4>& away);

}  // namespace assur::test
