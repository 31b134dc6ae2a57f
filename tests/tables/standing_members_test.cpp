// Members of a table that stand, in whole or in part, and members that cannot be assembled.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "assur/assur.hpp"

namespace assur {
namespace {

constexpr double kPi = std::numbers::pi;

PrepareOptions in_lanes(const std::string& strategy = "irreducible/lanes:8") {
  PrepareOptions how;
  how.strategy = strategy;
  how.budget = ThreadBudget{1};
  how.mode = Mode::throughput;
  return how;
}

// A four-bar whose crank stands at an angle that is a parameter.
Scene standing_four_bar() {
  return parse_scene(R"json({
    "assur": 1, "name": "standing", "dimension": 2,
    "parameters": {"angle": 0.3, "long": 3, "short": 2.5},
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [3, 0], "fixed": true},
               "B": {"at": ["=cos(angle)", "=sin(angle)"]}, "C": {"at": [2.5, 2.4]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": "=long"},
                    "rocker": {"distance": ["D", "C"], "value": "=short"}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"constant": "=angle"}}},
    "measures": {"psi": {"angle": ["D", "C"]}},
    "outputs": ["C.position", "psi"]})json");
}

// The joint of two links of lengths a about p and b about q, on the left of the line from p to q.
std::array<double, 2> dyad(std::array<double, 2> p, std::array<double, 2> q, double a, double b) {
  const double x = q[0] - p[0], y = q[1] - p[1], square = x * x + y * y;
  const double along = (a * a - b * b + square) / (2 * square);
  const double across = std::sqrt(a * a / square - along * along);
  return {p[0] + along * x - across * y, p[1] + along * y + across * x};
}

struct FourBars {
  std::vector<std::string> names = {"angle", "long", "short"};
  std::vector<double> values;

  explicit FourBars(int count) {
    for (int i = 0; i < count; ++i) {
      values.insert(values.end(), {0.3 + 0.2 * std::sin(i), 3 + 0.1 * std::cos(2 * i), 2.5 + 0.1 * std::sin(3 * i)});
    }
  }
  [[nodiscard]] std::array<double, 2> joint(std::size_t i) const {
    const double* const v = values.data() + 3 * i;
    return dyad({std::cos(v[0]), std::sin(v[0])}, {3, 0}, v[1], v[2]);
  }
};

TEST(StandingMembers, AreSolvedInLanes) {
  const FourBars table(100);
  for (const std::string strategy : {"auto", "irreducible/lanes:16", "groups/eigen", "global/lanes:4"}) {
    SCOPED_TRACE(strategy);
    Ensemble e(standing_four_bar(), table.names, table.values, in_lanes(strategy));
    const EnsembleTrajectory motion = e.run();
    EXPECT_TRUE(e.report().status.ok());
    EXPECT_TRUE(e.report().fallbacks.empty());
    EXPECT_GE(e.report().counters.group_solutions, 100) << "each member is solved in a lane";
    ASSERT_TRUE(e.report().error.estimated_position.has_value());
    EXPECT_LE(*e.report().error.estimated_position, 1e-13);
    for (std::size_t i = 0; i < 100; ++i) {
      ASSERT_EQ(motion.rows(i), 1U);
      const auto [x, y] = table.joint(i);
      EXPECT_NEAR(motion(i, 0, 0), x, 1e-14 * 8) << i;
      EXPECT_NEAR(motion(i, 0, 1), y, 1e-14 * 8) << i;
      EXPECT_NEAR(motion(i, 0, 2), std::atan2(y, x - 3), 1e-14 * 8) << i;
      EXPECT_FALSE(e.outcomes()[i].alone);
    }
  }
  Ensemble chosen(standing_four_bar(), table.names, table.values, in_lanes("auto"));
  EXPECT_GT(chosen.prepared().plan().lanes, 1) << "the plan fills lanes with members";
}

TEST(StandingMembers, KeepTheirPostureInAllRows) {
  const FourBars table(20);
  const std::vector<double> times = {0, 0.1, 0.3, 0.3, 1};
  Ensemble e(standing_four_bar(), table.names, table.values, in_lanes());
  const EnsembleTrajectory motion = e.run(times);
  const std::int64_t solutions = e.report().counters.group_solutions;
  EXPECT_GE(solutions, 20);
  (void)e.run(std::vector<double>{0});
  EXPECT_EQ(e.report().counters.group_solutions, solutions) << "further rows need none";
  for (std::size_t i = 0; i < 20; ++i) {
    ASSERT_EQ(motion.rows(i), times.size());
    for (std::size_t k = 1; k < times.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(motion(i, k, c), motion(i, 0, c)) << i;
    }
  }
}

// Fixed iterations hold for all levels but the first.
TEST(StandingMembers, AreAssembledIfIterationsAreFixed) {
  const FourBars table(20);
  StepSettings settings;
  settings.iterations = 1;
  Ensemble e(standing_four_bar(), table.names, table.values, in_lanes(), settings);
  const EnsembleTrajectory motion = e.run();
  for (std::size_t i = 0; i < 20; ++i) EXPECT_NEAR(motion(i, 0, 0), table.joint(i)[0], 1e-13);
}

// A pivot E that a standing dyad places, and a four-bar that turns about it.
TEST(StandingMembers, PartsThatStandAreSolvedOnce) {
  const Scene scene = parse_scene(R"json({
    "assur": 1, "name": "adjusted", "dimension": 2,
    "parameters": {"a": 1, "b": 1.2},
    "points": {"F": {"at": [3, -1], "fixed": true}, "G": {"at": [4.5, -1], "fixed": true}, "E": {"at": [3.6, -0.1]},
               "A": {"at": [0, 0], "fixed": true}, "B": {"at": [1, 0]}, "C": {"at": [2.5, 2.4]}},
    "constraints": {"left": {"distance": ["F", "E"], "value": "=a"}, "right": {"distance": ["G", "E"], "value": "=b"},
                    "coupler": {"distance": ["B", "C"], "value": 3.2}, "rocker": {"distance": ["E", "C"], "value": 2.8}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 6.283185307179586]}}},
    "outputs": ["C", "E.position"], "time": {"start": 0, "end": 1, "step": 0.01}})json");
  std::vector<double> values;
  for (int i = 0; i < 40; ++i) values.insert(values.end(), {1 + 0.1 * std::sin(i), 1.2 + 0.1 * std::cos(3 * i)});
  Ensemble e(scene, {"a", "b"}, values, in_lanes());
  const EnsembleTrajectory motion = e.run();
  EXPECT_TRUE(e.report().fallbacks.empty());
  const std::int64_t solutions = e.report().counters.group_solutions;
  (void)e.run(std::vector<double>{0});
  EXPECT_EQ(solutions - e.report().counters.group_solutions, 40 * 100) << "C is solved in each row, E at the start";
  const std::vector<std::string>& columns = e.columns();
  const auto at = [&](const char* name) {
    return static_cast<std::size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin());
  };
  for (std::size_t i = 0; i < 40; ++i) {
    const std::array<double, 2> pivot = dyad({4.5, -1}, {3, -1}, values[2 * i + 1], values[2 * i]);
    const std::array<double, 2> under = {pivot[0], -2 - pivot[1]};
    const std::array<double, 2> of = motion(i, 0, at("E.y")) > -1 ? (pivot[1] > -1 ? pivot : under) : under;
    Simulator alone(prepare(scene.with_values({{"a", values[2 * i]}, {"b", values[2 * i + 1]}}),
                            {.strategy = "irreducible/eigen", .budget = ThreadBudget{1}}));
    const Trajectory t = alone.run();
    for (std::size_t k = 0; k < 101; ++k) {
      EXPECT_NEAR(motion(i, k, at("E.x")), of[0], 1e-13);
      EXPECT_NEAR(motion(i, k, at("E.y")), of[1], 1e-13);
      EXPECT_EQ(motion(i, k, at("E.x")), motion(i, 0, at("E.x")));
      for (const char* name : {"C.x", "C.vy", "C.ay"})
        EXPECT_NEAR(motion(i, k, at(name)), t(k, at(name)), 1e-9) << name;
    }
  }
}

// Standing platforms in space, whose legs have the lengths of drivers.
TEST(StandingMembers, PosturesOfPlatforms) {
  const auto place = [](int i, double radius, double offset, int k) {
    const double angle = 2 * kPi / 3 * (i / 2) + (i % 2 == 0 ? -offset : offset);
    return radius * (k == 0 ? std::cos(angle) : std::sin(angle));
  };
  SceneBuilder builder("platform", 3);
  std::vector<Member> members;
  builder.point("O", {0.01, -0.02, 1});
  builder.vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  for (int i = 0; i < 6; ++i) {
    builder.fixed_point("A" + std::to_string(i), {place(i, 1, 0.2, 0), place(i, 1, 0.2, 1), 0});
    members.push_back({"B" + std::to_string(i), {place(i, 0.5, 0.8, 0), place(i, 0.5, 0.8, 1), 0}, false});
  }
  builder.add(Body{"plate", "O", {"u", "v", "w"}, {}, members, {}, {}});
  for (int i = 0; i < 6; ++i) {
    const double x = place(i, 1, 0.2, 0) - place(i, 0.5, 0.8, 0), y = place(i, 1, 0.2, 1) - place(i, 0.5, 0.8, 1);
    builder.drive("leg" + std::to_string(i), DrivenDistance{"A" + std::to_string(i), "B" + std::to_string(i),
                                                            Law::constant(std::sqrt(x * x + y * y + 1))});
  }
  builder.output("O.position");
  const Scene scene = builder.build();
  // The points of the base are at different heights, and the platform with them.
  std::vector<std::string> names;
  for (int i = 0; i < 6; ++i) names.push_back("A" + std::to_string(i) + ".z");
  std::vector<double> table;
  const auto height = [](std::size_t member) { return 0.02 * std::sin(double(member)); };
  for (std::size_t i = 0; i < 48; ++i) table.insert(table.end(), 6, height(i));
  Ensemble e(scene, names, table, in_lanes());
  const EnsembleTrajectory motion = e.run();
  EXPECT_TRUE(e.report().fallbacks.empty());
  EXPECT_EQ(e.report().counters.group_solutions % 48, 0);
  EXPECT_GE(e.report().counters.group_solutions, 48);
  for (std::size_t i = 0; i < 48; ++i) {
    ASSERT_EQ(motion.rows(i), 1U) << e.outcomes()[i].cannot;
    EXPECT_NEAR(motion(i, 0, 0), 0, 1e-12);
    EXPECT_NEAR(motion(i, 0, 2), 1 + height(i), 1e-12);
  }
}

// ---- members that cannot be assembled

TEST(ImpossibleMembers, LeaveTheOthersInTheirLanes) {
  FourBars table(64);
  for (const std::size_t i : {5u, 6u, 21u, 40u}) table.values[3 * i + 1] = 9;
  for (std::size_t i = 48; i < 64; ++i) table.values[3 * i + 2] = 0.1;  // a whole tile
  Ensemble e(standing_four_bar(), table.names, table.values, in_lanes("irreducible/lanes:16"));
  const EnsembleTrajectory motion = e.run();
  for (std::size_t i = 0; i < 64; ++i) {
    const Ensemble::Outcome& o = e.outcomes()[i];
    const bool can = i < 48 && i != 5 && i != 6 && i != 21 && i != 40;
    EXPECT_EQ(o.status.code, can ? Code::ok : Code::not_assembled) << i;
    EXPECT_EQ(o.cannot.empty(), can) << i;
    EXPECT_EQ(motion.rows(i), can ? 1U : 0U) << i;
    if (can) {
      EXPECT_NEAR(motion(i, 0, 0), table.joint(i)[0], 1e-13) << i;
    } else {
      EXPECT_NE(o.cannot.find("group C cannot be assembled"), std::string::npos) << o.cannot;
    }
  }
  ASSERT_EQ(e.report().fallbacks.size(), 1U);
  EXPECT_EQ(e.report().fallbacks[0].rfind("20 of 64 members were prepared one by one", 0), 0U);
}

TEST(ImpossibleMembers, AllOfThemAreOutcomes) {
  FourBars table(20);
  const std::vector<double> possible = table.values;
  for (std::size_t i = 0; i < 20; ++i) table.values[3 * i + 1] = 7;
  Ensemble e(standing_four_bar(), table.names, table.values, in_lanes());
  EXPECT_EQ(e.prepared().name(), "standing");
  for (int again = 0; again < 2; ++again) {
    const EnsembleTrajectory motion = e.run();
    EXPECT_EQ(motion.columns(), (std::vector<std::string>{"C.x", "C.y", "psi", "psi.rate", "psi.acceleration"}));
    EXPECT_EQ(e.report().status.code, Code::not_assembled);
    for (std::size_t i = 0; i < 20; ++i) {
      EXPECT_EQ(motion.rows(i), 0U);
      EXPECT_TRUE(std::isnan(motion(i, 0, 0)));
      EXPECT_EQ(e.outcomes()[i].status.code, Code::not_assembled);
      EXPECT_NE(e.outcomes()[i].cannot.find("group C cannot be assembled"), std::string::npos);
    }
  }
  e.bind(possible);
  const EnsembleTrajectory motion = e.run();
  EXPECT_TRUE(e.report().status.ok());
  EXPECT_TRUE(e.report().fallbacks.empty()) << "they are bound, too";
  for (std::size_t i = 0; i < 20; ++i) EXPECT_NEAR(motion(i, 0, 0), FourBars(20).joint(i)[0], 1e-13);
}

TEST(ImpossibleMembers, OfASceneThatIsImpossibleAsWritten) {
  const Scene scene = standing_four_bar().with_values({{"long", 9.0}});
  FourBars table(20);
  const std::vector<double> possible = table.values;
  for (std::size_t i = 0; i < 20; ++i) table.values[3 * i + 1] = 7;
  Ensemble e(scene, table.names, table.values, in_lanes());
  EXPECT_THROW((void)e.prepared(), Error);
  EXPECT_EQ(e.time().steps(), 0);
  const EnsembleSummary summary = e.summarize({"psi"});
  EXPECT_EQ(summary.members(), 20U);
  EXPECT_TRUE(std::isnan(summary(3, 0).last));
  for (const Ensemble::Outcome& o : e.outcomes()) EXPECT_EQ(o.status.code, Code::not_assembled);
  e.bind(possible);
  EXPECT_EQ(e.prepared().name(), "standing");
  const EnsembleTrajectory motion = e.run();
  EXPECT_TRUE(e.report().fallbacks.empty());
  for (std::size_t i = 0; i < 20; ++i) EXPECT_NEAR(motion(i, 0, 0), FourBars(20).joint(i)[0], 1e-13);
}

// The scene or the options are wrong, whatever the values are.
TEST(ImpossibleMembers, WrongScenesAndOptionsAreRefused) {
  const FourBars table(3);
  EXPECT_THROW(Ensemble(standing_four_bar(), table.names, table.values, in_lanes("irreducible/lane:8")), Error);
  EXPECT_THROW(Ensemble(standing_four_bar(), table.names, table.values, in_lanes("irreducible/abacus")), Error);
  PrepareOptions how = in_lanes();
  how.controlled = {"moter"};
  EXPECT_THROW(Ensemble(standing_four_bar(), table.names, table.values, how), Error);
  const Scene free = SceneBuilder("free", 2).fixed_point("A", {0, 0}).point("B", {1, 0}).output("B").build();
  EXPECT_THROW(Ensemble(free, {"B.x"}, {1, 2}, in_lanes()), Error);
}

}  // namespace
}  // namespace assur
