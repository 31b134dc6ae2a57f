#include "structure/approach.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "scene/own_values.hpp"
#include "structure/assembly.hpp"
#include "structure/gearing.hpp"

namespace assur {
namespace {

constexpr double kFirst = 0.1;            // rad or internal units: length of the first step
constexpr double kLongestStride = 0.3;    // largest length
constexpr double kShortestStride = 1e-4;  // a step that fails at this length ends the search
constexpr double kStrideGrowth = 1.5;     // after a step that arrives

class Approach {
 public:
  Approach(const System& system, const Blocks& blocks, const DriverValues& from, const DriverValues& change,
           Branch branch, std::vector<Index>& column)
      : s_(system),
        blocks_(blocks),
        from_(from),
        change_(change),
        branch_(branch),
        column_(column),
        distance_(distance()),
        sign_(idx(blocks.size()), 0) {}

  bool run(std::vector<double>& q) {
    if (!(distance_ <= kMostApproachSteps * kLongestStride) || !step(0, q)) return false;
    std::vector<double> before = q, next;
    double at = 0, length = kFirst, last = 0;
    for (int steps = 0; at < 1; ++steps) {
      if (steps == kMostApproachSteps) return false;
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
  // The longest change of a driver, rad or internal units. With gears, the sum of all changes in teeth, so that no step
  // skips a tooth.
  [[nodiscard]] double distance() const {
    const Gearing gears = gearing(s_);
    double longest = 0, sum = 0;
    for (std::size_t i = 0; i < s_.inputs.size(); ++i) {
      const DriverInput& in = s_.inputs[i];
      for (std::size_t k = 0; k < change_[i].size(); ++k) {
        const double by = std::abs(change_[i][k]);
        const int power = in.kind == DriverInput::Kind::frame ? 1 : in.dimension;
        const double own =
            is_angle(s_, in, k) ? by : by * std::max(1 / s_.unit(power), power == 1 ? gears.per_metre : 0);
        longest = std::max(longest, own);
        sum += own;
      }
    }
    return gears.count_turns ? sum * gears.teeth : longest;
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
  const DriverValues &from_, &change_;
  Branch branch_;
  std::vector<Index>& column_;
  double distance_;
  std::vector<int> sign_;  // blocks: of the determinant
};

}  // namespace

bool approach(const System& system, const Blocks& blocks, const DriverValues& from, const DriverValues& change,
              Branch branch, std::vector<double>& q, std::vector<Index>& column) {
  return Approach(system, blocks, from, change, branch, column).run(q);
}

}  // namespace assur
