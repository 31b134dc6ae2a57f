// Fleets of planar linkages: against the simulator, against closed forms in quadruple precision, at the ends of
// motions, and bit by bit however a fleet is cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "backends/allocations.hpp"
#include "numbers.hpp"
#include "references/quad.hpp"
#include "sweep/random_linkage.hpp"

namespace assur::test {
namespace {

using references::Quad;
using Joint = LinkageJoint;

TimeGrid one_turn(int steps) { return {0, 1, 1.0 / steps}; }

std::vector<double> times_of(const TimeGrid& grid) {
  std::vector<double> times;
  for (std::int64_t k = 0; k <= grid.steps(); ++k) times.push_back(grid.time(k));
  return times;
}

Linkage random_one(std::size_t k) {
  Linkage linkage;
  sweep::random_linkage(7, k, {5, 20}, linkage);
  return linkage;
}
void random_into(std::size_t k, Linkage& to) { sweep::random_linkage(7, k, {5, 20}, to); }

// A motion that outlives the sink.
struct Kept {
  LinkageMotion motion;
  std::vector<PlanePoint> path;
};

std::vector<Kept> run(const Fleet& fleet, const std::vector<double>& times, const FleetOptions& options = {}) {
  std::vector<Kept> out(fleet.size());
  (void)fleet.run(
      times,
      [&](std::size_t i, const LinkageMotion& motion) {
        out[i] = {motion, {motion.path.begin(), motion.path.end()}};
      },
      options);
  return out;
}
Kept run(const Linkage& linkage, const std::vector<double>& times) { return run(Fleet({linkage}), times)[0]; }

// Grounds at 0 and (distance, 0); the path is that of the dyad.
Linkage four_bar(double crank, double coupler, double rocker, double distance, double angle = 0) {
  return {{Joint::ground(0, 0), Joint::crank(0, crank, angle, kTurn), Joint::ground(distance, 0),
           Joint::dyad(1, 2, coupler, rocker, true)}};
}

void expect_bits(const Kept& a, const Kept& b, const std::string& what) {
  EXPECT_EQ(a.path, b.path) << what;
  EXPECT_EQ(a.motion.status.code, b.motion.status.code) << what;
  EXPECT_TRUE(a.motion.reached == b.motion.reached || (std::isnan(a.motion.reached) && std::isnan(b.motion.reached)));
  EXPECT_EQ(a.motion.error, b.motion.error) << what;
  EXPECT_EQ(a.motion.residual, b.motion.residual) << what;
}

double largest(const std::vector<PlanePoint>& path) {
  double size = 0;
  for (const PlanePoint& p : path) size = std::max({size, std::abs(p[0]), std::abs(p[1])});
  return size;
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
    if (motion.status.code == Code::limit_reached) {
      EXPECT_NEAR(motion.reached, simulator.report().reached, 1e-6);
    }
    ++codes[motion.status.code];
  }
  EXPECT_GT(codes[Code::ok], 30);
  EXPECT_GT(codes[Code::limit_reached], 30);
}

// Joints in quad, by the intersection of circles in another form: the law of cosines.
std::vector<std::array<Quad, 2>> posture(const Linkage& linkage, double t) {
  using std::numbers::pi;
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
TEST(Fleet, ErrorsAgainstClosedForms) {
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

TEST(Fleet, BitsDependOnTheLinkageAlone) {
  const std::vector<double> times = times_of(one_turn(150));
  const Fleet fleet(200, random_into);
  FleetOptions two;
  two.threads = 2;
  const std::vector<Kept> one_thread = run(fleet, times), two_threads = run(fleet, times, two);
  std::vector<Kept> in_parts(fleet.size());
  const auto sink = [&](std::size_t i, const LinkageMotion& m) { in_parts[i] = {m, {m.path.begin(), m.path.end()}}; };
  for (const auto& [first, last] : std::vector<std::pair<std::size_t, std::size_t>>{{150, 200}, {0, 1}, {1, 150}}) {
    EXPECT_EQ(fleet.run(times, sink, {}, first, last).linkages, last - first);
  }
  for (std::size_t i = 0; i < fleet.size(); ++i) {
    const std::string what = "linkage " + std::to_string(i);
    expect_bits(one_thread[i], two_threads[i], what);
    expect_bits(one_thread[i], in_parts[i], what);
    if (i < 20) expect_bits(one_thread[i], run(random_one(i), times), what);
  }
}

// A four-bar that is no crank-rocker jams where coupler and rocker are in line.
TEST(Fleet, TimesOfLimitsAreExact) {
  const double crank = 1, coupler = 1.2, rocker = 0.9, distance = 1.5;
  // cosine of the crank's angle where the distance of the dyad's parents is coupler + rocker
  const double cosine = (1 + distance * distance - std::pow(coupler + rocker, 2)) / (2 * distance);
  const double t = std::acos(cosine) / kTurn;
  for (const int steps : {3, 7, 50, 200, 1000}) {
    const Kept kept = run(four_bar(crank, coupler, rocker, distance), times_of(one_turn(steps)));
    EXPECT_EQ(kept.motion.status.code, Code::limit_reached) << steps;
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
      EXPECT_EQ(kept.motion.status.code, Code::limit_reached) << beyond << ", " << steps;
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
    EXPECT_FALSE(kept.motion.status.arrived()) << steps;
    EXPECT_NEAR(kept.motion.reached, (std::numbers::pi - 1) / kTurn, 1e-6) << steps;
  }
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
  EXPECT_EQ(apart.motion.status.code, Code::not_converged);
  EXPECT_EQ(apart.motion.joint, 3);
  EXPECT_TRUE(std::isnan(apart.motion.reached));
  EXPECT_TRUE(apart.path.empty());
  EXPECT_EQ(run(four_bar(1, 1, 1, 3), times).motion.status.code, Code::singular) << "stretched";
  EXPECT_EQ(run(four_bar(1, 3, 1, 3), times).motion.status.code, Code::singular) << "folded";
  const FleetReport report = Fleet({four_bar(1, 1, 1, 5), four_bar(1, 3, 2.5, 3)}).run(times, [](auto, const auto&) {});
  EXPECT_EQ(report.not_closed, 1U);
  EXPECT_EQ(report.done, 1U);
  EXPECT_EQ(report.linkages, 2U);
  EXPECT_EQ(report.dyads, 11);
}

// A triangle that is almost flat loses digits: the estimate says how many, and the status says if they are too many.
TEST(Fleet, LostDigitsAreInaccurate) {
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
  EXPECT_NE(refusal([&] { (void)fleet.run(std::vector<double>{}, sink); }), "nothing was refused");
  EXPECT_NE(refusal([&] { (void)fleet.run(std::vector<double>{1, 0}, sink); }), "nothing was refused");
  EXPECT_NE(refusal([&] { (void)fleet.run(std::vector<double>{0, kNan}, sink); }), "nothing was refused");
  EXPECT_NE(refusal([&] { (void)fleet.run(std::vector<double>{0}, sink, {}, 1, 2); }), "nothing was refused");
  FleetOptions exact;
  exact.accuracy = 0;
  EXPECT_NE(refusal([&] { (void)fleet.run(std::vector<double>{0}, sink, exact); }), "nothing was refused");
}

TEST(Fleet, ErrorsOfTheCallerPropagate) {
  const std::vector<double> times = times_of(one_turn(10));
  struct Trouble {};
  FleetOptions two;
  two.threads = 2;
  const auto ignore = [](std::size_t, const LinkageMotion&) {};
  const Fleet bad(1000, [](std::size_t i, Linkage& to) {
    if (i == 500) throw Trouble{};
    to = four_bar(1, 3, 2.5, 3);
  });
  EXPECT_THROW((void)bad.run(times, ignore, two), Trouble);
  const Fleet fleet(1000, random_into);
  EXPECT_THROW((void)fleet.run(
                   times, [](std::size_t, const LinkageMotion&) { throw Trouble{}; }, two),
               Trouble);
  two.stop = [] { return true; };
  const FleetReport report = fleet.run(times, ignore, two);
  EXPECT_TRUE(report.interrupted);
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
    (void)Fleet(linkages, random_into).run(times, [](std::size_t, const LinkageMotion&) {});
    return allocations() - before;
  };
  (void)allocated(300);
  EXPECT_EQ(allocated(3000), allocated(300));
}

}  // namespace
}  // namespace assur::test
