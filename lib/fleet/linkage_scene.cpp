#include <algorithm>
#include <cmath>
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
  const double steps[kTimes] = {};
  std::vector<JointBlock, LineAllocator<JointBlock>> at(prepared.joints().size());
  begin_at_guess(prepared.joints(), at.data());
  const BlockFigures figures = linkage_kernels().evaluate(prepared.joints(), times, steps, at.data());
  if (figures.closed < kTimes) {
    throw Error(
        Error::Kind::numerical,
        name + ": joint " + std::to_string(figures.joint) +
            " (counted from 0) is a dyad or begins a triad that is stretched, folded or cannot be closed at the "
            "first time");
  }
  // A joint of a triad in its approximate posture.
  const auto guess = [&](std::size_t j) { return PlanePoint{linkage.joints[j].value[1], linkage.joints[j].value[2]}; };
  SceneBuilder builder(std::move(name), 2);
  const auto joint_name = [](std::size_t j) { return "J" + std::to_string(j); };
  // own = first + along * (second - first)
  const auto put_on_line = [&](const std::string& own, const std::string& first, const std::string& second,
                               double along) {
    Linear on_line{{{own, 1}}, {}};
    if (along != 1) on_line.terms.emplace_back(first, along - 1);
    if (along != 0) on_line.terms.emplace_back(second, -along);
    builder.constrain(own + "_on_line", on_line);
  };
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
          put_on_line(own, first, second, joint.value[0]);
        } else {
          builder.constrain(own + "_first", Distance{first, own}).constrain(own + "_second", Distance{second, own});
        }
        break;
      case LinkageJoint::Kind::triad:
        builder.constrain(own + "_rod", Distance{first, own, joint.value[0]});
        if (prepared.joints()[j].place + 1 < static_cast<int>(kJointsOfTriad)) break;
        const PlanePoint a = guess(j - 2), b = guess(j - 1), c = guess(j);
        const auto side = [](const PlanePoint& p, const PlanePoint& q) { return std::hypot(p[0] - q[0], p[1] - q[1]); };
        const double x = b[0] - a[0], y = b[1] - a[1], u = c[0] - a[0], v = c[1] - a[1];
        builder.constrain(own + "_link", Distance{joint_name(j - 2), joint_name(j - 1), side(a, b)});
        if (x * v == y * u) {
          put_on_line(own, joint_name(j - 2), joint_name(j - 1), (x * u + y * v) / (x * x + y * y));
        } else {
          builder.constrain(own + "_first", Distance{joint_name(j - 2), own, side(a, c)})
              .constrain(own + "_second", Distance{joint_name(j - 1), own, side(b, c)});
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
