// Positions of linkages against closed forms in quadruple precision.
#include <gtest/gtest.h>

#include "fleet/linkages.hpp"
#include "references/quad.hpp"

namespace assur::test {
namespace {

using references::Quad;

// Joints in quad, by the intersection of circles in another form: the law of cosines.
std::vector<std::array<Quad, 2>> posture(const Linkage& linkage, double t) {
  std::vector<std::array<Quad, 2>> at;
  for (const Joint& j : linkage.joints) {
    const auto& v = j.value;
    if (j.kind == Joint::Kind::ground) {
      at.push_back({v[0], v[1]});
    } else if (j.kind == Joint::Kind::crank) {
      const Quad angle = Quad(v[2]) * Quad(t) + Quad(v[1]);
      at.push_back({at[j.first][0] + v[0] * cos(angle), at[j.first][1] + v[0] * sin(angle)});
    } else {
      const auto &a = at[j.first], &b = at[j.second];
      const Quad dx = b[0] - a[0], dy = b[1] - a[1];
      if (j.kind == Joint::Kind::point) {
        at.push_back({a[0] + v[0] * dx - v[1] * dy, a[1] + v[0] * dy + v[1] * dx});
        continue;
      }
      const Quad d = sqrt(dx * dx + dy * dy), p = v[0], q = v[1];
      const Quad opening = acos((d * d + p * p - q * q) / (2 * d * p)) * (j.left ? 1 : -1);
      const Quad angle = atan2(dy, dx) + opening;
      at.push_back({a[0] + p * cos(angle), a[1] + p * sin(angle)});
    }
  }
  return at;
}

// The true error against the estimate, of linkages with all kinds of joints. The posture with the same sides is on the
// branch of the start.
TEST(FleetErrors, ErrorsAgainstClosedForms) {
  const std::vector<double> times = times_of(one_turn(100));
  std::size_t compared = 0;
  double worst = 0, most = 0;
  for (std::size_t i = 0; i < 400 && compared < 40; ++i) {
    Linkage linkage = random_one(i);
    const auto count = static_cast<std::uint16_t>(linkage.joints.size());
    linkage.joints.push_back(Joint::point(1, static_cast<std::uint16_t>(count - 1), 0.4, -0.3));
    linkage.joints.push_back(Joint::crank(count, 0.2, 1, -3 * kTurn));
    const Kept kept = run(linkage, times);
    if (!kept.motion.status.ok()) continue;
    ++compared;
    Quad error = 0, size = 0;
    for (std::size_t k = 0; k < times.size(); ++k) {
      const auto at = posture(linkage, times[k]).back();
      for (std::size_t c = 0; c < 2; ++c) {
        error = std::max<Quad>(error, abs(at[c] - kept.path[k][c]));
        size = std::max<Quad>(size, abs(at[c]));
      }
    }
    const double relative = static_cast<double>(error / size);
    EXPECT_LE(relative, 20 * kept.motion.error) << i;
    worst = std::max(worst, relative);
    most = std::max(most, kept.motion.error / std::max(relative, 1e-17));
  }
  EXPECT_EQ(compared, 40U);
  EXPECT_LT(worst, 1e-10);
  EXPECT_LT(most, 1e5) << "an estimate is useless if it is much too large";
}

// A triangle that is almost flat loses digits: the estimate says how many, and the status says if they are too many.
TEST(FleetErrors, LostDigitsAreInaccurate) {
  const double flat = 1e-12;
  Linkage linkage = four_bar(1, 3, 2.5, 3);
  linkage.joints.push_back(Joint::dyad(1, 3, 1.5 + flat, 1.5 + flat, true));
  const std::vector<double> times = times_of(one_turn(100));
  const Kept kept = run(linkage, times);
  Quad error = 0;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto at = posture(linkage, times[k]).back();
    for (std::size_t c = 0; c < 2; ++c) error = std::max<Quad>(error, abs(at[c] - kept.path[k][c]));
  }
  const double relative = static_cast<double>(error) / largest(kept.path);
  EXPECT_EQ(kept.motion.status.code, Code::ok);
  EXPECT_GT(relative, 1e-12);
  EXPECT_LE(relative, 20 * kept.motion.error);
  EXPECT_LE(kept.motion.error, 200 * relative);
  FleetOptions exact;
  exact.accuracy = 1e-12;
  const std::vector<Kept> doubted = run(Fleet({linkage}), times, exact);
  EXPECT_EQ(doubted[0].motion.status.code, Code::inaccurate);
  EXPECT_EQ(doubted[0].path, kept.path);
}

// Angles of many turns are rounded, whether the phase or the time makes them large.
TEST(FleetErrors, LargeAnglesAreCounted) {
  for (const double phase : {0.0, 1e6, -1e9, 1e11}) {
    for (const double start : {0.0, 1e6, 1e9}) {
      const Linkage linkage = four_bar(1, 3, 2.5, 3, phase);
      std::vector<double> times = times_of(one_turn(100));
      for (double& t : times) t = start + std::round(1024 * t) / 1024;
      const Kept kept = run(linkage, times);
      Quad error = 0;
      for (std::size_t k = 0; k < kept.path.size(); ++k) {
        const auto at = posture(linkage, times[k]).back();
        for (std::size_t c = 0; c < 2; ++c) error = std::max<Quad>(error, abs(at[c] - kept.path[k][c]));
      }
      const double relative = static_cast<double>(error) / largest(kept.path);
      EXPECT_LE(relative, 2 * kept.motion.error) << phase << ' ' << start;
      EXPECT_LE(kept.motion.error, 1000 * std::max(relative, kEps)) << phase << ' ' << start;
    }
  }
}

}  // namespace
}  // namespace assur::test
