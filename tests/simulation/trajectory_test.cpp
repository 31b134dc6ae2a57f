// The results of a run, by name and as CSV.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <charconv>
#include <sstream>

#include "sanitizers.hpp"
#include "simulation/run.hpp"

namespace assur {
namespace {

using test::Result;

TEST(Trajectory, HasTheColumnsOfTheOutputsInOrder) {
  const Scene scene = sample("slider_crank:step=0.1,steps=10");
  EXPECT_EQ(test::run(scene.with_outputs({"rod_angle", "C.velocity", "slide.lambda"})).trajectory.columns(),
            (std::vector<std::string>{"rod_angle", "rod_angle.rate", "rod_angle.acceleration", "C.vx", "C.vy",
                                      "slide.lambda", "slide.lambda.rate", "slide.lambda.acceleration"}));
  EXPECT_EQ(test::run(scene.with_outputs({"C.acceleration", "displacement.value", "B"})).trajectory.columns(),
            (std::vector<std::string>{"C.ax", "C.ay", "displacement", "B.x", "B.y", "B.vx", "B.vy", "B.ax", "B.ay"}));
  EXPECT_EQ(test::run(sample("gough").with_outputs({"B1.position"})).trajectory.columns(),
            (std::vector<std::string>{"B1.x", "B1.y", "B1.z"}));
}

TEST(Trajectory, HasNoColumnTwice) {
  const Scene scene = sample("slider_crank:step=0.1,steps=10");
  const auto columns = [&](std::vector<std::string> outputs) {
    return test::simulator(scene.with_outputs(std::move(outputs))).columns();
  };
  EXPECT_EQ(columns({"C", "rod_angle.rate", "C", "rod_angle.rate", "C.velocity"}),
            (std::vector<std::string>{"C.x", "C.y", "C.vx", "C.vy", "C.ax", "C.ay", "rod_angle.rate"}));
  // Missing parts follow at the position of the repeated output.
  EXPECT_EQ(columns({"C.velocity", "B.position", "C"}),
            (std::vector<std::string>{"C.vx", "C.vy", "B.x", "B.y", "C.x", "C.y", "C.ax", "C.ay"}));
}

#ifdef MADV_POPULATE_WRITE
// False on a kernel without the advice (Linux 5.14), or if an emulator accepts and ignores it.
bool maps_pages_ahead() {
  void* const probe = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (probe == MAP_FAILED) return false;
  unsigned char resident = 0;
  const bool known = madvise(probe, 4096, MADV_POPULATE_WRITE) == 0 && mincore(probe, 4096, &resident) == 0;
  munmap(probe, 4096);
  return known && resident != 0;
}

long faults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt;
}
#endif

// Memory is touched before rows are written, so that no page fault occurs between rows.
TEST(Trajectory, TouchesItsMemoryBeforeTheRun) {
#ifndef MADV_POPULATE_WRITE
  GTEST_SKIP() << "no such advice here";
#else
  if (!maps_pages_ahead()) GTEST_SKIP() << "this kernel does not know MADV_POPULATE_WRITE";
  Simulator simulator = test::simulator(sample("stewart"));
  std::vector<long> at(2000);
  const Trajectory motion = simulator.run([&](std::int64_t done, std::int64_t) {
    at[static_cast<std::size_t>(done)] = faults();
    return false;
  });
  ASSERT_EQ(motion.rows(), 1001u);
  ASSERT_GT(motion.columns().size() * motion.rows() * sizeof(double), 800u * 4096u);
  // First accesses to other memory, also to shadow memory; there are 845 if most steps access a fresh page.
#ifdef ASSUR_ADDRESS_SANITIZER
  constexpr long kMost = 200;  // measured: 107
#else
  constexpr long kMost = 100;
#endif
  EXPECT_LT(at[1001] - at[1], kMost);
#endif
}

TEST(Trajectory, LargeRowsBeginALargePageAndSmallRowsAreMappedAtOnce) {
  constexpr std::size_t kLargePage = 2'097'152, kNumbers = kLargePage / sizeof(double);
  for (const std::size_t numbers : {2 * kNumbers / 3 + 1, kNumbers, 3 * kNumbers / 2, 7 * kNumbers / 3}) {
    RowValues large;
    large.reserve(numbers);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(large.data()) % kLargePage, 0u) << numbers;
    large.assign(numbers, 1);
    EXPECT_EQ(large.back(), 1);
  }
#ifdef MADV_POPULATE_WRITE
  if (!maps_pages_ahead()) GTEST_SKIP() << "this kernel does not know MADV_POPULATE_WRITE";
  std::vector<RowValues> all(20);  // fresh memory, too
  for (RowValues& small : all) small.reserve(kNumbers / 2);
  const long before = faults();
  for (RowValues& small : all) small.assign(kNumbers / 2, 1);
  // The first and the last page of each are shared with other memory; there are 5120 if each page is mapped at the
  // first write to it.
  EXPECT_LE(faults() - before, 40);
#endif
}

// Depending on the formulation, B1 is an unknown or an offset plus a multiple of another unknown. u belongs to the
// driver; A1 is fixed.
TEST(Trajectory, PartsOfAnOutputEqualTheWhole) {
  const Scene scene = sample("stewart:steps=20");
  std::vector<std::string> parts;
  for (const std::string item : {"B1", "u", "A1"}) {
    for (const char* part : {".acceleration", ".position", ".velocity"}) parts.push_back(item + part);
  }
  for (const std::string strategy : {"groups/eigen", "irreducible/eigen"}) {
    const Trajectory whole = test::run(scene.with_outputs({"B1", "u", "A1"}), strategy).trajectory;
    const Trajectory apart = test::run(scene.with_outputs(parts), strategy).trajectory;
    ASSERT_EQ(whole.columns().size(), apart.columns().size());
    for (const std::string& column : whole.columns()) {
      for (std::size_t k = 0; k < whole.rows(); ++k) {
        EXPECT_EQ(apart(k, apart.index(column)), whole(k, whole.index(column))) << column << " " << strategy;
      }
    }
    EXPECT_EQ(whole(20, whole.index("A1.vx")), 0);
    EXPECT_NE(whole(20, whole.index("A1.x")), 0);
  }
}

TEST(Trajectory, HasEverythingThatMovesWithoutOutputs) {
  const Trajectory t = test::run(sample("slider_crank:step=0.1,steps=10")).trajectory;
  for (const std::string name : {"B.x", "C.ay", "slide.lambda", "displacement.rate", "rod_angle.acceleration"}) {
    EXPECT_NO_THROW((void)t.index(name)) << name;
  }
  EXPECT_THROW((void)t.index("O.x"), Error);  // a fixed point has no columns
}

TEST(Trajectory, LastThrowsWithoutRows) {
  const Scene scene = sample("slider_crank:step=0.1,steps=10");
  Simulator simulator = test::simulator(scene);
  const Trajectory t = simulator.run(std::span<const double>{});
  ASSERT_EQ(t.rows(), 0u);
  EXPECT_THROW((void)t.last("B.x"), Error);
}

TEST(Trajectory, HasARowForEachGridTime) {
  const Scene scene = sample("four_bar:loops=2,step=0.01,steps=40");
  const Result r = test::run(scene);
  ASSERT_EQ(r.trajectory.rows(), 41u);
  EXPECT_EQ(r.trajectory.values().size(), 41 * r.trajectory.columns().size());
  for (std::int64_t k = 0; k <= 40; ++k) {
    EXPECT_EQ(r.trajectory.times()[static_cast<std::size_t>(k)], scene.time().time(k));
  }
  const std::size_t c = r.trajectory.index("B2.y");
  EXPECT_EQ(r.trajectory.last("B2.y"), r.trajectory(40, c));
  EXPECT_EQ(r.trajectory.row(40)[c], r.trajectory(40, c));
  EXPECT_EQ(r.trajectory.last("B2.y"), r.simulator.output("B2.y"));
  EXPECT_EQ(r.simulator.outputs()[c], r.simulator.output("B2.y"));
  EXPECT_EQ(r.simulator.columns(), r.trajectory.columns());
}

TEST(Trajectory, RefusesAnUnknownColumnAndListsKnownOnes) {
  const Result r = test::run(sample("four_bar:step=0.1,steps=2").with_outputs({"B1"}));
  try {
    (void)r.trajectory.index("B1.q");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::input);
    EXPECT_STREQ(e.what(), "no column 'B1.q'; did you mean 'B1.x'? There are: B1.x, B1.y, B1.vx, B1.vy, B1.ax, B1.ay");
  }
  EXPECT_THROW((void)r.simulator.output("B1.q"), Error);
}

TEST(Trajectory, AcceptsOwnTimesAndAnObserverThatStops) {
  const Scene scene = sample("four_bar:step=0.1,steps=10");
  Simulator s = test::simulator(scene);
  const std::vector<double> times = {0.05, 0.051, 0.4, 0.73};
  const Trajectory own = s.run(times);
  EXPECT_EQ(own.times(), times);
  EXPECT_EQ(s.report().counters.steps, 4);
  const Trajectory grid = s.run();
  EXPECT_NEAR(own.last("B1.x"), test::run(scene.with_time({0, 0.73, 0.73 / 100})).trajectory.last("B1.x"), 1e-14);

  std::vector<std::int64_t> seen;
  const Trajectory stopped = s.run([&](std::int64_t done, std::int64_t of) {
    EXPECT_EQ(of, 11);
    seen.push_back(done);
    return done >= 4;
  });
  EXPECT_EQ(seen, (std::vector<std::int64_t>{1, 2, 3, 4}));
  ASSERT_EQ(stopped.rows(), 4u);
  EXPECT_EQ(s.report().status.code, Code::interrupted);
  EXPECT_EQ(s.report().counters.stored_values, static_cast<std::int64_t>(4 * stopped.columns().size()));
  for (std::size_t i = 0; i < stopped.values().size(); ++i) EXPECT_EQ(stopped.values()[i], grid.values()[i]);
}

TEST(Trajectory, RefusesDescendingOrNonFiniteTimes) {
  Simulator s = test::simulator(sample("four_bar:step=0.1,steps=10"));
  ASSERT_TRUE(s.step(0.1).ok());
  const auto refusal = [&](const std::vector<double>& times) -> std::string {
    try {
      (void)s.run(times);
      return "none";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), Error::Kind::input);
      return e.what();
    }
  };
  EXPECT_EQ(refusal({0, 0.2, 0.125}), "time 2 of the run is 0.125000 s, after 0.200000 s; times must ascend");
  EXPECT_EQ(refusal({std::nan(""), 0.2}), "time 0 of the run is nan; it must be finite");
  EXPECT_EQ(refusal({0, HUGE_VAL}), "time 1 of the run is inf; it must be finite");
  EXPECT_EQ(s.time(), 0.1);  // no step was begun
  EXPECT_EQ(refusal({0, 0.2, 0.2}), "none");
}

TEST(Trajectory, AStepToANonFiniteTimeIsNotFinite) {
  for (const std::string controlled : {"", "motor"}) {
    Simulator s = test::simulator(sample("four_bar"), "auto", {},
                                  controlled.empty() ? std::vector<std::string>{} : std::vector{controlled});
    for (const double t : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      EXPECT_EQ(s.step(t).code, Code::not_finite);
      EXPECT_EQ(s.report().status.code, Code::not_finite);
      EXPECT_EQ(s.time(), 0);
    }
    EXPECT_TRUE(s.step(0.001).ok());
  }
}

TEST(Trajectory, CsvReadsBackTheSameDoubles) {
  const Trajectory t = test::run(sample("andrews")).trajectory;
  std::ostringstream out;
  write_csv(out, t);
  std::istringstream in(out.str());
  std::string line, header = "t";
  ASSERT_TRUE(std::getline(in, line));
  for (const std::string& c : t.columns()) header += "," + c;
  EXPECT_EQ(line, header);
  for (std::size_t k = 0; k < t.rows(); ++k) {
    ASSERT_TRUE(std::getline(in, line)) << k;
    std::istringstream cells(line);
    std::vector<double> values;
    for (std::string cell; std::getline(cells, cell, ',');) {
      double v = 0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), v);
      ASSERT_TRUE(error == std::errc() && end == cell.data() + cell.size()) << cell;
      values.push_back(v);
    }
    ASSERT_EQ(values.size(), t.columns().size() + 1);
    EXPECT_EQ(values[0], t.times()[k]);
    for (std::size_t c = 0; c < t.columns().size(); ++c) EXPECT_EQ(values[c + 1], t(k, c)) << k << " " << c;
  }
  EXPECT_FALSE(std::getline(in, line));
}

// B1 of the sample oscillates; the angle of the crank is unwrapped over ten turns.
TEST(Trajectory, AnglesAreUnwrapped) {
  const Scene four_bar = sample("four_bar:step=0.01,steps=1000");
  SceneBuilder builder("four_bar", 2);
  for (const Point& p : four_bar.points()) builder.add(p);
  for (const Constraint& c : four_bar.constraints()) builder.add(c);
  for (const Driver& d : four_bar.drivers()) builder.add(d);
  builder.measure("crank_angle", AbsoluteAngle{"A0", "B0"}).measure("back", AbsoluteAngle{"B0", "A0"});
  builder.output("crank_angle.value").output("back.value").time(0, 10, 0.01);
  const Trajectory t = test::run(builder.build()).trajectory;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double angle = 6.283185307179586 * t.times()[k];
    // The law's own rounding: a few eps of the angle.
    ASSERT_NEAR(t(k, 0), angle, 4 * kEps * (1 + angle)) << k;
    ASSERT_NEAR(t(k, 1), angle + 3.141592653589793, 4 * kEps * (4 + angle)) << k;  // starts at pi, not at -pi
  }
}

}  // namespace
}  // namespace assur
