// Poses of bodies as outputs: build() gives a body that an output names an origin, axes and measures of its
// orientation. docs/joints.md lists the outputs.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "assur/scene.hpp"

namespace assur {

// The lists of a scene under construction.
struct PoseParts {
  int dimension;
  std::vector<Body>& bodies;
  std::vector<Measure>& measures;
  std::vector<std::string>& outputs;
};

// True if an output asks for the pose of a body, or for a part of it.
[[nodiscard]] bool asks_for_pose(const std::vector<Body>& bodies, const std::vector<std::string>& outputs);

// Replaces outputs such as "B" and "B.quaternion" by members and measures, and adds these. The frame of a body without
// one is that of the ground in the posture as written. To be called before joints are expanded. Returns, for each new
// output, the index of the written output; empty: nothing was replaced.
[[nodiscard]] std::vector<std::size_t> expand_poses(PoseParts parts);

}  // namespace assur
