#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "assur/fleet.hpp"
#include "fleet/linkage.hpp"

namespace assur {

Scene scene_of(const Linkage& linkage, const TimeGrid& time, std::string name) {
  PreparedLinkage prepared;
  if (const std::string trouble = prepared.take(linkage); !trouble.empty()) {
    throw Error(Error::Kind::input, name + ": " + trouble);
  }
  double times[kTimes];
  std::fill(std::begin(times), std::end(times), time.start);
  std::vector<JointBlock, LineAllocator<JointBlock>> at(prepared.joints().size());
  const BlockFigures figures = dyad_kernels().evaluate(prepared.joints(), times, at.data());
  if (figures.closed < kTimes) {
    throw Error(Error::Kind::numerical,
                name + ": joint " + std::to_string(figures.joint) +
                    " (counted from 0) is a dyad that is stretched, folded or cannot be closed at the first time");
  }
  SceneBuilder builder(std::move(name), 2);
  const auto joint_name = [](std::size_t j) { return "J" + std::to_string(j); };
  for (std::size_t j = 0; j < linkage.joints.size(); ++j) {
    const LinkageJoint& joint = linkage.joints[j];
    const std::string own = joint_name(j), first = joint_name(joint.first), second = joint_name(joint.second);
    const Triple place = {at[j].x[0], at[j].y[0], 0};
    builder.add(Point{own, place, joint.kind == LinkageJoint::Kind::ground});
    switch (joint.kind) {
      case LinkageJoint::Kind::ground:
        break;
      case LinkageJoint::Kind::crank:
        builder.constrain(own + "_crank", Distance{first, own, joint.value[0]})
            .drive(own + "_motor", PointAngle{first, own, "", Law::polynomial({joint.value[1], joint.value[2]})});
        break;
      case LinkageJoint::Kind::dyad:
        builder.constrain(own + "_first", Distance{first, own, joint.value[0]})
            .constrain(own + "_second", Distance{second, own, joint.value[1]});
        break;
      case LinkageJoint::Kind::point:
        if (joint.value[1] == 0) {
          Linear on_line{{{own, 1}}, {}};
          if (joint.value[0] != 1) on_line.terms.emplace_back(first, joint.value[0] - 1);
          if (joint.value[0] != 0) on_line.terms.emplace_back(second, -joint.value[0]);
          builder.constrain(own + "_on_line", on_line);
        } else {
          builder.constrain(own + "_first", Distance{first, own}).constrain(own + "_second", Distance{second, own});
        }
        break;
    }
  }
  // All joints: an output that needs only some of them would move on where the others jam.
  for (std::size_t j = 0; j < linkage.joints.size(); ++j) builder.output(joint_name(j) + ".position");
  builder.time(time.start, time.end, time.step);
  return std::move(builder).build();
}

}  // namespace assur
