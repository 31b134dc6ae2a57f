#include "fleet/linkage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "numbers.hpp"
#include "outputs/random_sign.hpp"

namespace assur {
namespace {

using Kind = LinkageJoint::Kind;

// Positions, squares and residuals round a few times each.
constexpr double kRounding = 2 * kEps;

int parents_of(Kind kind) { return kind == Kind::ground ? 0 : kind == Kind::crank || kind == Kind::triad ? 1 : 2; }

std::string trouble_with(const LinkageJoint& joint, std::size_t own) {
  if (joint.kind > Kind::triad) return "has no kind";
  const int parents = parents_of(joint.kind);
  if ((parents > 0 && joint.first >= own) || (parents > 1 && joint.second >= own)) {
    return "must come after its parents; sort the joints";
  }
  if (parents > 1 && joint.first == joint.second) return "needs two different parents";
  if (!std::all_of(joint.value.begin(), joint.value.end(), [](double v) { return std::isfinite(v); })) {
    return "has a value that is not finite";
  }
  const bool crank = joint.kind == Kind::crank, dyad = joint.kind == Kind::dyad;
  // Squares of these lengths, and their products, neither overflow nor vanish.
  const auto allowed = [](double length) { return length >= 1e-60 && length <= 1e60; };
  const bool triad = joint.kind == Kind::triad;
  if ((crank || dyad || triad) && !allowed(joint.value[0])) return "needs a positive length, 1e-60 to 1e60 m";
  if (dyad && !allowed(joint.value[1])) return "needs two positive lengths, 1e-60 to 1e60 m";
  return {};
}

PreparedJoint prepared(const LinkageJoint& joint, std::size_t own) {
  PreparedJoint out;
  out.kind = joint.kind;
  out.first = joint.first;
  out.second = joint.second;
  out.a = joint.value[0];
  out.b = joint.value[1];
  out.c = joint.value[2];
  RandomSign sign(own + 1);
  out.rounding[0] = sign() * kRounding;
  if (joint.kind == Kind::triad) {
    out.per_square[0] = 1 / (out.a * out.a);
    out.rounding[0] *= out.a;
  }
  if (joint.kind != Kind::dyad) return out;
  out.difference = (out.a - out.b) * (out.a + out.b);
  out.least = (out.a - out.b) * (out.a - out.b);
  out.most = (out.a + out.b) * (out.a + out.b);
  out.low = out.least + kTouches * out.most;
  out.high = out.most - kTouches * out.most;
  out.per_square[0] = 1 / (out.a * out.a);
  out.per_square[1] = 1 / (out.b * out.b);
  out.side = joint.left ? 1 : -1;
  out.rounding[0] *= out.a;
  out.rounding[1] = sign() * kRounding * out.b;
  return out;
}

// The joints `own`, own + 1 and own + 2 are a triad.
std::string trouble_with_triad(std::span<const LinkageJoint> joints, std::size_t own) {
  if (joints.size() < own + kJointsOfTriad) return "begins a triad that has no three joints";
  for (std::size_t k = 0; k < kJointsOfTriad; ++k) {
    const LinkageJoint &joint = joints[own + k], &next = joints[own + (k + 1) % kJointsOfTriad];
    if (joint.kind != Kind::triad) return "begins a triad that has no three joints, one after another";
    if (joint.first >= own) return "begins a triad of which a joint depends on another of its joints";
    if (joint.value[1] == next.value[1] && joint.value[2] == next.value[2]) {
      return "begins a triad of which two joints are in one place";
    }
  }
  return {};
}

// Sets what the three joints of a triad have in common.
void complete_triad(PreparedJoint* triad) {
  PreparedJoint& first = triad[0];
  for (std::size_t k = 0; k < kJointsOfTriad; ++k) {
    first.center[0] += triad[k].b / kJointsOfTriad;
    first.center[1] += triad[k].c / kJointsOfTriad;
  }
  for (std::size_t k = 0; k < kJointsOfTriad; ++k) {
    triad[k].place = static_cast<int>(k);
    triad[k].b -= first.center[0];
    triad[k].c -= first.center[1];
    first.radius = std::max(first.radius, std::hypot(triad[k].b, triad[k].c));
  }
  double squares = 0;
  for (std::size_t k = 0; k < kJointsOfTriad; ++k) {
    // |center + R(angle) r - parent|^2 / 2 has the second derivatives 1, r and at most r^2 + a r.
    const double r = std::hypot(triad[k].b, triad[k].c) / first.radius;
    const double of_one = 1 + r + r * (r + triad[k].a / first.radius);
    squares += of_one * of_one;
  }
  first.curvature = std::sqrt(squares);
}

}  // namespace

void begin_at_guess(std::span<const PreparedJoint> joints, JointBlock* blocks) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].kind != Kind::triad || joints[j].place != 0) continue;
    for (std::size_t k = 0; k < kJointsOfTriad; ++k) {
      blocks[j + k].square[JointBlock::kBefore] = k < 2 ? joints[j].center[k] : 0;
      blocks[j + k].rate[JointBlock::kBefore] = 0;
    }
  }
}

std::string PreparedLinkage::take(const Linkage& linkage) {
  const auto at = [](std::size_t j, const std::string& trouble) {
    return "joint " + std::to_string(j) + " (counted from 0) " + trouble;
  };
  const std::size_t count = linkage.joints.size();
  if (count == 0) return "has no joint";
  if (count > 65536) return "has more than 65536 joints";
  traced_ = linkage.traced == Linkage::kLast ? count - 1 : linkage.traced;
  if (traced_ >= count) return at(traced_, "is to be traced, but does not exist");
  joints_.clear();
  dyads_ = 0;
  has_triads_ = false;
  std::size_t triad_end = 0;  // end of the latest triad
  double sum = 0;
  int lengths = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const LinkageJoint& joint = linkage.joints[j];
    if (const std::string trouble = trouble_with(joint, j); !trouble.empty()) return at(j, trouble);
    joints_.push_back(prepared(joint, j));
    const bool dyad = joint.kind == Kind::dyad, triad = joint.kind == Kind::triad;
    if (triad && j >= triad_end) {
      if (const std::string trouble = trouble_with_triad(linkage.joints, j); !trouble.empty()) return at(j, trouble);
      triad_end = j + kJointsOfTriad;
      has_triads_ = true;
    }
    if (triad && j + 1 == triad_end) complete_triad(&joints_[j + 1 - kJointsOfTriad]);
    dyads_ += dyad || (triad && j + 1 == triad_end) ? 1 : 0;
    if (!dyad && !triad && joint.kind != Kind::crank) continue;
    sum += joint.value[0] + (dyad ? joint.value[1] : 0);
    lengths += dyad ? 2 : 1;
  }
  mean_length_ = lengths > 0 ? sum / lengths : 1;
  return {};
}

Linkage Linkage::at_posture(std::span<const std::array<int, 2>> parents, std::span<const PlanePoint> positions,
                            double speed) {
  const auto refuse = [](std::size_t j, const char* what) {
    throw Error(Error::Kind::input, "joint " + std::to_string(j) + " (counted from 0) " + what);
  };
  if (parents.size() != positions.size()) {
    throw Error(Error::Kind::input, std::to_string(parents.size()) + " joints have parents, but " +
                                        std::to_string(positions.size()) + " have positions");
  }
  if (parents.size() > 65536) throw Error(Error::Kind::input, "a linkage has at most 65536 joints");
  Linkage out;
  for (std::size_t j = 0; j < parents.size(); ++j) {
    const auto [first, second] = parents[j];
    const auto [x, y] = positions[j];
    if (first < 0 && second < 0) {
      out.joints.push_back(LinkageJoint::ground(x, y));
      continue;
    }
    if (first < 0) refuse(j, "has a second parent but no first one; the parent of a crank comes first: {0, -1}");
    if (std::cmp_greater_equal(first, j) || std::cmp_greater_equal(second, j)) {
      refuse(j, "must come after its parents; sort the joints");
    }
    const PlanePoint& a = positions[static_cast<std::size_t>(first)];
    const double ax = x - a[0], ay = y - a[1], to_a = std::hypot(ax, ay);
    if (second < 0) {
      out.joints.push_back(LinkageJoint::crank(static_cast<std::uint16_t>(first), to_a, std::atan2(ay, ax), speed));
      continue;
    }
    const PlanePoint& b = positions[static_cast<std::size_t>(second)];
    const double bx = x - b[0], by = y - b[1];
    out.joints.push_back(LinkageJoint::dyad(static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(second), to_a,
                                            std::hypot(bx, by), ax * by - ay * bx > 0));
  }
  return out;
}

}  // namespace assur
