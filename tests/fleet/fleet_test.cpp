// Fleets of planar linkages: against the simulator, against closed forms in quadruple precision, at the ends of
// motions, and bit by bit however a fleet is cut.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "backends/allocations.hpp"
#include "fleet/linkages.hpp"

namespace assur::test {
namespace {

void expect_bits(const Kept& a, const Kept& b, const std::string& what) {
  EXPECT_EQ(a.path, b.path) << what;
  EXPECT_EQ(a.motion.status.code, b.motion.status.code) << what;
  EXPECT_TRUE(a.motion.reached == b.motion.reached || (std::isnan(a.motion.reached) && std::isnan(b.motion.reached)));
  EXPECT_EQ(a.motion.error, b.motion.error) << what;
  EXPECT_EQ(a.motion.residual, b.motion.residual) << what;
}

// Both end at the same time with the same status, and their positions agree within their estimated errors.
TEST(Fleet, MotionsAreThoseOfTheSimulator) {
  const TimeGrid grid = one_turn(200);
  const std::vector<double> times = times_of(grid);
  const std::vector<Kept> motions = run(Fleet(300, random_into), times);
  std::map<Code, int> codes;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    SCOPED_TRACE("linkage " + std::to_string(i));
    const Linkage linkage = random_one(i);
    PrepareOptions how;
    how.strategy = "groups/lanes";
    Simulator simulator(prepare(scene_of(linkage, grid), how));
    const Trajectory t = simulator.run();
    const auto& [motion, path] = motions[i];
    EXPECT_EQ(name(motion.status.code), name(simulator.report().status.code));
    ASSERT_EQ(path.size(), t.rows());
    const std::string name = "J" + std::to_string(linkage.joints.size() - 1) + ".x";
    const auto column =
        static_cast<std::size_t>(std::find(t.columns().begin(), t.columns().end(), name) - t.columns().begin());
    double deviation = 0;
    for (std::size_t k = 0; k < path.size(); ++k) {
      deviation = std::max({deviation, std::abs(path[k][0] - t(k, column)), std::abs(path[k][1] - t(k, column + 1))});
    }
    const double estimated = motion.error + simulator.report().error.estimated_position.value_or(0);
    EXPECT_LE(deviation / largest(path), 100 * estimated);
    if (motion.status.code == Code::fold) {
      EXPECT_NEAR(motion.reached, simulator.report().reached, 1e-6);
    }
    ++codes[motion.status.code];
  }
  EXPECT_GT(codes[Code::ok], 30);
  EXPECT_GT(codes[Code::fold], 30);
}

TEST(Fleet, BitsDependOnTheLinkageAlone) {
  const std::vector<double> times = times_of(one_turn(150));
  const Fleet fleet(200, random_into);
  FleetOptions two;
  two.threads = 2;
  const std::vector<Kept> one_thread = run(fleet, times), two_threads = run(fleet, times, two);
  std::vector<Kept> in_parts(fleet.members());
  const auto sink = [&](std::size_t i, const LinkageMotion& m) { in_parts[i] = {m, {m.path.begin(), m.path.end()}}; };
  for (const auto& [first, last] : std::vector<std::pair<std::size_t, std::size_t>>{{150, 200}, {0, 1}, {1, 150}}) {
    EXPECT_EQ(fleet.stream(sink, times, {.first = first, .last = last}).linkages, last - first);
  }
  for (std::size_t i = 0; i < fleet.members(); ++i) {
    const std::string what = "linkage " + std::to_string(i);
    expect_bits(one_thread[i], two_threads[i], what);
    expect_bits(one_thread[i], in_parts[i], what);
    if (i < 20) expect_bits(one_thread[i], run(random_one(i), times), what);
  }
}

// Vectors of all widths, with and without fused products: the same ends, and positions within the estimated errors.
TEST(Fleet, InstructionSetsAgree) {
  const std::vector<double> times = times_of(one_turn(100));
  const Fleet fleet(300, random_into);
  const std::vector<Kept> best = run(fleet, times);
  int sets = 0;
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1, ++sets) {
    hwy::SetSupportedTargetsForTest(left & -left);
    const std::vector<Kept> other = run(fleet, times);
    hwy::SetSupportedTargetsForTest(0);
    for (std::size_t i = 0; i < best.size(); ++i) {
      const auto& [motion, path] = best[i];
      EXPECT_EQ(name(other[i].motion.status.code), name(motion.status.code)) << i;
      ASSERT_EQ(other[i].path.size(), path.size()) << i;
      if (!motion.status.arrived()) {
        EXPECT_NEAR(other[i].motion.reached, motion.reached, 1e-7) << i;
      }
      double deviation = 0;
      for (std::size_t k = 0; k < path.size(); ++k) {
        for (std::size_t c = 0; c < 2; ++c) deviation = std::max(deviation, std::abs(other[i].path[k][c] - path[k][c]));
      }
      EXPECT_LE(deviation / largest(path), 100 * (motion.error + other[i].motion.error)) << i;
    }
  }
  EXPECT_GT(sets, 0);
}

// A four-bar that is no crank-rocker jams where coupler and rocker are in line.
TEST(Fleet, TimesOfLimitsAreExact) {
  const double crank = 1, coupler = 1.2, rocker = 0.9, distance = 1.5;
  // cosine of the crank's angle where the distance of the dyad's parents is coupler + rocker
  const double cosine = (1 + distance * distance - std::pow(coupler + rocker, 2)) / (2 * distance);
  const double t = std::acos(cosine) / kTurn;
  for (const int steps : {3, 7, 50, 200, 1000}) {
    const Kept kept = run(four_bar(crank, coupler, rocker, distance), times_of(one_turn(steps)));
    EXPECT_EQ(kept.motion.status.code, Code::fold) << steps;
    EXPECT_EQ(kept.motion.joint, 3);
    EXPECT_NEAR(kept.motion.reached, t, 1e-12) << steps;
    EXPECT_LE(kept.motion.reached, kept.motion.not_beyond);
    EXPECT_NEAR(kept.motion.not_beyond, t, 1e-12 + 1e-9 / steps) << steps;
    EXPECT_EQ(kept.path.size(), static_cast<std::size_t>(std::floor(t * steps)) + 1) << steps;
  }
}

// Between two times the dyad opens for less than 1e-3 of the step: only its rates tell.
TEST(Fleet, ALimitBetweenTwoTimesIsFound) {
  for (const double beyond : {1e-1, 1e-3, 1e-6}) {
    // At the angle pi the dyad would have to be longer than its rods by `beyond`.
    const Linkage linkage = four_bar(1, 1.7 - beyond / 2, 1.8 - beyond / 2, 2.5);
    const double cosine = (1 + 2.5 * 2.5 - std::pow(3.5 - beyond, 2)) / 5;
    for (const int steps : {5, 25, 125}) {  // odd: none of the times is that of the angle pi
      const Kept kept = run(linkage, times_of(one_turn(steps)));
      EXPECT_EQ(kept.motion.status.code, Code::fold) << beyond << ", " << steps;
      EXPECT_NEAR(kept.motion.reached, std::acos(cosine) / kTurn, 1e-9) << beyond << ", " << steps;
    }
    const Kept shorter = run(four_bar(1, 1.7 + beyond / 2, 1.8 + beyond / 2, 2.5), times_of(one_turn(25)));
    EXPECT_EQ(shorter.motion.status.code, Code::ok) << beyond;
  }
}

// Parallelograms are flat at half a turn, where two motions cross.
TEST(Fleet, AChangePointEndsTheMotion) {
  for (const int steps : {9, 100, 101}) {
    const Kept kept = run(four_bar(1, 2, 1, 2, 1), times_of(one_turn(steps)));
    EXPECT_EQ(name(kept.motion.status.code), "branch_unknown") << steps;
    EXPECT_NEAR(kept.motion.reached, (std::numbers::pi - 1) / kTurn, 1e-6) << steps;
  }
}

// Where coupler - rocker = distance - crank, dyads fold at half a turn; rounding takes some of them past the limit, and
// keeps others inside. None may bounce.
TEST(Fleet, AChangePointIsFoundOnBothSidesOfRounding) {
  const double phase = 0.3;
  for (int i = 0; i < 400; ++i) {
    const double rocker = 1.01 + 0.0049 * i;
    for (const int steps : {1, 100}) {
      const Kept kept = run(four_bar(1, rocker + 2, rocker, 3, phase), times_of(one_turn(steps)));
      EXPECT_FALSE(kept.motion.status.arrived()) << rocker << " " << steps;
      EXPECT_NEAR(kept.motion.reached, (kTurn - phase) / kTurn, 1e-6) << rocker << " " << steps;
    }
  }
}

// Far from the origin, positions have digits that lengths have not.
TEST(Fleet, AnOpenDyadIsInaccurate) {
  Linkage far = four_bar(1, 3, 2.5, 3);
  far.joints[0] = Joint::ground(1e12, 0);
  far.joints[2] = Joint::ground(1e12 + 3, 0);
  const Kept kept = run(far, times_of(one_turn(10)));
  EXPECT_EQ(kept.motion.status.code, Code::inaccurate);
  EXPECT_GT(kept.motion.residual, 1e-6);
}

// The angle of the crank overflows.
TEST(Fleet, APathWithoutNumbersHasNoCleanStatus) {
  const Linkage linkage = {{Joint::ground(0, 0), Joint::crank(0, 1, 0, 1e300)}};
  const Kept kept = run(linkage, std::vector<double>{1e10});
  EXPECT_EQ(name(kept.motion.status.code), "not_finite");
  const FleetReport report = Fleet({linkage}).stream([](auto, const auto&) {}, std::vector<double>{1e10});
  EXPECT_EQ(report.done, 0U);
}

// With few times for each turn, paths are those with many.
TEST(Fleet, FewTimesGiveTheSameMotion) {
  const std::vector<double> fine = times_of(one_turn(200));
  std::vector<double> coarse;
  for (std::size_t k = 0; k < fine.size(); k += 100) coarse.push_back(fine[k]);
  const std::vector<Kept> all = run(Fleet(150, random_into), fine), few = run(Fleet(150, random_into), coarse);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(name(all[i].motion.status.code), name(few[i].motion.status.code)) << i;
    for (std::size_t k = 0; k < few[i].path.size(); ++k) EXPECT_EQ(few[i].path[k], all[i].path[100 * k]) << i;
    if (!all[i].motion.status.arrived()) {
      EXPECT_NEAR(all[i].motion.reached, few[i].motion.reached, 1e-9) << i;
    }
  }
}

TEST(Fleet, LinkagesThatCannotBegin) {
  const std::vector<double> times = times_of(one_turn(10));
  const Kept apart = run(four_bar(1, 1, 1, 5), times);
  EXPECT_EQ(apart.motion.status.code, Code::not_assembled);
  EXPECT_EQ(apart.motion.joint, 3);
  EXPECT_TRUE(std::isnan(apart.motion.reached));
  EXPECT_TRUE(apart.path.empty());
  EXPECT_EQ(run(four_bar(1, 1, 1, 3), times).motion.status.code, Code::singular) << "stretched";
  EXPECT_EQ(run(four_bar(1, 3, 1, 3), times).motion.status.code, Code::singular) << "folded";
  const FleetReport report =
      Fleet({four_bar(1, 1, 1, 5), four_bar(1, 3, 2.5, 3)}).stream([](auto, const auto&) {}, times);
  EXPECT_EQ(report.not_closed, 1U);
  EXPECT_EQ(report.done, 1U);
  EXPECT_EQ(report.linkages, 2U);
  EXPECT_EQ(report.dyads, 11);
}

TEST(Fleet, LinkagesFromAPosture) {
  const std::vector<std::array<int, 2>> parents = {{-1, -1}, {0, -1}, {-1, -1}, {1, 2}, {3, 1}};
  const std::vector<PlanePoint> at = {{0, 0}, {0.3, 0.4}, {2, 0}, {1.4, 1.2}, {1.1, -0.7}};
  const Kept kept = run(Linkage::at_posture(parents, at, kTurn), {0, 0.25});
  ASSERT_FALSE(kept.path.empty());
  EXPECT_NEAR(kept.path[0][0], 1.1, 1e-15);
  EXPECT_NEAR(kept.path[0][1], -0.7, 1e-15);
  EXPECT_THROW((void)Linkage::at_posture(parents, std::span(at).subspan(1), 1), Error);
  const std::vector<std::array<int, 2>> wrong = {{-1, -1}, {0, 2}, {-1, -1}, {1, 2}, {3, 1}};
  EXPECT_THROW((void)Linkage::at_posture(wrong, at, 1), Error);
}

TEST(Fleet, ScenesWithPoints) {
  Linkage linkage = four_bar(1, 3, 2.5, 3);
  linkage.joints.push_back(Joint::point(1, 3, 0.5, 0));
  linkage.joints.push_back(Joint::point(1, 3, 0.5, 0.5));
  const TimeGrid grid = one_turn(50);
  const Kept kept = run(linkage, times_of(grid));
  const Trajectory t = Simulator(prepare(scene_of(linkage, grid))).run();
  ASSERT_EQ(t.rows(), kept.path.size());
  const std::size_t last = t.columns().size() - 2;
  EXPECT_EQ(t.columns()[last], "J5.x");
  for (std::size_t k = 0; k < t.rows(); ++k) {
    EXPECT_NEAR(t(k, last), kept.path[k][0], 1e-13);
    EXPECT_NEAR(t(k, last + 1), kept.path[k][1], 1e-13);
  }
  EXPECT_THROW((void)scene_of(four_bar(1, 1, 1, 5), grid), Error);
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::input);
    return e.what();
  }
  return "nothing was refused";
}

TEST(Fleet, RefusesWhatIsNotALinkage) {
  const auto with = [](const Joint& joint) {
    Linkage linkage = four_bar(1, 3, 2.5, 3);
    linkage.joints.push_back(joint);
    return linkage;
  };
  const auto expect = [](const Linkage& linkage, const std::string& what) {
    EXPECT_EQ(refusal([&] { Fleet fleet({four_bar(1, 3, 2.5, 3), linkage}); }), "linkage 1 (counted from 0): " + what);
  };
  expect({}, "has no joint");
  expect(with(Joint::dyad(4, 1, 1, 1, true)), "joint 4 (counted from 0) must come after its parents; sort the joints");
  expect(with(Joint::dyad(1, 9, 1, 1, true)), "joint 4 (counted from 0) must come after its parents; sort the joints");
  expect(with(Joint::dyad(1, 1, 1, 1, true)), "joint 4 (counted from 0) needs two different parents");
  expect(with(Joint::ground(kNan, 0)), "joint 4 (counted from 0) has a value that is not finite");
  expect(with(Joint::crank(0, -1, 0, 1)), "joint 4 (counted from 0) needs a positive length, 1e-60 to 1e60 m");
  expect(with(Joint::dyad(0, 1, 1, 0, true)), "joint 4 (counted from 0) needs two positive lengths, 1e-60 to 1e60 m");
  Linkage elsewhere = four_bar(1, 3, 2.5, 3);
  elsewhere.traced = 4;
  expect(elsewhere, "joint 4 (counted from 0) is to be traced, but does not exist");

  const Fleet fleet({four_bar(1, 3, 2.5, 3)});
  const auto sink = [](std::size_t, const LinkageMotion&) {};
  EXPECT_NE(refusal([&] { (void)fleet.stream(sink, std::vector<double>{}); }), "nothing was refused");
  EXPECT_NE(refusal([&] { (void)fleet.stream(sink, std::vector<double>{1, 0}); }), "nothing was refused");
  EXPECT_NE(refusal([&] { (void)fleet.stream(sink, std::vector<double>{0, kNan}); }), "nothing was refused");
  EXPECT_NE(refusal([&] { (void)fleet.stream(sink, std::vector<double>{0}, {.first = 1, .last = 2}); }),
            "nothing was refused");
  FleetOptions exact;
  FleetOptions none;
  none.threads = 0;
  EXPECT_NE(refusal([&] { (void)fleet.stream(sink, std::vector<double>{0}, none); }), "nothing was refused");
  exact.accuracy = 0;
  EXPECT_NE(refusal([&] { (void)fleet.stream(sink, std::vector<double>{0}, exact); }), "nothing was refused");
}

TEST(Fleet, ErrorsOfTheCallerPropagateAndItsObserverStopsTheRun) {
  const std::vector<double> times = times_of(one_turn(10));
  struct Trouble {};
  FleetOptions two;
  two.threads = 2;
  const auto ignore = [](std::size_t, const LinkageMotion&) {};
  const Fleet bad(1000, [](std::size_t i, Linkage& to) {
    if (i == 500) throw Trouble{};
    to = four_bar(1, 3, 2.5, 3);
  });
  EXPECT_THROW((void)bad.stream(ignore, times, two), Trouble);
  const Fleet fleet(1000, random_into);
  const auto fail = [](std::size_t, const LinkageMotion&) { throw Trouble{}; };
  EXPECT_THROW((void)fleet.stream(fail, times, two), Trouble);
  std::vector<std::int64_t> told;
  two.observer = [&](std::int64_t done, std::int64_t of) {
    EXPECT_EQ(of, 1000);
    told.push_back(done);
    return false;
  };
  EXPECT_FALSE(fleet.stream(ignore, times, two).interrupted);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.back(), 1000);
  two.observer = [](auto, auto) { return true; };
  const FleetReport report = fleet.stream(ignore, times, two);
  EXPECT_TRUE(report.interrupted);
  EXPECT_TRUE(std::isnan(fleet.summarize(times, two).members[3].x.minimum));
  EXPECT_EQ(report.linkages, 0U);
}

TEST(Fleet, SummariesAreThoseOfThePaths) {
  const std::vector<double> times = times_of(one_turn(120));
  const Fleet fleet(60, random_into);
  const std::vector<Kept> motions = run(fleet, times);
  const FleetSummary summary = fleet.summarize(times);
  ASSERT_EQ(summary.members.size(), 60U);
  for (std::size_t i = 0; i < 60; ++i) {
    const auto& [status, reached, x, y] = summary.members[i];
    EXPECT_EQ(status.code, motions[i].motion.status.code);
    const std::vector<PlanePoint>& path = motions[i].path;
    const auto by = [](std::size_t c) { return [c](const PlanePoint& a, const PlanePoint& b) { return a[c] < b[c]; }; };
    EXPECT_EQ(x.minimum, (*std::min_element(path.begin(), path.end(), by(0)))[0]);
    const auto top = std::max_element(path.begin(), path.end(), by(1));
    EXPECT_EQ(y.maximum, (*top)[1]);
    EXPECT_EQ(y.maximum_time, times[static_cast<std::size_t>(top - path.begin())]);
    EXPECT_EQ(y.last, path.back()[1]);
  }
}

// After the first linkages, nothing is allocated for a linkage, and memory does not grow with their number.
TEST(Fleet, TheSteadyStateAllocatesNothing) {
  const std::vector<double> times = times_of(one_turn(200));
  const auto allocated = [&](std::size_t linkages) {
    const std::int64_t before = allocations();
    (void)Fleet(linkages, random_into).stream([](std::size_t, const LinkageMotion&) {}, times);
    return allocations() - before;
  };
  (void)allocated(300);
  EXPECT_EQ(allocated(3000), allocated(300));
}

}  // namespace
}  // namespace assur::test
