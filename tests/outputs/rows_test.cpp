// Outputs in rows, rows given to a sink, and values as text.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "assur/eigen.hpp"
#include "assur/print.hpp"
#include "assur/rows.hpp"
#include "backends/allocations.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

TEST(Rows, FindOutput) {
  const std::vector<std::string> columns = {"m",    "m.rate", "P.x",    "P.y",  "P.vx", "P.vy", "Q.x",
                                            "Q.y",  "Q.z",    "B.qw",   "B.qx", "B.qy", "B.qz", "B.wx",
                                            "B.wy", "B.wz",   "half.x", "A.ax", "A.ay", "A.az"};
  const std::vector<double> row = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19};
  const auto text = [](std::span<const double> s) {
    std::string out;
    for (const double x : s) out += std::to_string(static_cast<int>(x)) + " ";
    return out;
  };
  const auto found = [&](const char* name) {
    const OutputHandle c = find_output(columns, name);
    return text(c.value(row)) + "| " + text(c.rate(row)) + "| " + text(c.acceleration(row));
  };
  EXPECT_EQ(found("m"), "0 | 1 | ");
  EXPECT_EQ(found("P"), "2 3 | 4 5 | ");
  EXPECT_EQ(found("Q"), "6 7 8 | | ");
  EXPECT_EQ(found("A"), "| | 17 18 19 ");
  EXPECT_EQ(found("B.quaternion"), "9 10 11 12 | | ");
  EXPECT_EQ(found("B.angular_velocity"), "| 13 14 15 | ");
  EXPECT_EQ(found("P.vx"), "4 | | ");  // a column by itself
  for (const char* name : {"half", "R", "", "P.", "B", "R.quaternion"}) {
    EXPECT_THROW((void)find_output(columns, name), Error) << name;
  }
}

TEST(Rows, FindBodyWantsTheWholePose) {
  const std::vector<std::string> plane = {"B.origin.x", "B.origin.y", "B.angle",    "C.origin.vx", "C.origin.vy",
                                          "C.angle",    "D.origin.x", "D.origin.y", "D.angle.rate"};
  EXPECT_EQ(find_body(plane, "B").turn.first[0], 2U);
  for (const char* name : {"C", "D", "E"}) EXPECT_THROW((void)find_body(plane, name), Error) << name;
}

// The pose of a body maps its local points onto the outputs of these points.
TEST(Rows, PosesOfBodies) {
  std::size_t points = 0;
  for (const std::string name : {"gough", "three_rps", "jansen", "hexa", "delta"}) {
    const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/" + name + ".json");
    for (const Body& body : scene.bodies()) {
      if (body.name == "ground" || body.points.empty()) continue;
      std::vector<std::string> outputs = {body.name};
      for (const Member& m : body.points) outputs.push_back(m.name);
      Simulator simulator = test::simulator(scene.with_outputs(outputs));
      ASSERT_TRUE(simulator.step(scene.time().time(5)).arrived());
      const std::span<const double> row = simulator.outputs();
      const Eigen::Isometry3d at = pose(find_body(simulator.columns(), body.name), row);
      EXPECT_NEAR(at.linear().determinant(), 1, 1e-14);
      for (const Member& m : body.points) {
        if (m.in_ground) continue;
        const Eigen::Vector3d ground = at * Eigen::Vector3d(m.local[0], m.local[1], m.local[2]);
        const auto expected = as_vector(find_output(simulator.columns(), m.name).value(row));
        EXPECT_LT((ground.head(expected.size()) - expected).norm(), 1e-13) << name << " " << m.name;
        ++points;
      }
    }
  }
  EXPECT_GE(points, 5U);
}

TEST(Rows, StreamGivesTheRowsOfARun) {
  const Scene scene = sample("four_bar:2").with_time({0, 3, 0.001});
  Simulator simulator = test::simulator(scene);
  const Trajectory motion = simulator.run();
  const std::int64_t iterations = simulator.report().counters.newton_iterations;
  std::vector<double> times;
  RowValues values;
  std::size_t largest = 0;
  const std::size_t reached = simulator.stream({}, [&](const MemberRows& rows) {
    EXPECT_EQ(rows.member, 0U);
    EXPECT_EQ(rows.values.size(), rows.times.size() * motion.columns().size());
    times.insert(times.end(), rows.times.begin(), rows.times.end());
    values.insert(values.end(), rows.values.begin(), rows.values.end());
    largest = std::max(largest, rows.times.size());
  });
  EXPECT_EQ(reached, 3001U);
  EXPECT_EQ(times, motion.times());
  EXPECT_EQ(values, motion.values());
  EXPECT_EQ(largest, 1024U);
  EXPECT_TRUE(simulator.report().status.ok());
  EXPECT_EQ(simulator.report().counters.newton_iterations, iterations);
  EXPECT_EQ(motion.column("B1.x").back(), motion.last("B1.x"));
  EXPECT_EQ(motion.column("B1.x").size(), 3001U);
}

TEST(Rows, StreamOfSelectedRowsAndColumns) {
  Simulator simulator = test::simulator(sample("four_bar:1").with_time({0, 0.1, 0.01}));
  const Trajectory motion = simulator.run();
  std::vector<double> found;
  std::size_t blocks = 0;
  const RowSelection some{{"B1.y"}, 4, 2};
  simulator.stream(some, [&](const MemberRows& rows) {
    found.insert(found.end(), rows.values.begin(), rows.values.end());
    ++blocks;
  });
  const std::vector<double> all = motion.column("B1.y");
  EXPECT_EQ(found, (std::vector<double>{all[0], all[4], all[8]}));
  EXPECT_EQ(blocks, 2U);
  const RowSink none = [](const MemberRows&) {};
  EXPECT_THROW((void)simulator.stream({{"nothing"}}, none), Error);
  EXPECT_THROW((void)simulator.stream({{}, 0}, none), Error);
  EXPECT_THROW((void)simulator.stream({}, RowSink()), Error);
  // An observer ends it, and a failure does.
  EXPECT_EQ(simulator.stream({}, none, [](std::int64_t done, std::int64_t) { return done >= 3; }), 3U);
  EXPECT_EQ(simulator.report().status.code, Code::interrupted);
}

// The memory of a stream does not depend on the number of its rows.
TEST(Rows, StreamAllocatesAsOftenForManyRowsAsForFew) {
  const auto count = [](double end) {
    Simulator simulator = test::simulator(sample("four_bar:1").with_time({0, end, 0.001}), "groups/eigen");
    double sum = 0;
    const RowSink sink = [&](const MemberRows& rows) { sum += rows.values[0]; };
    simulator.stream({}, sink);
    const std::int64_t before = test::allocations();
    simulator.stream({}, sink);
    return test::allocations() - before;
  };
  EXPECT_EQ(count(3), count(30));
}

TEST(Print, EveryValueHasAText) {
  const auto text = [](const auto& value) {
    std::ostringstream out;
    out << value;
    return out.str();
  };
  EXPECT_EQ(text(Code::fold), "fold");
  EXPECT_EQ(text(Status()), "ok");
  EXPECT_EQ(text(Status(Code::fold, Place::group(2), 1.5)),
            "the mechanism cannot move further (fold), group 2, figure 1.5");
  EXPECT_EQ(text(TimeGrid{0, 1, 0.25}), "0 to 1 s by 0.25 s");
  EXPECT_EQ(text(Motion{1, 2, -0.5}), "1, rate 2, acceleration -0.5");
  EXPECT_EQ(text(ErrorFigures()), "nothing was measured");
  EXPECT_EQ(text(ForwardError{1e-15, 2e-14, ErrorFigures::kUnknown}), "position 1.0e-15, velocity 2.0e-14");
  EXPECT_EQ(text(Event{1, 1.5, "C", Code::limit_reached, 2, "", "rad"}),
            "t = 1 ... 1.5 s, limit of C: a limit of the scene ends the motion (limit_reached)");

  const Scene scene = sample("four_bar:1").with_outputs({"rocker_angle"}).with_time({0, 1, 0.25});
  Simulator simulator = test::simulator(scene, "groups/eigen+predict=past:2", {}, {"motor"});
  const Trajectory motion = simulator.run();
  EXPECT_EQ(text(motion), "5 rows of 3 columns, t = 0 ... 1 s");
  const std::string report = text(simulator.report());
  EXPECT_EQ(report.substr(0, report.find('\n')), "ok, reached t = 1 s");
  EXPECT_NE(report.find("4 steps"), std::string::npos) << report;
  EXPECT_NE(report.find("residuals: position"), std::string::npos) << report;
  EXPECT_EQ(text(simulator.prepared().plan()), "class 0: groups/eigen+predict=past:2 (forced)\n");
  simulator.reset();
  const std::string jacobian = text(simulator.jacobian());
  EXPECT_NE(jacobian.find("rocker_angle"), std::string::npos);
  EXPECT_NE(jacobian.find("motor"), std::string::npos);
  EXPECT_NE(text(simulator.examine().front()).find("condition"), std::string::npos);

  Ensemble ensemble(2, [&](std::size_t) { return prepare(scene); });
  EXPECT_EQ(text(ensemble.run()), "2 members x 5 rows of 3 columns, t = 0 ... 1 s");
  EXPECT_EQ(text(ensemble.outcomes()[1]), "ok, reached t = 1 s");
  EXPECT_NE(text(ensemble.summarize({"rocker_angle"})(0, 0)).find("mean"), std::string::npos);
}

}  // namespace
}  // namespace assur
