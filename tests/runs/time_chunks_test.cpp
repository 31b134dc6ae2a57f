// A time grid divided into concurrent chunks gives the same results as a run in sequence.
#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "decimal.hpp"
#include "errors/conditions.hpp"
#include "files/shipped_files.hpp"
#include "motion/limited.hpp"
#include "plan/preparation.hpp"
#include "runs/chunks.hpp"
#include "simulation/simulator_access.hpp"

namespace assur {
namespace {

using test::Result;

Simulator simulator(const Scene& scene, const std::string& strategy, StepSettings settings = {}) {
  return Simulator(prepare(scene, {strategy, {}, ThreadBudget{4}}), settings);
}

Result run(const Scene& scene, const std::string& strategy) {
  Simulator s = simulator(scene, strategy);
  Trajectory t = s.run();
  return {std::move(s), std::move(t)};
}

std::string text(const std::string& solver, int lanes, int chunks, int p = 1) {
  return solver + ":" + std::to_string(lanes) + "+chunks=" + std::to_string(chunks) + " " + std::to_string(p) + "x1";
}

// A scene, its run in sequence and the conditions of its rows.
struct Sequence {
  Scene scene;
  std::string solver;
  Result result;
  std::vector<double> conditions;

  Sequence(const Scene& s, std::string with = "groups/eigen", std::size_t every = 1)
      : scene(s),
        solver(std::move(with)),
        result(run(s, solver)),
        conditions(test::conditions(s, test::grid_of(s), every)) {}
};

void expect_the_same_run(const Sequence& in_sequence, const Result& chunked) {
  const Report &a = chunked.report(), &b = in_sequence.result.report();
  const Trajectory &rows = chunked.trajectory, &expected = in_sequence.result.trajectory;
  // Chunks do not estimate their errors.
  const auto code = [](const Report& r) { return r.status.arrived() ? Code::ok : r.status.code; };
  EXPECT_EQ(code(a), code(b));
  EXPECT_EQ(rows.columns(), expected.columns());
  ASSERT_EQ(rows.times(), expected.times());
  const double residual = test::residual_of(a, b);
  EXPECT_LE(residual, 1e-13);
  const test::Sizes sizes = test::sizes(expected);
  for (std::size_t k = 0; k < rows.rows(); ++k) {
    test::expect_same_row(rows.row(k), expected, k, sizes, in_sequence.conditions[k], residual);
    if (testing::Test::HasFailure()) return;
  }
  const std::vector<Event> found = test::events(a), wanted = test::events(b);
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].kind, wanted[i].kind);
    EXPECT_EQ(found[i].group, wanted[i].group);
    EXPECT_LE(found[i].time, wanted[i].until);  // the brackets of both events overlap
    EXPECT_GE(found[i].until, wanted[i].time);
  }
  EXPECT_EQ(a.counters.steps, b.counters.steps);
  EXPECT_EQ(a.counters.stored_values, b.counters.stored_values);
  EXPECT_NEAR(a.reached, b.reached, in_sequence.scene.time().step / 1024);
  EXPECT_EQ(chunked.simulator.time(), a.reached);
}

bool mentions(const std::vector<std::string>& lines, const std::string& words) {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& l) { return l.find(words) != std::string::npos; });
}

// ---- every scene

std::vector<Scene> shipped() {
  std::vector<Scene> out;
  for (const auto& file : test::shipped_files()) {
    const Scene scene = read_scene(file);
    const TimeGrid t = scene.time();
    const std::int64_t steps = std::min<std::int64_t>(t.steps(), 101);  // a prime, so that chunks differ in length
    out.push_back(scene.with_time({t.start, t.start + static_cast<double>(steps) * t.step, t.step}));
  }
  return out;
}

TEST(TimeChunks, EveryShippedSceneMovesAsInSequence) {
  for (const Scene& scene : shipped()) {
    const Sequence in_sequence(scene, "groups/eigen", 10);
    ASSERT_TRUE(in_sequence.result.report().status.ok());
    for (const int chunks : {2, 3, 7, 16}) {
      for (const int lanes : {1, 4, 8}) {
        SCOPED_TRACE(scene.name() + " " + text("groups/eigen", lanes, chunks));
        const Result one = run(scene, text("groups/eigen", lanes, chunks));
        expect_the_same_run(in_sequence, one);
        if (test::has_callback(scene)) {  // no chunks
          EXPECT_FALSE(one.report().fallbacks.empty());
        } else if (in_sequence.result.counters().rejected == 0) {
          EXPECT_TRUE(one.report().fallbacks.empty()) << one.report().fallbacks[0];
        }
        const Result two = run(scene, text("groups/eigen", lanes, chunks, 2));
        EXPECT_EQ(one.trajectory.values(), two.trajectory.values());
        EXPECT_EQ(one.counters().newton_iterations, two.counters().newton_iterations);
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

TEST(TimeChunks, RunWithOtherStrategies) {
  const Sequence stewart(sample("stewart:steps=50"), "groups/eigen", 10);
  for (const std::string strategy : {"irreducible/lanes:8+chunks=8+predict=hermite:5", "global/eigen:4+once+chunks=5",
                                     "groups/lanes:16+float+chunks=16", "groups/eigen:2+reuse=run+chunks=3 2x1",
                                     "irreducible/eigen:4+predict=past:3+chunks=4+refine"}) {
    SCOPED_TRACE(strategy);
    expect_the_same_run(stewart, run(stewart.scene, strategy));
  }
}

// ---- borders

TEST(TimeChunks, CoverTheGridAndOverlapByTwoRowsAtMost) {
  for (std::size_t rows = 1; rows < 80; ++rows) {
    for (std::size_t chunks = 1; chunks < 90; ++chunks) {
      const ChunkGrid grid = chunk_grid(rows, chunks);
      ASSERT_EQ(grid.first.size(), std::clamp<std::size_t>(chunks, 1, std::max<std::size_t>(rows - 1, 1)));
      ASSERT_EQ(grid.first.front(), 0u);
      ASSERT_EQ(grid.first.back() + grid.rows, rows);
      for (std::size_t c = 0; c + 1 < grid.first.size(); ++c) {
        const std::size_t end = grid.first[c] + grid.rows;
        ASSERT_GT(grid.first[c + 1], grid.first[c]);
        ASSERT_GT(end, grid.first[c + 1]);
        ASSERT_LE(end, grid.first[c + 1] + 2);
      }
    }
  }
}

TEST(TimeChunks, AcceptAnyNumberOfStepsAndChunks) {
  for (const int steps : {1, 2, 3, 5, 7, 12, 31}) {
    const Scene scene = sample("four_bar", {{"step", 0.01}, {"steps", static_cast<double>(steps)}});
    const Sequence in_sequence(scene);
    for (const int chunks : {2, 3, 4, 6, 8, 30, 40}) {
      for (const int lanes : {1, 4}) {
        SCOPED_TRACE(std::to_string(steps) + " steps, " + text("groups/eigen", lanes, chunks));
        expect_the_same_run(in_sequence, run(scene, text("groups/eigen", lanes, chunks)));
      }
    }
  }
}

TEST(TimeChunks, AcceptOwnTimesWithAnySpacing) {
  const Scene scene = sample("four_bar:step=0.01,steps=40");
  std::vector<double> even, uneven, twice = {0, 0.1, 0.1, 0.2};
  for (int k = 0; k <= 40; ++k) even.push_back(0.05 + 0.02 * k), uneven.push_back(0.001 * k * k);
  Simulator sequence = simulator(scene, "groups/eigen"), chunked = simulator(scene, "groups/eigen:4+chunks=4");
  const Trajectory expected = sequence.run(even);
  const Trajectory rows = chunked.run(even);
  EXPECT_TRUE(chunked.report().fallbacks.empty());
  ASSERT_EQ(rows.times(), even);
  const std::vector<double> conditions = test::conditions(scene, even);
  for (std::size_t k = 0; k < rows.rows(); ++k) {
    test::expect_same_row(rows.row(k), expected, k, test::sizes(expected), conditions[k], 8 * kEps);
  }
  EXPECT_EQ(chunked.report().counters.steps, sequence.report().counters.steps);
  for (const auto& times : {uneven, twice}) {
    const Trajectory own = sequence.run(times);
    EXPECT_EQ(chunked.run(times).values(), own.values());
    EXPECT_TRUE(mentions(chunked.report().fallbacks, "no chunks: the steps are not equally long"));
  }
  EXPECT_EQ(chunked.run(std::vector<double>{}).rows(), 0u);
}

// ---- change points, limits

TEST(TimeChunks, PassChangePoints) {
  for (const double step : {0.0071, 0.0033}) {
    const Scene scene = sample("almost_parallelogram", {{"delta", 0}, {"step", step}, {"steps", std::round(2 / step)}});
    const Sequence in_sequence(scene);
    ASSERT_EQ(test::events(in_sequence.result.report()).size(), 4u);
    for (const int chunks : {2, 3, 7, 16}) {
      for (const int lanes : {1, 4, 8}) {
        SCOPED_TRACE(text("groups/eigen", lanes, chunks));
        const Result r = run(scene, text("groups/eigen", lanes, chunks));
        expect_the_same_run(in_sequence, r);
        EXPECT_TRUE(mentions(r.report().fallbacks, "was run alone") || mentions(r.report().fallbacks, "no chunks"));
      }
    }
  }
}

TEST(TimeChunks, EndAtALimitAsInSequence) {
  const Scene scene = test::limited_four_bar(Law::polynomial({0.5, 1})).time(0, 2, 0.01).build();
  const Sequence in_sequence(scene);
  ASSERT_EQ(in_sequence.result.report().status.code, Code::fold);
  for (const int chunks : {2, 3, 7, 16}) {
    SCOPED_TRACE(chunks);
    const Result r = run(scene, text("groups/eigen", 4, chunks));
    expect_the_same_run(in_sequence, r);
    const bool border_beyond = chunks > 2;  // with two chunks, the second begins at 1 s, before the limit
    EXPECT_EQ(mentions(r.report().fallbacks, "no chunks: start postures were found only up to t = 1.0"), border_beyond);
    EXPECT_EQ(mentions(r.report().fallbacks, "was run alone"), !border_beyond);
  }
}

// The crank rests at 1 rad at every quarter of a second, and swings out and back in between. In the quarter `beyond` it
// swings beyond its limit, which the way to the start postures of four chunks finds, although the crank rests at them.
Scene swinging(int beyond) {
  const Law law = Law::function([beyond](double t) -> Motion {
    const double quarter = std::floor(4 * t), s = 4 * t - quarter;
    const double height = quarter == beyond ? 0.6 : 0.3;
    const double b = s * (1 - s), b1 = 4 * (1 - 2 * s), b2 = -32;  // b and its derivatives by t
    return {1 + 64 * height * b * b * b, 64 * height * 3 * b * b * b1,
            64 * height * (6 * b * b1 * b1 + 3 * b * b * b2)};
  });
  return test::limited_four_bar(law).time(0, 1, 0.01).build();
}

TEST(TimeChunks, ALimitWithinAChunkEndsTheRun) {
  for (const int beyond : {0, 1, 2, 3}) {
    const Sequence in_sequence(swinging(beyond));
    ASSERT_EQ(in_sequence.result.report().status.code, Code::fold);
    for (const int lanes : {1, 2, 4}) {
      SCOPED_TRACE(std::to_string(beyond) + " " + text("groups/eigen", lanes, 4));
      Result r = run(in_sequence.scene, text("groups/eigen", lanes, 4));
      expect_the_same_run(in_sequence, r);
      // No chunk begins behind the last limit.
      EXPECT_TRUE(
          mentions(r.report().fallbacks, beyond < 3 ? "start postures were found only up to" : "was run alone"));
      // The simulator ends at the same posture as the run in sequence.
      Simulator there = simulator(in_sequence.scene, "groups/eigen");
      (void)there.run();
      const test::Sizes size = test::sizes(in_sequence.result.trajectory);
      for (std::size_t c = 0; c < there.columns().size(); ++c) {
        // The brackets of the limit differ by at most two 2^-20 of a step. At a fold positions change by the square
        // root of this difference.
        if (test::derivative_of(there.columns()[c]) == 0) {
          EXPECT_NEAR(r.simulator.outputs()[c], there.outputs()[c], 4 * size.of[0] / 1024);
        }
      }
    }
  }
  const Sequence without(swinging(4));
  ASSERT_TRUE(without.result.report().status.ok());
  expect_the_same_run(without, run(without.scene, text("groups/eigen", 4, 4)));
}

// ---- the start posture of a chunk

Scene four_bar(double side) {
  SceneBuilder b("four_bar", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).point("B", {0.8, 0, 0}).point("C", {1.6, side * 1.2, 0});
  b.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  b.constrain("rocker", Distance{"D", "C", 1.3});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({0, 2 * std::numbers::pi})});
  b.measure("crank_angle", AbsoluteAngle{"A", "B"}).measure("rocker_angle", AbsoluteAngle{"D", "C"});
  return b.time(0, 1, 0.01).build();
}

TEST(TimeChunks, RepeatAChunkThatStartsOnTheWrongBranch) {
  const Sequence right(four_bar(1)), mirrored(four_bar(-1));
  for (const int lanes : {1, 4}) {
    for (const std::set<std::size_t>& wrong : {std::set<std::size_t>{2}, {1, 2}, {3}, {1, 3}, {}}) {
      const Prepared prepared = prepare(right.scene, {text("groups/eigen", lanes, 4, 2), {}, ThreadBudget{2}});
      const std::vector<double> times = test::grid_of(right.scene);
      const ChunkGrid grid = chunk_grid(times.size(), 4);
      Simulator good = test::simulator(right.scene, "groups/eigen"),
                bad = test::simulator(mirrored.scene, "groups/eigen");
      std::vector<Variant> starts;
      for (std::size_t c = 0; c < 4; ++c) {
        const double t = times[grid.first[c]];
        ASSERT_TRUE(good.step(t).ok() && bad.step(t).ok());
        starts.push_back(
            {preparation(prepared).structure->system, SimulatorAccess::posture(wrong.contains(c) ? bad : good), t, {}});
      }
      const ChunkedRun r = run_in_chunks(preparation(prepared), {}, times, grid, starts, {});
      EXPECT_TRUE(r.status.ok());
      ASSERT_EQ(r.rows, times.size());
      // A wrong chunk does not meet its correct neighbours. Only the wrong chunk is repeated.
      EXPECT_EQ(r.fallbacks.size(), wrong.size());
      for (const std::size_t c : wrong) {
        EXPECT_TRUE(mentions(
            r.fallbacks, "the chunk from t = " + general(times[grid.first[c]], 6) + " s on began on another branch"));
      }
      const Trajectory& expected = right.result.trajectory;
      for (std::size_t k = 0; k < r.rows; ++k) {
        test::expect_same_row({r.values.data() + k * expected.columns().size(), expected.columns().size()}, expected, k,
                              test::sizes(expected), right.conditions[k], 8 * kEps);
      }
    }
  }
}

// ---- angles, state after the run

TEST(TimeChunks, UnwrapAnglesAcrossBorders) {
  const Scene scene = four_bar(1).with_time({0, 7.3, 0.01});
  const Sequence in_sequence(scene);
  for (const int chunks : {2, 7, 16, 100}) {
    SCOPED_TRACE(chunks);
    const Result r = run(scene, text("groups/eigen", 8, chunks));
    expect_the_same_run(in_sequence, r);
    const std::size_t column = r.trajectory.index("crank_angle");
    for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
      ASSERT_NEAR(r.trajectory(k, column), 2 * std::numbers::pi * r.trajectory.times()[k], 8 * 64 * kEps);
    }
  }
}

TEST(TimeChunks, TheSimulatorContinuesAfterTheRun) {
  const Scene scene = four_bar(1).with_time({0, 2.5, 0.01});
  Simulator sequence = simulator(scene, "groups/eigen"), chunked = simulator(scene, "groups/eigen:4+chunks=5 2x1");
  const std::vector<double> at_start(chunked.outputs().begin(), chunked.outputs().end());
  const Trajectory expected = sequence.run();
  const Trajectory rows = chunked.run();
  ASSERT_EQ(rows.rows(), 251u);
  EXPECT_EQ(chunked.time(), 2.5);
  for (std::size_t c = 0; c < rows.columns().size(); ++c) EXPECT_EQ(chunked.outputs()[c], rows(250, c));
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(sequence.step().ok());
    ASSERT_TRUE(chunked.step().ok());
    EXPECT_EQ(chunked.time(), sequence.time());
    for (std::size_t c = 0; c < rows.columns().size(); ++c) {
      EXPECT_NEAR(chunked.outputs()[c], sequence.outputs()[c], 1e-11 * std::max(1.0, std::abs(sequence.outputs()[c])));
    }
  }
  EXPECT_EQ(chunked.report().counters.steps, 270);
  chunked.reset();
  EXPECT_EQ(chunked.time(), 0);
  EXPECT_EQ(chunked.report().counters.steps, 0);
  EXPECT_TRUE(std::equal(at_start.begin(), at_start.end(), chunked.outputs().begin()));
  EXPECT_EQ(chunked.run().values(), rows.values());
  EXPECT_EQ(chunked.run().values(), rows.values());
}

TEST(TimeChunks, CountTheirWork) {
  const Scene scene = sample("stewart:steps=100");
  const Result sequence = run(scene, "groups/eigen");
  const Result r = run(scene, "groups/eigen:4+chunks=4");
  // Four chunks take 25 steps each, find their start postures, and pass postures on the way to them.
  EXPECT_EQ(r.counters().steps, 100);
  EXPECT_GE(r.counters().group_solutions, sequence.counters().group_solutions);
  EXPECT_LE(r.counters().group_solutions, 7 * (100 + 4 + 4 + 2 * (r.counters().substeps + r.counters().rejected)));
  EXPECT_LE(r.report().error.position, 1e-14);
  EXPECT_GT(r.report().error.position, 0);
}

// Four steps of one length succeed before a longer step is tried, so at most one in five fails. More fail during the
// search for the first length and where steps shrink, which costs a failure for each halving.
TEST(TimeChunks, RejectFewStepsToTheirStarts) {
  for (const std::string text : {"stewart:steps=10000", "four_bar:step=0.01,steps=20000"}) {
    for (const int chunks : {2, 8, 16}) {
      SCOPED_TRACE(text + " in " + std::to_string(chunks));
      const Result r = run(sample(text), "groups/" + test::sparse() + ":8+chunks=" + std::to_string(chunks));
      ASSERT_TRUE(r.report().status.ok());
      EXPECT_TRUE(r.report().fallbacks.empty());
      EXPECT_LE(4 * r.counters().rejected, r.counters().substeps);
    }
  }
}

TEST(TimeChunks, AnObserverIsCalledForEveryRowAndStops) {
  const Scene scene = four_bar(1);
  const Sequence in_sequence(scene);
  for (const int lanes : {1, 2, 4}) {
    for (const int chunks : {3, 4}) {
      SCOPED_TRACE(text("groups/eigen", lanes, chunks));
      Simulator s = simulator(scene, text("groups/eigen", lanes, chunks));
      std::int64_t heard = 0;
      (void)s.run([&](std::int64_t done, std::int64_t of) {
        EXPECT_EQ(of, 101);
        EXPECT_GE(done, heard);
        EXPECT_LE(done, of);
        heard = done;
        return false;
      });
      EXPECT_EQ(heard, 101);
      for (const std::int64_t stop : {1, 20, 34, 50, 75, 100}) {
        const Trajectory some = s.run([&](std::int64_t done, std::int64_t) { return done >= stop; });
        EXPECT_EQ(s.report().status.code, Code::interrupted) << stop;
        ASSERT_GE(some.rows(), 1u);
        ASSERT_LT(some.rows(), 101u);
        for (std::size_t k = 0; k < some.rows(); ++k) {
          test::expect_same_row(some.row(k), in_sequence.result.trajectory, k,
                                test::sizes(in_sequence.result.trajectory), in_sequence.conditions[k], 8 * kEps);
        }
        EXPECT_EQ(s.time(), some.times().back());
        EXPECT_TRUE(s.step().ok());
      }
    }
  }
}

// ---- runs that cannot be divided

TEST(TimeChunks, RunInSequenceAndExplainWhyIfImpossible) {
  const Scene scene = four_bar(1);
  Simulator timed = simulator(scene, "groups/eigen:4+chunks=4", {0, 12, 10});
  EXPECT_EQ(timed.run().values(), run(scene, "groups/eigen").trajectory.values());
  EXPECT_TRUE(mentions(timed.report().fallbacks, "no chunks: StepSettings::seconds"));
}

struct Broken {};

TEST(TimeChunks, PropagateExceptionsOfLaws) {
  auto armed = std::make_shared<bool>(false);
  SceneBuilder b("thrown", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0});
  b.drive("motor", PointAngle{"A", "B", "", Law::function([=](double t) -> Motion {
                                if (*armed && t > 0.3 && t < 0.35) throw Broken();
                                return {t, 1, 0};
                              })});
  Simulator s = simulator(b.time(0, 1, 0.01).build(), "groups/eigen:4+chunks=4 2x1");
  EXPECT_EQ(s.run().rows(), 101u);
  *armed = true;
  EXPECT_THROW((void)s.run(), Broken);
  *armed = false;
  EXPECT_EQ(s.run().rows(), 101u);
}

}  // namespace
}  // namespace assur
