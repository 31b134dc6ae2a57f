#include "sweep/random_linkage.hpp"

#include <cmath>
#include <utility>
#include <vector>

#include "numbers.hpp"
#include "sweep/philox.hpp"

namespace assur::sweep {
namespace {

constexpr double kGrounds = 0.2;               // part of the joints
constexpr double kFlat = 0.2;                  // smallest sine of the angle at a dyad
constexpr double kShortest = 0.1;              // distance of a dyad from its parents, m
constexpr std::uint32_t kStream = 0x6c696e6b;  // apart from the numbers of design spaces

// Uniform numbers of one linkage.
class Numbers {
 public:
  Numbers(std::uint64_t seed, std::uint64_t k) : seed_(seed), k_(k) {}

  // In [0, 1).
  double operator()() {
    if (left_ == 0) {
      block_ = philox({next_++, low_half(k_), high_half(k_), kStream}, {low_half(seed_), high_half(seed_)});
      left_ = 4;
    }
    return block_[4 - left_--] * 0x1p-32;
  }
  double between(double low, double high) { return low + (high - low) * (*this)(); }
  // 0 to count - 1
  std::size_t below(std::size_t count) { return static_cast<std::size_t>((*this)() * static_cast<double>(count)); }

 private:
  std::uint64_t seed_, k_;
  std::uint32_t next_ = 0;
  std::array<std::uint32_t, 4> block_{};
  std::size_t left_ = 0;
};

struct Dyad {
  std::size_t first, second;
  PlanePoint at;
};

double sine_at(const Dyad& d, const PlanePoint& a, const PlanePoint& b, double& to_a, double& to_b) {
  const double ax = d.at[0] - a[0], ay = d.at[1] - a[1], bx = d.at[0] - b[0], by = d.at[1] - b[1];
  to_a = std::sqrt(ax * ax + ay * ay);
  to_b = std::sqrt(bx * bx + by * by);
  return (ax * by - ay * bx) / (to_a * to_b);
}

}  // namespace

void random_linkage(std::uint64_t seed, std::uint64_t k, JointCounts counts, Linkage& out) {
  Numbers number(seed, k);
  const auto joints =
      static_cast<std::size_t>(counts.least) + number.below(static_cast<std::size_t>(counts.most - counts.least) + 1);
  thread_local std::vector<PlanePoint> at;
  at.clear();
  out.joints.clear();
  out.traced = Linkage::kLast;
  const auto ground = [&](double x, double y) {
    at.push_back({x, y});
    out.joints.push_back(LinkageJoint::ground(x, y));
  };
  ground(0, 0);
  const double radius = number.between(0.1, 0.3), angle = number.between(0, kTurn);
  at.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  out.joints.push_back(LinkageJoint::crank(0, radius, angle, kTurn));
  ground(number.between(-1, 1), number.between(-1, 1));
  while (at.size() < joints) {
    if (number() < kGrounds && at.size() + 1 < joints) {
      ground(number.between(-1, 1), number.between(-1, 1));
      continue;
    }
    Dyad dyad{};
    double to_first = 0, to_second = 0, sine = 0;
    do {
      dyad.first = number.below(at.size());
      dyad.second = number.below(at.size() - 1);
      if (dyad.second >= dyad.first) ++dyad.second;
      dyad.at = {number.between(-1, 1), number.between(-1, 1)};
      const auto fixed = [&](std::size_t j) { return out.joints[j].kind == LinkageJoint::Kind::ground; };
      const bool moves = !fixed(dyad.first) || !fixed(dyad.second);
      sine = moves ? sine_at(dyad, at[dyad.first], at[dyad.second], to_first, to_second) : 0;
    } while (std::abs(sine) <= kFlat || to_first <= kShortest || to_second <= kShortest);
    at.push_back(dyad.at);
    out.joints.push_back(LinkageJoint::dyad(static_cast<std::uint16_t>(dyad.first),
                                            static_cast<std::uint16_t>(dyad.second), to_first, to_second, sine > 0));
  }
}

}  // namespace assur::sweep
