#include "structure/approach.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "index.hpp"
#include "scene/own_values.hpp"
#include "structure/assembly.hpp"

namespace assur {
namespace {

constexpr double kFirst = 0.1;            // rad or internal units: length of the first step
constexpr double kLongestStride = 0.3;    // largest length
constexpr double kShortestStride = 1e-4;  // a step that fails at this length ends the search
constexpr double kStrideGrowth = 1.5;     // after a step that arrives

class Approach {
 public:
  Approach(const System& system, const Blocks& blocks, const DriverValues& from, Branch branch,
           std::vector<Index>& column)
      : s_(system), blocks_(blocks), from_(from), branch_(branch), column_(column), sign_(idx(blocks.size()), 0) {}

  bool run(const DriverValues& to, const std::vector<Way>& way, std::vector<double>& q) {
    aim(to, way);
    if (!step(0, q)) return false;
    std::vector<double> before = q, next;
    double at = 0, length = kFirst, last = 0;
    while (at < 1) {
      const double target = std::min(1.0, at + (distance_ > 0 ? length / distance_ : 1));
      next = q;
      if (last > 0) {
        for (std::size_t c = 0; c < next.size(); ++c) next[c] += (q[c] - before[c]) * (target - at) / last;
      }
      std::vector<int> sign = sign_;
      if (step(target, next)) {
        last = target - at;
        before = std::exchange(q, next);
        at = target;
        length = std::min(length * kStrideGrowth, kLongestStride);
      } else {
        sign_ = std::move(sign);
        length /= 2;
        if (length < kShortestStride) return false;
      }
    }
    return true;
  }

 private:
  void aim(const DriverValues& to, const std::vector<Way>& way) {
    for (std::size_t i = 0; i < s_.inputs.size(); ++i) {
      const DriverInput& in = s_.inputs[i];
      std::vector<double> change = difference(s_, in, to[i], from_[i]);
      for (std::size_t k = 0; k < change.size(); ++k) {
        const bool angle =
            in.kind == DriverInput::Kind::direction || (in.kind == DriverInput::Kind::frame && k >= idx(s_.dimension));
        if (angle && way[i] == Way::longer) change[k] -= std::copysign(2 * std::numbers::pi, change[k]);
        distance_ =
            std::max(distance_, std::abs(change[k]) /
                                    (angle ? 1 : s_.unit(in.kind == DriverInput::Kind::frame ? 1 : in.dimension)));
      }
      change_.push_back(std::move(change));
    }
  }

  // Finds the posture at a share of the way from a nearby posture.
  bool step(double share, std::vector<double>& q) {
    DriverValues values = from_;
    for (std::size_t i = 0; i < values.size(); ++i) {
      for (std::size_t k = 0; k < values[i].size(); ++k) values[i][k] += share * change_[i][k];
    }
    drive_by_values(s_, values, q);
    for (Index b = 0; b < blocks_.size(); ++b) {
      const auto equations = blocks_.equations_of(b), unknowns = blocks_.unknowns_of(b);
      int any = 0;
      if (follow(s_, equations, unknowns, q, branch_ == Branch::same ? sign_[idx(b)] : any, column_)) continue;
      if (branch_ == Branch::same || !assemble(s_, equations, unknowns, q, column_).converged) return false;
    }
    return std::all_of(s_.positive.begin(), s_.positive.end(),
                       [&](const Positive& p) { return q[idx(p.coordinate)] > 0; });
  }

  const System& s_;
  const Blocks& blocks_;
  const DriverValues& from_;
  Branch branch_;
  std::vector<Index>& column_;
  DriverValues change_;
  double distance_ = 0;    // the longest change, rad or internal units
  std::vector<int> sign_;  // blocks: of the determinant
};

}  // namespace

bool approach(const System& system, const Blocks& blocks, const DriverValues& from, const DriverValues& to,
              const std::vector<Way>& way, Branch branch, std::vector<double>& q, std::vector<Index>& column) {
  return Approach(system, blocks, from, branch, column).run(to, way, q);
}

}  // namespace assur
