// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fleet/dyad_kernels.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "equations/lane_vector-inl.hpp"
#include "fleet/dyad_kernels.hpp"
#include "signals/angle_kernels.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

using L = Lanes<static_cast<int>(kTimes)>;

// The largest turn of a crank between two times for which rates at both show what lies between, rad.
constexpr double kCrankTurn = 0.5;

HWY_INLINE void set_fixed(const PreparedJoint& joint, JointBlock& out) {
  const L zero = L::set(0);
  L::set(joint.a).store(out.x);
  L::set(joint.b).store(out.y);
  for (double* at : {out.vx, out.vy, out.error_x, out.error_y}) zero.store(at);
}

HWY_INLINE void turn_crank(const PreparedJoint& joint, const double* times, const JointBlock& first, JointBlock& out) {
  double angles[kTimes], sines[kTimes], cosines[kTimes];
  const L turn = L::set(joint.c) * L::load(times);
  (turn + L::set(joint.b)).store(angles);
  angle_kernels().sin_cos(angles, kTimes, sines, cosines);
  const L dx = L::set(joint.a) * L::load(cosines), dy = L::set(joint.a) * L::load(sines), speed = L::set(joint.c);
  (L::load(first.x) + dx).store(out.x);
  (L::load(first.y) + dy).store(out.y);
  (L::load(first.vx) - speed * dy).store(out.vx);
  (L::load(first.vy) + speed * dx).store(out.vy);
  // The rounding of the angle turns the crank.
  const L lost = L::set(joint.rounding[0]) * (abs(turn) + L::set(1));
  (L::load(first.error_x) - lost * dy).store(out.error_x);
  (L::load(first.error_y) + lost * dx).store(out.error_y);
}

HWY_INLINE void carry_point(const PreparedJoint& joint, const JointBlock& first, const JointBlock& second,
                            JointBlock& out) {
  const L along = L::set(joint.a), across = L::set(joint.b);
  const auto carry = [&](const double* ax, const double* ay, const double* bx, const double* by, double* x, double* y) {
    const L fx = L::load(ax), fy = L::load(ay), dx = L::load(bx) - fx, dy = L::load(by) - fy;
    (fx + along * dx - across * dy).store(x);
    (fy + along * dy + across * dx).store(y);
  };
  carry(first.x, first.y, second.x, second.y, out.x, out.y);
  carry(first.vx, first.vy, second.vx, second.vy, out.vx, out.vy);
  carry(first.error_x, first.error_y, second.error_x, second.error_y, out.error_x, out.error_y);
}

// Meets two circles. False in lanes whose circles do not meet in two points.
HWY_INLINE L::Mask close_dyad(const PreparedJoint& joint, const JointBlock& first, const JointBlock& second,
                              JointBlock& out, L& residual) {
  const L ax = L::load(first.x), ay = L::load(first.y), bx = L::load(second.x), by = L::load(second.y);
  const L dx = bx - ax, dy = by - ay;
  L square = dx * dx;
  square.add_product(dy, dy);
  const L low = square - L::set(joint.least), high = L::set(joint.most) - square, zero = L::set(0);
  const L::Mask closed = less(zero, low) & less(zero, high);
  const L half = L::set(0.5), inverse = L::set(1) / square, root = sqrt(low * high);
  L u = half;
  u.add_product(L::set(0.5 * joint.difference), inverse);
  const L w = L::set(0.5 * joint.side) * root * inverse;
  const L ex = u * dx - w * dy, ey = u * dy + w * dx, x = ax + ex, y = ay + ey;
  const L fx = x - bx, fy = y - by, gx = x - ax, gy = y - ay;
  x.store(out.x);
  y.store(out.y);

  // Residuals of the rounded posture.
  const L one = L::set(1);
  const L of_a = abs((gx * gx + gy * gy) * L::set(joint.per_square[0]) - one);
  const L of_b = abs((fx * fx + fy * fy) * L::set(joint.per_square[1]) - one);
  residual = max_if_finite(max_if_finite(residual, of_a), of_b);

  // e . v = e . va and f . v = f . vb, with the determinant e x f = w d^2. The same with rounding errors.
  const L per_cross = L::set(2 * joint.side) / root;
  const auto solve = [&](const L& r, const L& s, double* to_x, double* to_y) {
    ((r * fy - s * gy) * per_cross).store(to_x);
    ((s * gx - r * fx) * per_cross).store(to_y);
  };
  const auto along = [](const L& px, const L& py, const double* qx, const double* qy) {
    L sum = px * L::load(qx);
    sum.add_product(py, L::load(qy));
    return sum;
  };
  solve(along(gx, gy, first.vx, first.vy), along(fx, fy, second.vx, second.vy), out.vx, out.vy);
  const L size = abs(x) + abs(y);
  L r = along(gx, gy, first.error_x, first.error_y), s = along(fx, fy, second.error_x, second.error_y);
  r.add_product(L::set(joint.rounding[0]), size + L::set(joint.a));
  s.add_product(L::set(joint.rounding[1]), size + L::set(joint.b));
  solve(r, s, out.error_x, out.error_y);

  const L rate = dx * (L::load(second.vx) - L::load(first.vx)) + dy * (L::load(second.vy) - L::load(first.vy));
  square.store(out.square + kTimes);
  (rate + rate).store(out.rate + kTimes);
  return closed;
}

BlockFigures evaluate(std::span<const PreparedJoint> joints, const double* times, JointBlock* blocks) {
  constexpr unsigned kAll = (1U << kTimes) - 1;
  BlockFigures out{0, kTimes, -1};
  L residual = L::set(0);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const PreparedJoint& joint = joints[j];
    JointBlock& block = blocks[j];
    const JointBlock &first = blocks[joint.first], &second = blocks[joint.second];
    switch (joint.kind) {
      case LinkageJoint::Kind::ground:
        set_fixed(joint, block);
        break;
      case LinkageJoint::Kind::crank:
        turn_crank(joint, times, first, block);
        break;
      case LinkageJoint::Kind::point:
        carry_point(joint, first, second, block);
        break;
      case LinkageJoint::Kind::dyad: {
        const L::Mask closed = close_dyad(joint, first, second, block, residual);
        if (HWY_LIKELY(closed.all())) break;
        const auto before = static_cast<unsigned>(std::countr_zero(~closed.bits() & kAll));
        if (before >= out.closed) break;
        out.closed = before;
        out.joint = static_cast<std::int32_t>(j);
      }
    }
  }
  double each[kTimes];
  residual.store(each);
  for (unsigned i = 0; i < out.closed; ++i) out.residual = std::max(out.residual, each[i]);
  return out;
}

// Within two times, a cubic with the values and rates at both lies between the smallest and the largest of its four
// control values (Farin, Curves and Surfaces for CAGD, 2002: convex hull). An interval is divided if they come closer
// to a limit than they are apart from the straight line.
unsigned doubtful(std::span<const PreparedJoint> joints, const double* steps, const JointBlock* blocks) {
  const L step = L::load(steps), third = L::set(1.0 / 3);
  unsigned divide = 0;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const PreparedJoint& joint = joints[j];
    if (joint.kind == LinkageJoint::Kind::crank) {
      divide |= ~less_equal(abs(L::set(joint.c) * step), L::set(kCrankTurn)).bits();
    }
    if (joint.kind != LinkageJoint::Kind::dyad) continue;
    const double *square = blocks[j].square, *rate = blocks[j].rate;
    const L from = L::load(square + JointBlock::kBefore), to = L::load(square + kTimes), change = to - from;
    const L begin = step * L::load(rate + JointBlock::kBefore), end = step * L::load(rate + kTimes);
    const L bend = (abs(begin - change) + abs(end - change)) * third;
    const L p = from + begin * third, q = to - end * third;
    const L least = L::set(joint.low) + bend, most = L::set(joint.high) - bend;
    const L::Mask clear = less(least, p) & less(least, q) & less(p, most) & less(q, most);
    if (HWY_UNLIKELY(!clear.all())) divide |= ~clear.bits();
  }
  return divide & ((1U << kTimes) - 1);
}

constexpr DyadKernels kKernels = {evaluate, doubtful};
const DyadKernels* kernels() { return &kKernels; }

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(kernels);

const DyadKernels& dyad_kernels() { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace assur
#endif
