#include "fleet/linkage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "numbers.hpp"
#include "signals/random_sign.hpp"

namespace assur {
namespace {

using Kind = LinkageJoint::Kind;

// Positions, squares and residuals round a few times each.
constexpr double kRounding = 2 * kEps;

int parents_of(Kind kind) { return kind == Kind::ground ? 0 : kind == Kind::crank ? 1 : 2; }

std::string trouble_with(const LinkageJoint& joint, std::size_t own) {
  if (joint.kind > Kind::point) return "has no kind";
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
  if ((crank || dyad) && !allowed(joint.value[0])) return "needs a positive length, 1e-60 to 1e60 m";
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

}  // namespace

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
  double sum = 0;
  int lengths = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const LinkageJoint& joint = linkage.joints[j];
    if (const std::string trouble = trouble_with(joint, j); !trouble.empty()) return at(j, trouble);
    joints_.push_back(prepared(joint, j));
    const bool dyad = joint.kind == Kind::dyad;
    dyads_ += dyad ? 1 : 0;
    if (!dyad && joint.kind != Kind::crank) continue;
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
