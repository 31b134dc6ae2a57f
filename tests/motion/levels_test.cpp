// Packs of a level on several threads: the number of threads only changes the time.
#include "motion/levels.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>

#include "assur/machine.hpp"
#include "backends/allocations.hpp"
#include "motion/fan.hpp"
#include "parallel/thread_state.hpp"
#include "plan/preparation.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

using test::Result;

// Plans p x q threads within a budget of at least 4, which may exceed the number of cores.
Prepared as_planned(const Scene& scene, const std::string& solver, int p, int q = 1) {
  const std::string split = " " + std::to_string(p) + "x" + std::to_string(q);
  return prepare(scene, {solver + split, {}, ThreadBudget{std::max(4, p * q)}});
}

// A plan that shares every level among the threads, even if this gains no time.
Prepared prepared(const Scene& scene, const std::string& solver, int p, int q = 1) {
  Preparation all = preparation(as_planned(scene, solver, p, q));
  all.plan.level_threads.clear();
  return Preparation::shared(std::move(all));
}

int threads_of(const Prepared& p) {
  Layout layout = lay_out(preparation(p));
  return Levels(preparation(p), layout, {}).threads();
}

Result run(const Prepared& p, StepSettings settings = {}) {
  Simulator s(p, settings);
  Trajectory t = s.run();
  return {std::move(s), std::move(t)};
}

bool can_run(const std::string& solver) {
  const std::string id = solver.substr(solver.find('/') + 1);
  return find_backend(backends(), id.substr(0, id.find_first_of(":+"))).why_not({}, {}).empty();
}

// Compares whole runs with 1 to 4 threads. `threads` is the largest number of threads that have work.
void expect_no_bit_to_change(const Scene& scene, const std::string& solver, int threads = 4, int q = 1) {
  if (!can_run(solver)) return;
  const Result one = run(prepared(scene, solver, 1, q));
  for (int p = 2; p <= 4; ++p) {
    SCOPED_TRACE(scene.name() + " " + solver + " " + std::to_string(p) + "x" + std::to_string(q));
    const Prepared more = prepared(scene, solver, p, q);
    EXPECT_EQ(threads_of(more), std::min(p, threads));
    Result r = run(more);
    test::expect_same_run(one, r);
    const Trajectory again = r.simulator.run();  // a second run, with used workspaces
    test::expect_same_run(one, {std::move(r.simulator), again});
    if (testing::Test::HasFailure()) return;
  }
}

const std::vector<std::string> kSolvers = {
    "groups/eigen",    "groups/klu",           "groups/lanes:4",           "groups/lapack",
    "groups/klu+once", "groups/klu+reuse=run", "groups/lanes:2+reuse=run", "irreducible/lanes:8"};

TEST(Levels, ThreadsKeepRingsBitwiseEqual) {
  for (const std::string& solver : kSolvers) {
    expect_no_bit_to_change(sample("rings:legs=64,n=24,steps=12"), solver);
  }
}

TEST(Levels, ThreadsKeepStewartPlatformsBitwiseEqual) {
  for (const std::string& solver : kSolvers) {
    expect_no_bit_to_change(sample("stewart:platforms=8,steps=12"), solver);
  }
}

// The threads share the packs of all levels together.
TEST(Levels, ThreadsKeepLevelsTogetherBitwiseEqual) {
  for (const std::string scene : {"four_bar:loops=30,steps=60", "stewart:platforms=8,steps=12"}) {
    expect_no_bit_to_change(sample(scene), "irreducible/lanes:4+together");
  }
}

TEST(Levels, NestedThreadsKeepResultsBitwiseEqual) {
  expect_no_bit_to_change(sample("rings:legs=6,n=60,steps=4"), "groups/team", 4, 2);
  expect_no_bit_to_change(sample("rings:legs=6,n=60,steps=4"), "groups/team+once", 4, 2);
}

TEST(Levels, WithOneGroupUseOneThread) {
  for (const std::string solver : {"groups/eigen", "irreducible/lanes:8", "global/eigen"}) {
    expect_no_bit_to_change(sample("four_bar:loops=30,steps=20"), solver, 1);
  }
}

// Four dyads cost less than one synchronisation of the threads.
TEST(Levels, WithLittleWorkUseOneThread) {
  test::Fan fan("few", 0.5, Law::polynomial({0.5, 1}));
  for (int i = 0; i < 4; ++i) fan.dyad(2, 1.8, 1.3);
  EXPECT_EQ(threads_of(as_planned(fan.build(1, 0.01), "groups/eigen", 4)), 1);
}

TEST(Levels, UseNoMoreThreadsThanGroups) {
  EXPECT_EQ(threads_of(prepared(sample("rings:legs=3,n=120"), "groups/eigen", 4)), 3);
  EXPECT_EQ(threads_of(prepared(sample("rings:legs=2,n=120"), "groups/eigen", 4)), 2);
}

// ---- failures within a level

// Three dyads reach their limits at the same time, on different threads; the one with the lowest number is named.
TEST(Levels, NameTheFirstOfSeveralFailedGroups) {
  for (const std::set<int>& ending : {std::set{5, 8, 10}, std::set{1}, std::set{46, 47}}) {
    const Scene scene = test::limited_fan(ending);
    for (const std::string solver : {"groups/eigen", "groups/klu+once", "groups/lanes:2", "irreducible/lanes:4"}) {
      expect_no_bit_to_change(scene, solver);
      if (!can_run(solver)) continue;
      const Result r = run(prepared(scene, solver, 3));
      EXPECT_EQ(r.report().status.code, Code::fold);
      ASSERT_EQ(r.report().events.size(), 1u);
      EXPECT_EQ(r.report().events[0].group, "C" + std::to_string(*ending.begin())) << solver;
      EXPECT_LE(r.report().events[0].time, std::acos(0.04) - 0.5);
      EXPECT_GE(r.report().events[0].until, std::acos(0.04) - 0.5);
      EXPECT_GT(r.counters().rejected, 0);
    }
  }
}

TEST(Levels, PassSimultaneousChangePoints) {
  const Scene scene = test::fan_of_parallelograms();
  for (const std::string solver : {"groups/eigen", "groups/lanes:2", "irreducible/lanes:4"}) {
    expect_no_bit_to_change(scene, solver);
    const Result r = run(prepared(scene, solver, 2));
    EXPECT_TRUE(r.report().status.ok()) << solver;
    ASSERT_FALSE(r.report().events.empty());
    for (const Event& e : r.report().events) {
      EXPECT_EQ(e.kind, Code::change_point_passed);
      EXPECT_LE(e.time, 0.25);
      EXPECT_GE(e.until, 0.25);
    }
  }
}

// 24 triangles, each carried by the common crank and two rods parallel to it. One constraint of each triangle is
// redundant. For every choice of the redundant equation, the other equations become singular during the run, and
// another equation has to be left out.
Scene redundant() {
  constexpr double kStart = 1.5;
  const double x = std::cos(kStart), y = std::sin(kStart);
  SceneBuilder b("triangles", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {x, y, 0}).constrain("crank", Distance{"A", "B", 1.0});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({kStart, 1})});
  for (int i = 0; i < 24; ++i) {
    const std::string n = std::to_string(i);
    const double length = 2 + 0.0625 * i;
    b.fixed_point("D" + n, {length, 0, 0}).fixed_point("E" + n, {1, 1, 0});
    b.point("C" + n, {x + length, y, 0}).point("M" + n, {x + 1, y + 1, 0});
    b.constrain("base" + n, Distance{"B", "C" + n, length})
        .constrain("left" + n, Distance{"B", "M" + n, std::sqrt(2.0)});
    b.constrain("right" + n, Distance{"C" + n, "M" + n, std::hypot(length - 1, 1)});
    b.constrain("rocker" + n, Distance{"D" + n, "C" + n, 1.0}).constrain("third" + n, Distance{"E" + n, "M" + n, 1.0});
  }
  return b.time(0, 6, 0.05).build();
}

TEST(Levels, ThreadsKeepReselectedEquationsBitwiseEqual) {
  for (const std::string solver : {"groups/eigen", "irreducible/lanes:2"}) {
    expect_no_bit_to_change(redundant(), solver);
    const Result r = run(prepared(redundant(), solver, 2));
    EXPECT_TRUE(r.report().status.ok()) << name(r.report().status.code) << " at " << r.report().reached;
    const auto& fallbacks = r.report().fallbacks;
    EXPECT_TRUE(std::any_of(fallbacks.begin(), fallbacks.end(), [](const std::string& f) {
      return f.find("another independent set of the redundant equations") != std::string::npos;
    })) << solver;
    // The triangles do not rotate.
    const auto last = r.trajectory.rows() - 1;
    EXPECT_NEAR(r.trajectory(last, r.trajectory.index("C3.y")), std::sin(7.5), 1e-12) << solver;
  }
}

// ---- assignment to threads

// The dyads and the threads that solved them, in order.
struct Log {
  std::mutex mutex;
  std::vector<std::pair<int, std::thread::id>> entries;

  void note(int dyad) {
    const std::lock_guard lock(mutex);
    entries.emplace_back(dyad, std::this_thread::get_id());
  }
  [[nodiscard]] std::set<std::thread::id> threads() const {
    std::set<std::thread::id> ids;
    for (const auto& [dyad, id] : entries) ids.insert(id);
    return ids;
  }
};

TEST(Levels, UseTheRequestedThreads) {
  for (int p = 1; p <= 4; ++p) {
    Log log;
    test::Fan fan("called", 0.5, Law::polynomial({0.5, 1}));
    for (int i = 0; i < test::kWide; ++i) fan.dyad_by_callback(2, 1.8, 1.3 + 0.01 * i, [&](int d) { log.note(d); });
    Simulator s(prepared(fan.build(1, 0.01), "groups/eigen", p));
    log.entries.clear();
    for (int k = 1; k <= 5; ++k) ASSERT_TRUE(s.step(0.01 * k).ok());
    EXPECT_EQ(log.threads().size(), static_cast<std::size_t>(p));
    EXPECT_EQ(log.threads().count(std::this_thread::get_id()), 1u);
    // Each dyad is always solved by the same thread.
    std::set<std::pair<int, std::thread::id>> pairs(log.entries.begin(), log.entries.end());
    EXPECT_EQ(pairs.size(), static_cast<std::size_t>(test::kWide));
  }
}

// The last dyads form one group that costs more than all others: the calling thread solves only this group.
TEST(Levels, StartTheLongestPackFirst) {
  constexpr int kSmall = 9, kInTheLarge = 32;
  Log log;
  test::Fan fan("unequal", 0.5, Law::polynomial({0.5, 1}));
  DeclaredGroup large{"large", {}};
  for (int i = 0; i < kSmall + kInTheLarge; ++i) {
    fan.dyad_by_callback(2, 1.8, 1.3 + 0.01 * i, [&](int d) { log.note(d); });
    if (i < kSmall) {
      fan.builder().add(DeclaredGroup{"small" + std::to_string(i), {"C" + std::to_string(i)}});
    } else {
      large.unknowns.push_back("C" + std::to_string(i));
    }
  }
  fan.builder().add(large).add(DeclaredGroup{"first", {"B"}});
  const Prepared p = prepared(fan.build(1, 0.01), "groups/eigen", 2);
  ASSERT_EQ(p.structure().groups().size(), std::size_t{kSmall + 2});
  Simulator s(p);
  log.entries.clear();
  ASSERT_TRUE(s.step(0.01).ok());
  for (const auto& [dyad, id] : log.entries) {
    EXPECT_EQ(id == std::this_thread::get_id(), dyad >= kSmall) << dyad;
  }
}

// ---- exceptions, deadlines

struct Broken : std::runtime_error {
  Broken() : std::runtime_error("broken") {}
};

// One dyad throws, or three at once. After each exception the simulator keeps its posture and continues.
TEST(Levels, PropagateExceptionsOfCallbacksAndContinue) {
  std::set<int> broken;
  test::Fan fan("breaking", 0.5, Law::polynomial({0.5, 1}));
  for (int i = 0; i < test::kWide; ++i) {
    fan.dyad_by_callback(2, 1.8, 1.3 + 0.01 * i, [&](int d) {
      if (broken.count(d) != 0) throw Broken();
    });
  }
  const Scene scene = fan.build(1, 0.01);
  Simulator untroubled(prepared(scene, "groups/eigen", 1));
  for (int p = 1; p <= 4; ++p) {
    Simulator s(prepared(scene, "groups/eigen", p));
    double t = 0;
    for (const std::set<int>& these : {std::set{0}, std::set{1}, std::set{2}, std::set{3}, std::set{7, 20, 33}}) {
      ASSERT_TRUE(s.step(t += 0.01).ok());
      const std::vector<double> before(s.outputs().begin(), s.outputs().end());
      broken = these;
      for (int again = 0; again < 3; ++again) EXPECT_THROW((void)s.step(t + 0.01), Broken) << p;
      broken.clear();
      EXPECT_EQ(s.time(), t);
      EXPECT_EQ(before, std::vector<double>(s.outputs().begin(), s.outputs().end()));
    }
    ASSERT_TRUE(s.step(t += 0.01).ok());
    untroubled.reset();
    for (int k = 1; k <= 6; ++k) ASSERT_TRUE(untroubled.step(0.01 * k).ok());
    for (std::size_t c = 0; c < s.outputs().size(); ++c) {
      EXPECT_NEAR(s.outputs()[c], untroubled.outputs()[c], 1e-12 * (1 + std::abs(s.outputs()[c]))) << s.columns()[c];
    }
  }
}

// A long step is divided into substeps. An exception in a substep leaves the simulator at the posture reached so far,
// with the outputs of this posture.
TEST(Levels, AnExceptionInASubstepKeepsThePostureBeforeIt) {
  std::atomic<int> calls = 0, most = std::numeric_limits<int>::max();
  test::Fan fan("breaking", 0.5, Law::polynomial({0.5, 1}));
  for (int i = 0; i < test::kWide; ++i) {
    fan.dyad_by_callback(2, 1.8, 1.3 + 0.01 * i, [&](int) {
      if (++calls > most) throw Broken();
    });
  }
  const Scene scene = fan.build(1.5, 1.5);
  for (int p = 1; p <= 3; ++p) {
    int on_the_way = 0;
    for (int allowed = 100; allowed < 3000; allowed += 200) {
      Simulator s(prepared(scene, "groups/eigen", p));
      calls = 0;
      most = allowed;
      bool thrown = false;
      try {
        (void)s.step(1.5);
      } catch (const Broken&) {
        thrown = true;
      }
      most = std::numeric_limits<int>::max();
      const auto expect_posture = [&] {
        EXPECT_NEAR(s.output("B.x"), std::cos(0.5 + s.time()), 8 * kEps) << p << " " << allowed;
        EXPECT_NEAR(std::hypot(s.output("C7.x") - s.output("B.x"), s.output("C7.y") - s.output("B.y")), 1.8, 1e-14);
      };
      expect_posture();
      on_the_way += thrown && s.time() > 0 ? 1 : 0;
      EXPECT_EQ(s.time() == 1.5, !thrown);
      ASSERT_TRUE(s.step(1.5).ok());
      expect_posture();
    }
    EXPECT_GT(on_the_way, 0) << p;
  }
}

// The calling thread evaluates laws before the other threads start. After an exception, a control loop continues from
// the last posture.
TEST(Levels, AnExceptionOfALawKeepsTheLastPosture) {
  bool broken = false;
  test::Fan fan("no_sensor", 0.5, Law::function([&](double t) -> Motion {
                  if (broken) throw Broken();
                  return {0.5 + t, 1, 0};
                }));
  for (int i = 0; i < test::kWide; ++i) fan.dyad(2, 1.8, 1.3);
  Simulator s(prepared(fan.build(1, 0.01), "groups/eigen", 2));
  ASSERT_TRUE(s.step(0.01).ok());
  broken = true;
  EXPECT_THROW((void)s.step(0.02), Broken);
  broken = false;
  EXPECT_EQ(s.time(), 0.01);
  ASSERT_TRUE(s.step(0.02).ok());
  EXPECT_NEAR(s.output("B.x"), std::cos(0.52), 4 * kEps);
}

TEST(Levels, ADeadlineEndsAStep) {
  using std::chrono::milliseconds;
  std::optional<int> slow;
  test::Fan fan("slow", 0.5, Law::polynomial({0.5, 1}));
  for (int i = 0; i < test::kWide; ++i) {
    fan.dyad_by_callback(2, 1.8, 1.3 + 0.01 * i, [&](int d) {
      if (slow == d) std::this_thread::sleep_for(milliseconds(20));
    });
  }
  const Scene scene = fan.build(1, 0.01);
  for (int p = 1; p <= 4; ++p) {
    Simulator late(prepared(scene, "groups/eigen", p), {.seconds = 1e-9});
    EXPECT_EQ(late.step(0.01).code, Code::deadline);
    EXPECT_EQ(late.time(), 0);

    Simulator s(prepared(scene, "groups/eigen", p), {.seconds = 10});
    ASSERT_TRUE(s.step(0.01).ok());
    // Each thread stops at its first exception; its remaining packs are not solved.
    for (const int d : {0, 1, 2, 3}) {
      Simulator tight(prepared(scene, "groups/eigen", p), {.seconds = 5e-3});
      slow = d;
      const Status status = tight.step(0.01);
      slow.reset();
      EXPECT_EQ(status.code, Code::deadline) << p << " " << d;
      EXPECT_EQ(status.figure, 5e-3);
      EXPECT_EQ(tight.time(), 0);
      EXPECT_EQ(tight.report().counters.steps, 0);
    }
  }
}

// ---- the steady state, and pinned threads

std::int64_t allocations_of_steps(Simulator& s, double step) {
  for (int k = 1; k <= 3; ++k) EXPECT_TRUE(s.step(step * k).ok());
  const std::int64_t before = test::allocations();
  bool ok = true;
  for (int k = 4; k <= 12; ++k) ok = s.step(step * k).ok() && ok;
  const std::int64_t count = test::allocations() - before;
  EXPECT_TRUE(ok);
  return count;
}

TEST(Levels, StepsOnSeveralThreadsAllocateNothing) {
  for (const std::string scene : {"rings:legs=16,n=24", "stewart:platforms=4"}) {
    for (const std::string& solver : kSolvers) {
      // With groups of the platforms these solvers choose new pivots during the run, which allocates and is reported.
      const bool renews = scene[0] == 's' && solver.rfind("groups/lanes", 0) == 0;
      if (!can_run(solver) || renews) continue;
      Simulator s(prepared(sample(scene), solver, 2));
      EXPECT_EQ(allocations_of_steps(s, 0.01), 0) << scene << " " << solver;
      EXPECT_EQ(s.report().effort.renewed, 0);
    }
  }
}

TEST(Levels, PinnedThreadsStayOnTheirCores) {
  const std::vector<int> processors = allowed_processors();
  if (processors.size() < 2) GTEST_SKIP() << "two processors are needed";
  std::mutex mutex;
  std::set<std::vector<int>> seen;
  test::Fan fan("pinned", 0.5, Law::polynomial({0.5, 1}));
  for (int i = 0; i < test::kWide; ++i) {
    fan.dyad_by_callback(2, 1.8, 1.3 + 0.01 * i, [&](int) {
      const std::lock_guard lock(mutex);
      seen.insert(allowed_processors());
    });
  }
  const Scene scene = fan.build(1, 0.01);
  const std::vector<int> cores = {processors[1], processors[0]};
  Simulator s(prepared(scene, "groups/eigen", 2), {.pin_to = cores});
  seen.clear();
  ASSERT_TRUE(s.step(0.01).ok());
  EXPECT_EQ(seen, (std::set<std::vector<int>>{{cores[0]}, {cores[1]}}));
  EXPECT_EQ(allowed_processors(), processors);  // the calling thread is no longer pinned

  const Result free = run(prepared(sample("stewart:platforms=4,steps=5"), "groups/eigen", 2));
  test::expect_same_run(free,
                        run(prepared(sample("stewart:platforms=4,steps=5"), "groups/eigen", 2), {.pin_to = cores}));
  Simulator steady(prepared(sample("stewart:platforms=4"), "groups/eigen", 2), {.pin_to = cores});
  EXPECT_EQ(allocations_of_steps(steady, 0.01), 0);
}

TEST(Levels, CannotBePinnedToFewerProcessorsThanThreads) {
  try {
    Simulator s(prepared(sample("stewart:platforms=4"), "groups/eigen", 2), {.pin_to = {0}});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), Error::Kind::input);
  }
}

}  // namespace
}  // namespace assur
