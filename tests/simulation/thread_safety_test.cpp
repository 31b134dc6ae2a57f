// Simulators and ensembles in threads of the user give the same results as alone.
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#ifdef _OPENMP
#include <omp.h>
#endif

#include "assur/ensemble.hpp"
#include "motion/fan.hpp"
#include "parallel/in_a_child.hpp"
#include "sanitizers.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

using test::in_a_child;
using test::Result;

Prepared prepared(const Scene& scene, const std::string& strategy) {
  return prepare(scene, {strategy, {}, ThreadBudget{4}});
}

Result run(const Prepared& p) {
  Simulator s(p);
  Trajectory t = s.run();
  return {std::move(s), std::move(t)};
}

const Scene& platforms() {
  static const Scene scene = sample("stewart:platforms=4,steps=25");
  return scene;
}

// Strategies that this build can run.
std::vector<std::string> strategies() {
  std::vector<std::string> out = {"groups/eigen 2x1", "irreducible/lanes:4 2x1", "irreducible/lanes:8",
                                  "groups/eigen:4+chunks=4 2x1"};
  for (const std::string id : {"klu", "lapack", "mumps"}) {
    if (find_backend(backends(), id).why_not({}, {}).empty()) out.push_back("groups/" + id + " 2x1");
  }
  if (find_backend(backends(), "team").why_not({}, {}).empty()) out.push_back("groups/team 2x2");
  return out;
}

Ensemble ensemble(const std::string& strategy) {
  return {9, [=](std::size_t i) {
            const double omega = 0.5 + 0.1 * static_cast<double>(i);
            return prepared(sample("stewart", {{"omega", omega}, {"steps", 25}}), strategy);
          }};
}

void expect_same_values(const EnsembleTrajectory& a, const EnsembleTrajectory& b) {
  ASSERT_EQ(a.values().size(), b.values().size());
  for (std::size_t i = 0; i < a.values().size(); ++i) ASSERT_TRUE(test::same_bits(a.values()[i], b.values()[i])) << i;
}

// Runs `work` in two threads at once.
void in_two_threads(const std::function<void(int)>& work) {
  std::atomic<int> here = 0;
  const auto together = [&](int rank) {
    ++here;
    while (here < 2) std::this_thread::yield();
    work(rank);
  };
  std::thread other(together, 1);
  together(0);
  other.join();
}

TEST(ThreadSafety, TwoSimulatorsRunInTwoThreads) {
  for (const std::string& strategy : strategies()) {
    SCOPED_TRACE(strategy);
    const Prepared shared = prepared(platforms(), strategy);  // immutable, so that both threads may use it
    const Result alone = run(shared);
    std::optional<Result> side_by_side[2];
    in_two_threads([&](int rank) {
      for (int again = 0; again < 3; ++again) side_by_side[rank].emplace(run(shared));
    });
    for (const auto& r : side_by_side) test::expect_same_run(alone, *r);
  }
}

TEST(ThreadSafety, ScenesArePreparedInTwoThreads) {
  const Result alone = run(prepared(platforms(), "auto"));
  std::optional<Result> side_by_side[2];
  in_two_threads([&](int rank) { side_by_side[rank].emplace(run(prepared(platforms(), "auto"))); });
  for (const auto& r : side_by_side) test::expect_same_run(alone, *r);
}

// Exceptions and limits of one simulator do not affect the others.
TEST(ThreadSafety, ASimulatorThatFailsDoesNotDisturbItsNeighbour) {
  const Prepared good = prepared(platforms(), "groups/eigen 2x1");
  const Prepared bad = prepared(test::limited_fan({5, 8}), "groups/eigen 2x1");
  const Result alone[2] = {run(good), run(bad)};
  std::optional<Result> side_by_side[2];
  in_two_threads([&](int rank) { side_by_side[rank].emplace(run(rank == 0 ? good : bad)); });
  EXPECT_EQ(alone[1].report().status.code, Code::fold);
  for (int rank = 0; rank < 2; ++rank) test::expect_same_run(alone[rank], *side_by_side[rank]);
}

TEST(ThreadSafety, TwoEnsemblesRunInTwoThreads) {
  for (const std::string strategy : {"groups/eigen:2 2x1", "irreducible/lanes:4 2x1"}) {
    Ensemble one = ensemble(strategy);
    const EnsembleTrajectory alone = one.run();
    std::optional<EnsembleTrajectory> side_by_side[2];
    in_two_threads([&](int rank) {
      Ensemble mine = ensemble(strategy);
      for (int again = 0; again < 2; ++again) side_by_side[rank] = mine.run();
    });
    for (const auto& t : side_by_side) expect_same_values(alone, *t);
  }
}

TEST(ThreadSafety, OneSimulatorServesThreadsInTurn) {
  for (const std::string& strategy : strategies()) {
    SCOPED_TRACE(strategy);
    const Result alone = run(prepared(platforms(), strategy));
    std::optional<Simulator> s;
    std::thread([&] { s.emplace(prepared(platforms(), strategy)); }).join();  // the thread that made it has ended
    std::optional<Result> r;
    std::thread([&] {
      Trajectory t = s->run();
      r.emplace(Result{std::move(*s), std::move(t)});
    }).join();
    test::expect_same_run(alone, *r);
    Trajectory again = r->simulator.run();
    test::expect_same_rows(alone.trajectory, again);

    Simulator stepped(prepared(platforms(), strategy.substr(0, strategy.find("+chunks"))));
    Simulator by_one(prepared(platforms(), strategy.substr(0, strategy.find("+chunks"))));
    for (int k = 1; k <= 6; ++k) {
      std::thread([&] { EXPECT_TRUE(stepped.step(0.01 * k).ok()); }).join();
      ASSERT_TRUE(by_one.step(0.01 * k).ok());
      for (std::size_t c = 0; c < by_one.outputs().size(); ++c) {
        ASSERT_TRUE(test::same_bits(stepped.outputs()[c], by_one.outputs()[c])) << k << " " << by_one.columns()[c];
      }
    }
  }
}

#ifdef _OPENMP
TEST(ThreadSafety, ManySimulatorsRunInAParallelRegionOfTheUser) {
  constexpr int kMany = 8;
  for (const std::string& strategy : strategies()) {
    SCOPED_TRACE(strategy);
    const Prepared shared = prepared(platforms(), strategy);
    const Result alone = run(shared);
    std::optional<Result> results[kMany];
    std::atomic<int> inside = 0;
    const int before = omp_get_max_threads();
#pragma omp parallel for num_threads(3) schedule(dynamic)
    for (int i = 0; i < kMany; ++i) {
      inside += omp_in_parallel();
      results[i].emplace(run(shared));
    }
    EXPECT_EQ(inside, kMany);
    EXPECT_EQ(omp_get_max_threads(), before);  // the setting of the user
    for (const auto& r : results) test::expect_same_run(alone, *r);
  }
}

TEST(ThreadSafety, EnsemblesRunInAParallelRegionOfTheUser) {
  const EnsembleTrajectory alone = ensemble("groups/eigen:2 2x1").run();
  std::optional<EnsembleTrajectory> results[4];
#pragma omp parallel for num_threads(2)
  for (int i = 0; i < 4; ++i) results[i] = ensemble("groups/eigen:2 2x1").run();
  for (const auto& t : results) expect_same_values(alone, *t);
}
#endif

// ---- fork

class Forked : public testing::Test {
 protected:
  void SetUp() override {
#ifdef ASSUR_THREAD_SANITIZER
    GTEST_SKIP() << "ThreadSanitizer lets the child of a fork start no threads";
#endif
  }
};

bool same(const Trajectory& a, const Trajectory& b) {
  return a.times() == b.times() && a.values().size() == b.values().size() &&
         std::equal(a.values().begin(), a.values().end(), b.values().begin(), test::same_bits);
}

TEST_F(Forked, ASimulatorContinuesInChildAndParent) {
  for (const std::string& strategy : strategies()) {
    SCOPED_TRACE(strategy);
    const Prepared shared = prepared(platforms(), strategy);
    const Result alone = run(shared);
    Simulator s(shared);
    for (int k = 1; k <= 10; ++k) ASSERT_TRUE(s.step(0.01 * k).ok());
    Simulator ahead(shared);
    for (int k = 1; k <= 11; ++k) ASSERT_TRUE(ahead.step(0.01 * k).ok());
    const auto goes_on = [&] {
      const bool steps = s.step(0.11).ok() &&
                         std::equal(s.outputs().begin(), s.outputs().end(), ahead.outputs().begin(), test::same_bits);
      return steps && same(s.run(), alone.trajectory) ? 0 : 1;
    };
    EXPECT_EQ(in_a_child(goes_on), 0);
    EXPECT_EQ(in_a_child([&] { return in_a_child(goes_on); }), 0);
    // A new simulator runs in a child, too.
    EXPECT_EQ(in_a_child([&] { return same(run(shared).trajectory, alone.trajectory) ? 0 : 1; }), 0);
    EXPECT_EQ(goes_on(), 0);
  }
}

TEST_F(Forked, AnEnsembleRunsInChildAndParent) {
  Ensemble e = ensemble("groups/eigen:2 2x1");
  const EnsembleTrajectory alone = e.run();
  const auto runs = [&] {
    const EnsembleTrajectory t = e.run();
    return std::equal(t.values().begin(), t.values().end(), alone.values().begin(), alone.values().end(),
                      test::same_bits)
               ? 0
               : 1;
  };
  EXPECT_EQ(in_a_child(runs), 0);
  EXPECT_EQ(runs(), 0);
}

TEST_F(Forked, ASimulatorCanBeDestroyedInTheChild) {
  auto s = std::make_unique<Simulator>(prepared(platforms(), "groups/eigen 2x1"));
  ASSERT_TRUE(s->step(0.01).ok());
  EXPECT_EQ(in_a_child([&] {
              s.reset();
              return 0;
            }),
            0);
  EXPECT_TRUE(s->step(0.02).ok());
}

}  // namespace
}  // namespace assur
