// Triads of fleets: against the simulator, against Newton's method in quadruple precision, and at the ends of motions.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <map>
#include <string>

#include "backends/allocations.hpp"
#include "fleet/linkages.hpp"
#include "properties/random_count.hpp"
#include "references/quad.hpp"
#include "refusal.hpp"

namespace assur::test {
namespace {

using references::Quad;

Fleet of_triads(std::size_t linkages) {
  return {linkages, [](std::size_t i, Linkage& to) { to = with_triad(i); }};
}

double deviation(const std::vector<PlanePoint>& path, const Trajectory& t) {
  const std::size_t column = t.columns().size() - 2;
  double out = 0;
  for (std::size_t k = 0; k < path.size(); ++k) {
    out = std::max({out, std::abs(path[k][0] - t(k, column)), std::abs(path[k][1] - t(k, column + 1))});
  }
  return out;
}

TEST(FleetTriads, MotionsAreThoseOfTheSimulator) {
  const TimeGrid grid = one_turn(200);
  const int linkages = test::random_count(300);
  const std::vector<Kept> motions = run(of_triads(static_cast<std::size_t>(linkages)), times_of(grid));
  std::map<Code, int> codes;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    SCOPED_TRACE("linkage " + std::to_string(i));
    const auto& [motion, path] = motions[i];
    ++codes[motion.status.code];
    if (path.empty()) continue;
    Simulator simulator(prepare(scene_of(with_triad(i), grid)));
    const Trajectory t = simulator.run();
    EXPECT_EQ(name(motion.status.code), name(simulator.report().status.code));
    ASSERT_EQ(path.size(), t.rows());
    EXPECT_EQ(t.columns().back(), "J7.y");
    const double estimated = motion.error + simulator.report().error.estimated_position.value_or(0);
    EXPECT_LE(deviation(path, t) / largest(path), 100 * estimated);
    EXPECT_LE(motion.residual, 1e-12);
    if (!motion.status.arrived()) {
      EXPECT_EQ(motion.joint, 5);
      EXPECT_NEAR(motion.reached, simulator.report().reached, 1e-6);
      EXPECT_LE(motion.reached, motion.not_beyond);
      EXPECT_NEAR(motion.not_beyond, motion.reached, 1e-8);
    }
  }
  EXPECT_GT(codes[Code::ok], linkages / 4);
  EXPECT_GT(codes[Code::fold], linkages / 4);
  EXPECT_EQ(codes[Code::ok] + codes[Code::fold] + codes[Code::not_assembled], linkages);
}

// Newton's method passes near other postures, to which a coarse grid invites.
TEST(FleetTriads, FewTimesGiveTheSameMotion) {
  const std::vector<double> fine = times_of(one_turn(400));
  std::vector<double> coarse;
  for (std::size_t k = 0; k < fine.size(); k += 50) coarse.push_back(fine[k]);
  const Fleet fleet = of_triads(static_cast<std::size_t>(test::random_count(1500)));
  const std::vector<Kept> all = run(fleet, fine), few = run(fleet, coarse);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(name(all[i].motion.status.code), name(few[i].motion.status.code)) << i;
    if (all[i].path.empty()) continue;
    EXPECT_NEAR(all[i].motion.reached, few[i].motion.reached, 1e-8) << i;
    for (std::size_t k = 0; k < few[i].path.size(); ++k) {
      for (std::size_t c = 0; c < 2; ++c) EXPECT_NEAR(few[i].path[k][c], all[i].path[50 * k][c], 1e-9) << i;
    }
  }
}

TEST(FleetTriads, BitsDependOnTheLinkageAlone) {
  const std::vector<double> times = times_of(one_turn(150));
  const Fleet fleet = of_triads(200);
  FleetOptions two;
  two.threads = 2;
  const std::vector<Kept> one_thread = run(fleet, times), two_threads = run(fleet, times, two);
  for (std::size_t i = 0; i < fleet.members(); ++i) {
    EXPECT_EQ(one_thread[i].path, two_threads[i].path) << i;
    if (i % 10 == 0) {
      EXPECT_EQ(one_thread[i].path, run(with_triad(i), times).path) << i;
    }
  }
}

TEST(FleetTriads, InstructionSetsAgree) {
  const std::vector<double> times = times_of(one_turn(100));
  const Fleet fleet = of_triads(300);
  const std::vector<Kept> best = run(fleet, times);
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & -left);
    const std::vector<Kept> other = run(fleet, times);
    hwy::SetSupportedTargetsForTest(0);
    for (std::size_t i = 0; i < best.size(); ++i) {
      EXPECT_EQ(name(other[i].motion.status.code), name(best[i].motion.status.code)) << i;
      ASSERT_EQ(other[i].path.size(), best[i].path.size()) << i;
      for (std::size_t k = 0; k < best[i].path.size(); ++k) {
        EXPECT_NEAR(other[i].path[k][0], best[i].path[k][0], 1e-8) << i;
      }
    }
  }
}

// The joints of the triad of with_triad(), by Newton's method in quadruple precision from the posture of the fleet.
std::array<Quad, 2> last_joint(const Linkage& linkage, double t, const PlanePoint& near, double angle) {
  const std::vector<Joint>& joints = linkage.joints;
  const auto& crank = joints[1].value;
  const Quad turn = Quad(crank[2]) * Quad(t) + Quad(crank[1]);
  const std::array<Quad, 2> a = {crank[0] * cos(turn), crank[0] * sin(turn)}, b = {joints[2].value[0], Quad(0)};
  const Quad dx = b[0] - a[0], dy = b[1] - a[1], p = joints[3].value[0], q = joints[3].value[1];
  const Quad d = sqrt(dx * dx + dy * dy), along = (d * d + p * p - q * q) / (2 * d);
  const Quad across = sqrt(p * p - along * along);
  const std::array<Quad, 2> coupler = {a[0] + (along * dx - across * dy) / d, a[1] + (along * dy + across * dx) / d};
  const std::array<std::array<Quad, 2>, 3> parents = {a, coupler, {joints[4].value[0], joints[4].value[1]}};
  // Unknowns: the last joint, and the angle of the link.
  Quad x = near[0], y = near[1], w = angle;
  for (int i = 0; i < 8; ++i) {
    Quad m[3][4];
    for (std::size_t k = 0; k < 3; ++k) {
      const Quad u = Quad(joints[5 + k].value[1]) - joints[7].value[1];
      const Quad v = Quad(joints[5 + k].value[2]) - joints[7].value[2];
      const Quad rx = cos(w) * u - sin(w) * v, ry = sin(w) * u + cos(w) * v;
      const Quad ex = x + rx - parents[k][0], ey = y + ry - parents[k][1], l = joints[5 + k].value[0];
      m[k][0] = ex, m[k][1] = ey, m[k][2] = rx * ey - ry * ex, m[k][3] = (l * l - ex * ex - ey * ey) / 2;
    }
    const auto determinant = [&](std::size_t c0, std::size_t c1, std::size_t c2) {
      return Quad(m[0][c0] * (m[1][c1] * m[2][c2] - m[1][c2] * m[2][c1]) -
                  m[0][c1] * (m[1][c0] * m[2][c2] - m[1][c2] * m[2][c0]) +
                  m[0][c2] * (m[1][c0] * m[2][c1] - m[1][c1] * m[2][c0]));
    };
    const Quad whole = determinant(0, 1, 2);
    x += determinant(3, 1, 2) / whole;
    y += determinant(0, 3, 2) / whole;
    w += determinant(0, 1, 3) / whole;
  }
  return {x, y};
}

TEST(FleetTriads, ErrorsAgainstQuadruplePrecision) {
  const std::vector<double> times = times_of(one_turn(60));
  std::size_t compared = 0;
  for (std::size_t i = 0; compared < 40; ++i) {
    Linkage linkage = with_triad(i);
    const Kept last = run(linkage, times);
    if (!last.motion.status.ok()) continue;
    linkage.traced = 5;
    const Kept first = run(linkage, times);
    ++compared;
    Quad error = 0;
    const auto& of_first = linkage.joints[5].value;
    const auto& of_last = linkage.joints[7].value;
    const double guess = std::atan2(of_first[2] - of_last[2], of_first[1] - of_last[1]);
    for (std::size_t k = 0; k < times.size(); ++k) {
      const PlanePoint &p = first.path[k], &q = last.path[k];
      const double angle = std::atan2(p[1] - q[1], p[0] - q[0]) - guess;
      const auto at = last_joint(linkage, times[k], q, angle);
      for (std::size_t c = 0; c < 2; ++c) error = std::max<Quad>(error, abs(at[c] - q[c]));
    }
    const double relative = static_cast<double>(error) / largest(last.path);
    EXPECT_LE(relative, 20 * last.motion.error) << i;
    EXPECT_LE(relative, 1e-10) << i;
    EXPECT_LE(last.motion.error, 1e5 * std::max(relative, 1e-16)) << i;
  }
}

// The same linkage in other units, far away, and in a chain.
TEST(FleetTriads, SizesAndPlacesDoNotMatter) {
  const std::vector<double> times = times_of(one_turn(50));
  for (std::size_t i = 0; i < 40; ++i) {
    const Kept kept = run(with_triad(i), times);
    for (const double scale : {1e-6, 1e-2, 1e3, 1e8}) {
      Linkage other = with_triad(i);
      for (Joint& j : other.joints) {
        const bool all = j.kind != Joint::Kind::crank;
        for (std::size_t k = 0; k < (all ? 3 : 1); ++k) j.value[k] *= scale;
      }
      const Kept scaled = run(other, times);
      EXPECT_EQ(name(scaled.motion.status.code), name(kept.motion.status.code)) << i << " " << scale;
      ASSERT_EQ(scaled.path.size(), kept.path.size());
      for (std::size_t k = 0; k < kept.path.size(); ++k) {
        EXPECT_NEAR(scaled.path[k][0] / scale, kept.path[k][0], 1e-9) << i << " " << scale;
      }
    }
  }
}

// A second triad and a dyad on the first one; points in line.
TEST(FleetTriads, ChainsOfTriads) {
  const TimeGrid grid = one_turn(100);
  int complete = 0;
  for (std::size_t i = 0; i < 150; ++i) {
    Linkage linkage = with_triad(i);
    const Kept first = run(linkage, times_of(grid));
    if (!first.motion.status.ok()) continue;
    const auto [x, y] = first.path[0];
    linkage.joints.push_back(Joint::ground(x + 3, y));
    linkage.joints.push_back(Joint::ground(x + 2.5, y + 4));
    linkage.joints.push_back(Joint::triad(7, 3, x - 1, y + 2.5));
    linkage.joints.push_back(Joint::triad(9, 2.2, x + 1, y + 2.5));
    linkage.joints.push_back(Joint::triad(8, 3.5, x, y + 2.5));  // in line with the two others
    linkage.joints.push_back(Joint::dyad(10, 11, 2, 3, true));
    const Kept kept = run(linkage, times_of(grid));
    if (kept.path.empty()) continue;
    SCOPED_TRACE(i);
    Simulator simulator(prepare(scene_of(linkage, grid)));
    const Trajectory t = simulator.run();
    EXPECT_EQ(name(kept.motion.status.code), name(simulator.report().status.code));
    ASSERT_EQ(kept.path.size(), t.rows());
    const double estimated = kept.motion.error + simulator.report().error.estimated_position.value_or(0);
    EXPECT_LE(deviation(kept.path, t) / largest(kept.path), 100 * estimated);
    complete += kept.motion.status.ok() ? 1 : 0;
  }
  EXPECT_GT(complete, 10);
}

TEST(FleetTriads, OneThatCannotBegin) {
  Linkage linkage = with_triad(0);
  linkage.joints[6].value[0] = 100;
  const Kept kept = run(linkage, {0});
  EXPECT_EQ(name(kept.motion.status.code), "not_assembled");
  EXPECT_EQ(kept.motion.joint, 5);
  EXPECT_TRUE(kept.path.empty());
  EXPECT_THROW((void)scene_of(linkage, one_turn(10)), Error);
}

TEST(FleetTriads, RefusesWhatIsNoTriad) {
  const auto expect = [](const Linkage& linkage, const std::string& what) {
    EXPECT_EQ(refusal([&] { Fleet fleet({linkage}); }), "linkage 0 (counted from 0): joint " + what);
  };
  Linkage two = with_triad(0), mixed = with_triad(0), knotted = with_triad(0), flat = with_triad(0);
  two.joints.pop_back();
  expect(two, "5 (counted from 0) begins a triad that has no three joints");
  mixed.joints[6] = Joint::dyad(1, 4, 1, 1, true);
  expect(mixed, "5 (counted from 0) begins a triad that has no three joints, one after another");
  knotted.joints[7].first = 5;
  expect(knotted, "5 (counted from 0) begins a triad of which a joint depends on another of its joints");
  flat.joints[7].value = {1, flat.joints[6].value[1], flat.joints[6].value[2]};
  expect(flat, "5 (counted from 0) begins a triad of which two joints are in one place");
}

TEST(FleetTriads, TheSteadyStateAllocatesNothing) {
  const std::vector<double> times = times_of(one_turn(100));
  const std::vector<Linkage> linkages = {with_triad(0), with_triad(1), with_triad(2), with_triad(3)};
  const auto allocated = [&](std::size_t count) {
    const std::int64_t before = allocations();
    (void)Fleet(count, [&](std::size_t i, Linkage& to) {
      to = linkages[i % 4];
    }).stream([](auto, const auto&) {}, times);
    return allocations() - before;
  };
  (void)allocated(200);
  EXPECT_EQ(allocated(2000), allocated(200));
}

}  // namespace
}  // namespace assur::test
