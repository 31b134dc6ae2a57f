// Joints. build() replaces joints, and bodies without a base, by objects that the rest of the library knows: points and
// vectors that bodies share, bases, members, and constraints. docs/joints.md gives the equations of each joint.
#pragma once

#include <string>
#include <vector>

#include "assur/scene.hpp"

namespace assur {

// The lists of a scene under construction.
struct JointParts {
  int dimension;
  const std::vector<Joint>& joints;
  std::vector<Point>& points;
  std::vector<Vector>& vectors;
  std::vector<Body>& bodies;
  std::vector<Constraint>& constraints;
  std::vector<Driver>& drivers;
  std::vector<Measure>& measures;
  std::vector<Limit>& limits;
  std::vector<std::string>& outputs;
  std::vector<Diagnostic>& warnings;
  const std::vector<Diagnostic>& found;  // earlier findings; nothing else is reported at, above or below their places
};

// True if there is something to expand.
[[nodiscard]] bool has_joints(const JointParts& parts);

// True if an output asks for a coordinate of a joint.
[[nodiscard]] bool asks_for_coordinate(const std::vector<Joint>& joints, const std::vector<std::string>& outputs);

// The reason why a joint without a point of its own is no output, with its outputs.
[[nodiscard]] std::string why_no_output(const Joint& joint);

// Expands all joints, all gears, and all bodies that only joints or `rigid` define. Returns findings; then the lists
// are as they were, and the findings mark the bodies that have no base.
[[nodiscard]] std::vector<Diagnostic> expand_joints(JointParts parts);

}  // namespace assur
