// Joints by a letter for their kind.
#pragma once

#include <string>

#include "assur/scene.hpp"
#include "scene/triple.hpp"

namespace assur::test {

// R, P, C, S, U, or E: a planar joint. axis: of a universal joint on `a`, which has its other axis, `second`, on `b`.
struct LetteredJoint {
  char letter;
  std::string name = {}, a = {}, b = {};
  Triple at{}, axis{}, second{};
};

inline SceneBuilder& add(SceneBuilder& builder, const LetteredJoint& j, int dimension = 3) {
  switch (j.letter) {
    case 'R':
      return builder.joint(j.name, dimension == 3 ? Revolute{j.a, j.b, j.at, j.axis} : Revolute{j.a, j.b, j.at});
    case 'P':
      return builder.joint(j.name, Prismatic{j.a, j.b, j.axis});
    case 'C':
      return builder.joint(j.name, Cylindrical{j.a, j.b, j.at, j.axis});
    case 'S':
      return builder.joint(j.name, Spherical{j.a, j.b, j.at});
    case 'U':
      return builder.joint(j.name, Universal{j.a, j.b, j.at, j.axis, j.second});
    default:
      return builder.joint(j.name, Planar{j.a, j.b, j.axis});
  }
}

// A vector at right angles to an axis.
inline Triple across(const Triple& axis) {
  const Triple x = triple::cross(axis, {1, 0, 0}), y = triple::cross(axis, {0, 1, 0});
  return triple::norm(x) > triple::norm(y) ? x : y;
}

}  // namespace assur::test
