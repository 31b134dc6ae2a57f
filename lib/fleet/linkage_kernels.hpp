// Joints of a planar linkage at eight times, side by side in the SIMD target of the machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "assur/fleet.hpp"
#include "parallel/cache_line.hpp"

namespace assur {

inline constexpr std::size_t kTimes = 8;

// A joint with what its evaluation needs.
struct PreparedJoint {
  LinkageJoint::Kind kind = LinkageJoint::Kind::ground;
  std::uint16_t first = 0, second = 0;
  double a = 0, b = 0, c = 0;  // LinkageJoint::value
  double difference = 0;       // dyad: (a - b) (a + b)
  double low = 0, high = 0;    // dyad: closer to its limits, postures cannot be told from stretched or folded ones
  double least = 0, most = 0;  // dyad: limits of the squared distance of its parents
  double per_square[2] = {};   // dyad: 1 / a^2, 1 / b^2
  double side = 0;             // dyad: 1 left, -1 right
  double rounding[2] = {};     // dyad, triad: rounding unit with a random sign, times a and b
  // Triad: a is the distance to the parent, (b, c) the place of the joint from the center of its link. The following of
  // the first joint only.
  int place = 0;          // 0, 1 or 2: which joint of its triad it is
  double center[2] = {};  // of the link in the approximate posture
  double radius = 0;      // of the link: its angle times this radius is a length like the coordinates of its center
  double curvature = 0;   // bound of the second derivatives of the three halved squared distances
};

inline constexpr std::size_t kJointsOfTriad = 3;

// A joint at the times of a block.
struct alignas(kLineBytes) JointBlock {
  double x[kTimes], y[kTimes], vx[kTimes], vy[kTimes];
  double error_x[kTimes], error_y[kTimes];  // by rounding, to first order
  // Of a dyad, the squared distance of its parents and its derivative: at the time before the block in [kBefore], at
  // its times in [kBefore + 1] and so on.
  // The joints of a triad have here the coordinates of the center of their link, and its angle times its radius.
  double square[2 * kTimes], rate[2 * kTimes];
  // Of the first joint of a triad, likewise: its curvature times the norm of its inverse Jacobian matrix.
  double sensitivity[2 * kTimes];

  static constexpr std::size_t kBefore = kTimes - 1;
};

// Figures of a block.
struct BlockFigures {
  double residual = 0;      // the largest relative one of all dyads, triads and times before the first failure
  unsigned closed = 0;      // number of times before the first one at which a dyad or triad cannot be closed
  std::int32_t joint = -1;  // this dyad, or the first joint of this triad
};

struct LinkageKernels {
  // Evaluates all joints. steps: lengths of the intervals that end at these times. blocks: one for each joint; those of
  // triads contain the time before the block.
  BlockFigures (*evaluate)(std::span<const PreparedJoint> joints, const double* times, const double* steps,
                           JointBlock* blocks);
  // Bit i: the interval from the time before times[i] to times[i] must be divided.
  unsigned (*doubtful)(std::span<const PreparedJoint> joints, const double* steps, const JointBlock* blocks);
};

[[nodiscard]] const LinkageKernels& linkage_kernels();

}  // namespace assur
