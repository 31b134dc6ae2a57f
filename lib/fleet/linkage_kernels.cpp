// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fleet/linkage_kernels.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "evaluation/lane_vector-inl.hpp"
#include "fleet/linkage_kernels.hpp"
#include "outputs/angle_kernels.hpp"

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
  const L turn = L::set(joint.c) * L::load(times), angle = turn + L::set(joint.b);
  angle.store(angles);
  angle_kernels().sin_cos(angles, kTimes, sines, cosines);
  const L dx = L::set(joint.a) * L::load(cosines), dy = L::set(joint.a) * L::load(sines), speed = L::set(joint.c);
  (L::load(first.x) + dx).store(out.x);
  (L::load(first.y) + dy).store(out.y);
  (L::load(first.vx) - speed * dy).store(out.vx);
  (L::load(first.vy) + speed * dx).store(out.vy);
  // The rounding of the angle turns the crank.
  const L lost = L::set(joint.rounding[0]) * (abs(turn) + abs(angle) + L::set(1));
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

// A triad at a pose of its link.
struct TriadPosture {
  L rx[3], ry[3];          // joints from the center of the link
  L ex[3], ey[3], et[3];   // gradients of the halved squared distances, by center and angle times radius
  L cross[3][3], inverse;  // cofactors of each row of this matrix, and one over its determinant

  HWY_INLINE TriadPosture(const PreparedJoint* triad, const JointBlock* blocks, const L (&pose)[3]) {
    const L per_radius = L::set(1 / triad[0].radius);
    double angles[kTimes], sines[kTimes], cosines[kTimes];
    (pose[2] * per_radius).store(angles);
    angle_kernels().sin_cos(angles, kTimes, sines, cosines);
    const L c = L::load(cosines), s = L::load(sines);
    for (int k = 0; k < 3; ++k) {
      const L b = L::set(triad[k].b), h = L::set(triad[k].c);
      rx[k] = c * b - s * h;
      ry[k] = s * b + c * h;
      ex[k] = pose[0] + rx[k] - L::load(blocks[triad[k].first].x);
      ey[k] = pose[1] + ry[k] - L::load(blocks[triad[k].first].y);
      et[k] = (rx[k] * ey[k] - ry[k] * ex[k]) * per_radius;
    }
    for (int k = 0; k < 3; ++k) {
      const int p = (k + 1) % 3, q = (k + 2) % 3;
      cross[k][0] = ey[p] * et[q] - et[p] * ey[q];
      cross[k][1] = et[p] * ex[q] - ex[p] * et[q];
      cross[k][2] = ex[p] * ey[q] - ey[p] * ex[q];
    }
    inverse = L::set(1) / (ex[0] * cross[0][0] + ey[0] * cross[0][1] + et[0] * cross[0][2]);
  }

  // The change of the pose with these products of gradients and change.
  HWY_INLINE void solve(const L (&products)[3], L (&change)[3]) const {
    for (int c = 0; c < 3; ++c) {
      L sum = products[0] * cross[0][c];
      sum.add_product(products[1], cross[1][c]);
      sum.add_product(products[2], cross[2][c]);
      change[c] = sum * inverse;
    }
  }

  // Norm of the inverse matrix.
  HWY_INLINE L of_inverse() const {
    L sum = L::set(0);
    for (const auto& row : cross) {
      for (const L& x : row) sum.add_product(x, x);
    }
    return sqrt(sum) * abs(inverse);
  }
};

constexpr int kMostNewton = 20;  // a choice: Newton's method doubles the digits of the pose of the time before
constexpr double kSettled = 1e-13, kConverged = 1e-9;  // corrections, relative to the size of the pose

// Leads a triad from the time before the block to its times. False in lanes in which Newton's method fails.
HWY_INLINE L::Mask close_triad(const PreparedJoint* triad, const JointBlock* blocks, const double* steps,
                               JointBlock* out, L& residual) {
  double since[kTimes], sum = 0;
  for (std::size_t i = 0; i < kTimes; ++i) since[i] = sum += steps[i];
  const L half = L::set(0.5), one = L::set(1);
  L pose[3], change[3], products[3];
  for (int c = 0; c < 3; ++c) {
    pose[c] = L::set(out[c].square[JointBlock::kBefore]);
    pose[c].add_product(L::set(out[c].rate[JointBlock::kBefore]), L::load(since));
  }
  L last = one, size = one;
  for (int i = 0; i < kMostNewton; ++i) {
    const TriadPosture at(triad, blocks, pose);
    for (int k = 0; k < 3; ++k) {
      L square = at.ex[k] * at.ex[k];
      square.add_product(at.ey[k], at.ey[k]);
      products[k] = half * (L::set(triad[k].a * triad[k].a) - square);
    }
    at.solve(products, change);
    last = abs(change[0]) + abs(change[1]) + abs(change[2]);
    for (int c = 0; c < 3; ++c) pose[c] = pose[c] + change[c];
    size = abs(pose[0]) + abs(pose[1]) + L::set(triad[0].radius);
    if (less(L::set(kSettled) * size, last).bits() == 0) break;  // NaN will not settle
  }
  const L::Mask closed = less_equal(last, L::set(kConverged) * size);

  const TriadPosture at(triad, blocks, pose);
  (at.of_inverse() * L::set(triad[0].curvature)).store(out[0].sensitivity + kTimes);
  L errors[3];
  for (int k = 0; k < 3; ++k) {
    const L x = pose[0] + at.rx[k], y = pose[1] + at.ry[k];
    x.store(out[k].x);
    y.store(out[k].y);
    const JointBlock& parent = blocks[triad[k].first];
    const L ex = x - L::load(parent.x), ey = y - L::load(parent.y);
    residual = max_if_finite(residual, abs((ex * ex + ey * ey) * L::set(triad[k].per_square[0]) - one));
    products[k] = ex * L::load(parent.vx) + ey * L::load(parent.vy);
    errors[k] = ex * L::load(parent.error_x) + ey * L::load(parent.error_y);
    errors[k].add_product(L::set(triad[k].rounding[0]), abs(x) + abs(y) + L::set(triad[k].a));
    pose[k].store(out[k].square + kTimes);
  }
  const auto move = [&](const L(&by)[3], double* (*to)(JointBlock&, int)) {
    const L turn = by[2] * L::set(1 / triad[0].radius);
    for (int k = 0; k < 3; ++k) {
      (by[0] - turn * at.ry[k]).store(to(out[k], 0));
      (by[1] + turn * at.rx[k]).store(to(out[k], 1));
    }
  };
  at.solve(products, change);
  move(change, [](JointBlock& b, int c) { return c == 0 ? b.vx : b.vy; });
  for (int c = 0; c < 3; ++c) change[c].store(out[c].rate + kTimes);
  at.solve(errors, change);
  move(change, [](JointBlock& b, int c) { return c == 0 ? b.error_x : b.error_y; });
  return closed;
}

BlockFigures evaluate(std::span<const PreparedJoint> joints, const double* times, const double* steps,
                      JointBlock* blocks) {
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
      case LinkageJoint::Kind::triad:
        if (joint.place > 0) break;
        [[fallthrough]];
      case LinkageJoint::Kind::dyad: {
        const L::Mask closed = joint.kind == LinkageJoint::Kind::dyad
                                   ? close_dyad(joint, first, second, block, residual)
                                   : close_triad(&joint, blocks, steps, &block, residual);
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

// A triad passes an interval if the bend of its motion is small against the distance to other postures, and if the
// gradients, which change with the pose and the parents, stay independent: the inverse of their matrix bounds both.
constexpr double kMostBend = 0.1, kMostChange = 1;

HWY_INLINE L::Mask is_clear(const PreparedJoint* triad, const JointBlock* blocks, const JointBlock* own,
                            const L& step) {
  const L zero = L::set(0);
  L bends = zero, ways = zero, moved = zero;
  for (int c = 0; c < 3; ++c) {
    const L from = L::load(own[c].square + JointBlock::kBefore), way = L::load(own[c].square + kTimes) - from;
    const L begin = step * L::load(own[c].rate + JointBlock::kBefore) - way;
    const L end = step * L::load(own[c].rate + kTimes) - way;
    bends.add_product(begin, begin);
    bends.add_product(end, end);
    ways.add_product(way, way);
    const JointBlock& parent = blocks[triad[c].first];
    moved = moved + abs(L::load(parent.vx)) + abs(L::load(parent.vy));
  }
  const L bend = sqrt(bends);
  const L sensitivity = max(L::load(own[0].sensitivity + JointBlock::kBefore), L::load(own[0].sensitivity + kTimes));
  const L change = bend + sqrt(ways) + step * moved * L::set(1 / triad[0].curvature);
  return less_equal(sensitivity * bend, L::set(kMostBend)) & less_equal(sensitivity * change, L::set(kMostChange));
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
    if (joint.kind == LinkageJoint::Kind::triad && joint.place == 0) {
      divide |= ~is_clear(&joint, blocks, &blocks[j], step).bits();
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

constexpr LinkageKernels kKernels = {evaluate, doubtful};
const LinkageKernels* kernels() { return &kKernels; }

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(kernels);

const LinkageKernels& linkage_kernels() { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace assur
#endif
