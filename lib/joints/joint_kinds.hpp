// What each kind of joint is.
#pragma once

#include <iterator>
#include <string_view>
#include <variant>

#include "assur/scene.hpp"

namespace assur::joints {

struct JointKind {
  std::string_view name;
  int translations, turns;  // equations in space that prevent them
  bool in_the_plane;        // a plane scene may have it, too
};

// In the order of Joint::kind.
inline constexpr JointKind kJointKinds[] = {
    {"revolute", 3, 2, true},   {"prismatic", 2, 3, true}, {"cylindrical", 2, 2, false}, {"spherical", 3, 0, false},
    {"universal", 3, 1, false}, {"planar", 1, 2, false},   {"fixed", 0, 0, true}};
static_assert(std::size(kJointKinds) == std::variant_size_v<decltype(Joint::kind)>);

[[nodiscard]] inline const JointKind& kind_of(const Joint& j) { return kJointKinds[j.kind.index()]; }

}  // namespace assur::joints
