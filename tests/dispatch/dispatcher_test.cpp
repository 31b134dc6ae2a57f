// Choices of `auto` on an artificial machine, and their reasons.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <regex>

#include "assur/assur.hpp"
#include "dispatch/candidates.hpp"
#include "dispatch/counts.hpp"
#include "dispatch/dispatcher.hpp"
#include "made_up_machine.hpp"

namespace assur {
namespace {

using namespace made_up;

std::shared_ptr<const PerformanceModel> model(double noise = 0.01, std::uint64_t seed = 1) {
  return std::make_shared<PerformanceModel>(samples(noise, seed));
}

std::string text_of(const Plan& plan) {
  std::string text(name(plan.run.formulation));
  for (const Plan::Choice& c : plan.choices) text += " " + to_string(plan.strategy(c));
  for (const std::int32_t p : plan.level_threads) text += " " + std::to_string(p);
  return text;
}

bool available(std::string_view id) { return find_backend(backends(), id).why_not({}, {}).empty(); }

TEST(Together, ThreadsSlowEachOtherDown) {
  EXPECT_DOUBLE_EQ(together(4, 4, 1, 1.5), 4);
  EXPECT_DOUBLE_EQ(together(3, 6, 2, 1.5), 4.5);  // both threads work all the time
  EXPECT_DOUBLE_EQ(together(3, 5, 2, 1.5), 4);    // both threads work for two thirds of the time
  EXPECT_DOUBLE_EQ(together(3, 3, 2, 1.5), 3);    // the second thread has nothing to do
  EXPECT_DOUBLE_EQ(together(2, 8, 4, 1.25), 2.5);
}

TEST(Dispatcher, ChoosesTheFastestStrategyOfTheMachine) {
  if (!available("klu")) GTEST_SKIP() << "without KLU";
  // Lanes that are a thousand times slower are not chosen.
  std::vector<Sample> other = samples();
  for (Sample& s : other) {
    if (s.strategy.solver.backend == "lanes" && (s.kernel == Kernel::factor || s.kernel == Kernel::solve))
      s.seconds *= 1000;
  }
  std::erase_if(other, [](const Sample& s) { return s.kernel == Kernel::pack; });
  const Scene scene = sample("rings:legs=3,n=120");
  const Plan usual = prepare(scene, {.budget = ThreadBudget{1}, .model = model()}).plan();
  const Plan strange =
      prepare(scene, {.budget = ThreadBudget{1}, .model = std::make_shared<PerformanceModel>(other)}).plan();
  for (const Plan::Choice& c : usual.choices) EXPECT_EQ(c.solver.backend, "lanes");
  EXPECT_EQ(strange.choices.back().solver.backend, "klu");
  for (const Plan::Choice& c : strange.choices) EXPECT_NE(c.solver.backend, "lanes");
}

TEST(Dispatcher, SolvesTheLevelsOfAChainTogether) {
  const auto plan_of = [](const std::string& text, std::vector<std::string> without = {}) {
    return prepare(sample(text), {.budget = ThreadBudget{1}, .model = model(), .without = std::move(without)}).plan();
  };
  const Plan chain = plan_of("four_bar:100");
  EXPECT_TRUE(chain.run.together);
  EXPECT_GE(chain.choices.at(0).solver.lanes, 8);
  EXPECT_NE(chain.reason.find("all levels together"), std::string::npos) << chain.reason;
  EXPECT_FALSE(plan_of("four_bar:2").run.together);  // one pack of eight would be slower
  EXPECT_FALSE(plan_of("stewart").run.together);     // one level
  EXPECT_FALSE(plan_of("four_bar:100", {"lanes"}).run.together);
}

// seconds: times of a pack with 4, 8 and 16 lanes.
Plan plan_of_chain(std::array<double, 3> seconds) {
  const Scene scene = sample("four_bar:100");
  std::mt19937_64 random(1);
  std::vector<Sample> known = samples();
  Sample alone = sample_of(Kernel::pack, class_shapes(group_equations(scene))[0], solver("lanes"), 0, random);
  alone.seconds = 50e-9;
  known.push_back(alone);
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    Sample s = alone;
    s.strategy.run.together = true;
    s.strategy.solver.lanes = 4 << i;
    s.seconds = seconds[i];
    known.push_back(s);
  }
  return prepare(scene, {.budget = ThreadBudget{1}, .model = std::make_shared<PerformanceModel>(known)}).plan();
}

TEST(Dispatcher, SolvesLevelsTogetherWithTheMeasuredLanes) {
  struct Case {
    std::array<double, 3> seconds;
    std::int32_t lanes, packs;
  };
  for (const Case& c :
       {Case{{50e-9, 180e-9, 300e-9}, 4, 25}, {{120e-9, 130e-9, 300e-9}, 8, 13}, {{120e-9, 180e-9, 200e-9}, 16, 7}}) {
    const Plan plan = plan_of_chain(c.seconds);
    ASSERT_TRUE(plan.run.together) << c.lanes;
    const Plan::Choice& choice = plan.choices.at(0);
    EXPECT_EQ(choice.solver.lanes, c.lanes);
    EXPECT_EQ(choice.origin, Origin::measured);
    const double pack = c.seconds[c.lanes == 4 ? 0 : c.lanes == 8 ? 1 : 2];
    EXPECT_EQ(choice.expected_seconds, pack);
    EXPECT_GT(plan.expected_seconds, c.packs * pack);  // and the time around the packs
  }
}

TEST(Dispatcher, SolvesLevelsOneByOneIfThatWasMeasuredAsFaster) {
  const Plan plan = plan_of_chain({400e-9, 800e-9, 1600e-9});
  EXPECT_FALSE(plan.run.together);
  EXPECT_TRUE(std::regex_search(plan.reason, std::regex("; all levels together would take [0-9.]+ times as long$")))
      << plan.reason;
}

TEST(Dispatcher, LeavesOutExcludedBackends) {
  const Scene scene = sample("stewart");
  const Plan plan = prepare(scene, {.budget = ThreadBudget{2}, .model = model(), .without = {"lanes"}}).plan();
  for (const Plan::Choice& c : plan.choices) EXPECT_NE(c.solver.backend, "lanes");
  EXPECT_THROW((void)prepare(scene, {.model = model(), .without = {"lane"}}), Error);
  std::vector<std::string> all;
  for (const Backend& backend : backends()) all.emplace_back(backend.id);
  try {
    (void)prepare(scene, {.model = model(), .without = all});
    FAIL() << "nothing is left";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_NE(std::string(error.what()).find("left out"), std::string::npos) << error.what();
  }
}

// The declared groups of this scene are invalid, because a block between them belongs to neither. `groups` is refused,
// and `auto` uses another formulation.
TEST(Dispatcher, SkipsAnImpossibleFormulation) {
  SceneBuilder b("between", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).point("C", {1, 0, 0});
  b.drive("crank", PointAngle{"A", "C", "", Law::polynomial({0, 1})});
  std::string before = "C";
  for (const std::string point : {"P", "Q", "R"}) {
    const double x = point == "P" ? 1.5 : point == "Q" ? 2.5 : 3.5;
    b.point(point, {x, 1, 0}).constrain(point + before, Distance{point, before, {}});
    b.constrain(point + "B", Distance{point, "B", {}});
    before = point;
  }
  const Scene scene = b.add(DeclaredGroup{"PR", {"P", "R"}}).time(0, 0.1, 0.01).build();
  EXPECT_THROW((void)prepare(scene, {.strategy = "groups/eigen"}), Error);
  const Prepared p = prepare(scene, {.budget = ThreadBudget{1}, .model = model()});
  EXPECT_NE(p.plan().run.formulation, Formulation::groups);
  Simulator s(p);
  EXPECT_EQ(s.run().rows(), 11u);
}

TEST(Dispatcher, NeverTakesMoreThreadsThanTheBudget) {
  for (const char* scene : {"stewart:platforms=64", "rings:legs=5,n=240", "four_bar:40"}) {
    for (const std::int32_t budget : {1, 2, 3, 5, 16}) {
      const Plan plan = prepare(sample(scene), {.budget = ThreadBudget{budget}, .model = model()}).plan();
      std::int32_t most_q = 1;
      for (const Plan::Choice& c : plan.choices) {
        EXPECT_LE(c.solver.threads, budget);
        most_q = std::max(most_q, c.solver.threads);
      }
      for (const std::int32_t p : plan.level_threads) EXPECT_LE(p, budget);
      EXPECT_LE(plan.run.threads, budget);
    }
  }
}

TEST(Dispatcher, SharesALevelOnlyIfItGains) {
  // The legs of a large mechanism are worth two threads; a single group on a level, or a small mechanism, is not.
  const Prepared many = prepare(sample("rings:legs=64,n=120"), {.budget = ThreadBudget{2}, .model = model()});
  ASSERT_EQ(many.plan().run.threads, 2);
  const std::vector<Group> groups = many.structure().groups();
  for (const Group& g : groups) {
    const auto on =
        std::count_if(groups.begin(), groups.end(), [&](const Group& other) { return other.level == g.level; });
    EXPECT_EQ(many.plan().level_threads[static_cast<std::size_t>(g.level)], on > 1 ? 2 : 1) << g.name;
  }
  const Prepared few = prepare(sample("stewart"), {.budget = ThreadBudget{2}, .model = model()});
  EXPECT_EQ(few.plan().run.threads, 1);
}

TEST(Dispatcher, UsesOnlyMeasuredNumbersOfThreads) {
  std::vector<Sample> alone = samples();
  std::erase_if(alone, [](const Sample& s) { return s.kernel == Kernel::meeting; });
  const Scene scene = sample("rings:legs=64,n=120");
  const auto plan_by = [&](std::vector<Sample> known, std::int32_t threads, Mode mode = Mode::latency) {
    return prepare(scene, {.budget = ThreadBudget{threads},
                           .mode = mode,
                           .model = std::make_shared<PerformanceModel>(std::move(known))})
        .plan();
  };
  const Plan plan = plan_by(alone, 2);
  EXPECT_EQ(plan.run.threads, 1);
  for (const Plan::Choice& c : plan.choices) EXPECT_EQ(c.threads * c.solver.threads, 1);
  EXPECT_EQ(plan.reason,
            "one thread: several threads were not measured; `assur tune` with two threads or more measures them");
  EXPECT_EQ(plan_by(alone, 1).reason, "one thread: the budget has only one");
  EXPECT_TRUE(plan_by(samples(), 2).reason.ends_with(" times as fast as one")) << plan_by(samples(), 2).reason;
  EXPECT_TRUE(plan_by({}, 2).reason.ends_with(" times as fast as one, not measured")) << plan_by({}, 2).reason;
  EXPECT_TRUE(plan_by(alone, 2, Mode::throughput).reason.ends_with("; several threads were not measured"));
}

// With slow communication a level gains from a second thread only if this thread also computes outputs.
TEST(Dispatcher, SharesALevelForItsOutputs) {
  std::vector<Sample> slow = samples();
  Sample handover;
  handover.kernel = Kernel::meeting;
  handover.strategy.run.threads = 2;
  handover.shape.n = 4000;
  handover.seconds = kAloneBeforeMeeting + 4000 * 2e-9;
  slow.push_back(handover);
  const auto known = std::make_shared<PerformanceModel>(slow);
  const auto shared = [&](const Scene& scene) {
    const Plan plan = prepare(scene, {.budget = ThreadBudget{2}, .model = known}).plan();
    return std::count_if(plan.level_threads.begin(), plan.level_threads.end(), [](auto p) { return p > 1; });
  };
  EXPECT_EQ(shared(sample("stewart:platforms=100")), 1);
  EXPECT_EQ(shared(sample("stewart:platforms=100").with_outputs({"O_1"})), 0);
}

TEST(Dispatcher, DecidesTheSameFromTheSameSamples) {
  for (const char* scene : {"stewart", "rings:legs=5,n=78", "andrews", "four_bar:23"}) {
    std::vector<Sample> known = samples();
    const auto first = text_of(
        prepare(sample(scene), {.budget = ThreadBudget{2}, .model = std::make_shared<PerformanceModel>(known)}).plan());
    std::reverse(known.begin(), known.end());
    EXPECT_EQ(
        text_of(prepare(sample(scene), {.budget = ThreadBudget{2}, .model = std::make_shared<PerformanceModel>(known)})
                    .plan()),
        first);
  }
}

// The times of two tuning runs differ by noise.
TEST(Dispatcher, TuningAgainChangesNoBackend) {
  for (const char* scene : {"stewart", "rings:legs=5,n=78", "andrews", "four_bar:23"}) {
    std::vector<std::string> first;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Plan plan = prepare(sample(scene), {.budget = ThreadBudget{2}, .model = model(0.02, seed)}).plan();
      std::vector<std::string> chosen;
      for (const Plan::Choice& c : plan.choices) chosen.push_back(c.solver.backend);
      if (seed == 1) first = chosen;
      EXPECT_EQ(chosen, first) << scene << " seed " << seed;
    }
  }
}

TEST(Dispatcher, LosesNoMoreThanTheModelsUncertainty) {
  const std::shared_ptr<const PerformanceModel> known = model(0.02);
  double sum = 0;
  int count = 0;
  for (const std::int32_t n : {5, 9, 15, 22, 45, 78, 130, 334}) {
    for (const bool full : {false, true}) {
      for (const std::int32_t groups : {1, 5, 11, 23, 384}) {
        const Shape shape = full ? full_shape(n, groups) : sparse_shape(n, groups);
        // Leaves out candidates of which the artificial machine has no samples.
        std::vector<Candidate> ranked =
            candidates(shape, {.model = known,
                               .budget = ThreadBudget{1},
                               .without = {"lapack", "team", "umfpack", "mumps", "ma27", "cusolver", "magma"}});
        std::erase_if(ranked, [](const Candidate& c) { return !c.why_not.empty() || c.strategy.solver.single; });
        const auto seconds = [&](const Candidate& c) {
          return std::ceil(static_cast<double>(groups) / c.strategy.solver.lanes) *
                 truth(Kernel::pack, shape, c.strategy);
        };
        const Candidate& best = *std::min_element(
            ranked.begin(), ranked.end(), [&](const auto& a, const auto& b) { return seconds(a) < seconds(b); });
        const double ratio = seconds(ranked[0]) / seconds(best);
        EXPECT_LT(std::log(ratio), 2 * std::log(ranked[0].factor * best.factor) + 0.02)
            << "n = " << n << " full " << full << " groups " << groups << ": " << to_string(ranked[0].strategy)
            << " instead of " << to_string(best.strategy);
        sum += ratio - 1;
        ++count;
      }
    }
  }
  EXPECT_LT(sum / count, 0.02);
}

// Whole steps of a mechanism that were measured decide between their strategies, in all formulations.
TEST(Dispatcher, MeasuredStepsCountMoreThanTheirParts) {
  const Scene scene = sample("stewart");
  std::vector<Sample> known = samples();
  const auto plan_of = [&](const Scene& of, std::vector<std::string> without = {}) {
    return prepare(of, {.budget = ThreadBudget{1},
                        .model = std::make_shared<PerformanceModel>(known),
                        .without = std::move(without)})
        .plan();
  };
  const Plan by_parts = plan_of(scene), other = plan_of(sample("stewart:platforms=2"));
  EXPECT_EQ(by_parts.reason.find("whole steps"), std::string::npos) << by_parts.reason;
  const double usual = by_parts.expected_seconds;
  std::mt19937_64 random(1);
  for (const Formulation formulation : {Formulation::irreducible, Formulation::groups, Formulation::global}) {
    const GroupedSystem structure = group_equations(scene, {.formulation = formulation});
    const Shape step = shape_of_step(structure, class_shapes(structure));
    for (const char* backend : {"lanes", "eigen"}) {
      Strategy strategy = solver(backend);
      strategy.run.formulation = formulation;
      known.push_back(sample_of(Kernel::step, step, strategy, 0, random));
      const bool is_fast = formulation == Formulation::groups && std::string(backend) == "eigen";
      known.back().seconds = (is_fast ? 2 : 50) * usual;
    }
  }
  const Plan measured = plan_of(scene);
  EXPECT_EQ(measured.run.formulation, Formulation::groups);
  for (const Plan::Choice& c : measured.choices) EXPECT_EQ(c.solver.backend, "eigen");
  EXPECT_EQ(measured.expected_seconds, 2 * usual);
  EXPECT_NE(measured.reason.find("whole steps were measured"), std::string::npos) << measured.reason;
  for (const Plan::Choice& c : plan_of(scene, {"eigen"}).choices) EXPECT_NE(c.solver.backend, "eigen");
  EXPECT_EQ(text_of(plan_of(sample("stewart:platforms=2"))), text_of(other));
}

TEST(Dispatcher, FillsLanesWithMechanismsInThroughput) {
  const Plan plan =
      prepare(sample("stewart"), {.budget = ThreadBudget{3}, .mode = Mode::throughput, .model = model()}).plan();
  EXPECT_EQ(plan.run.threads, 3);
  EXPECT_GE(plan.lanes, 8);
  for (const Plan::Choice& c : plan.choices) EXPECT_EQ(c.solver.lanes, plan.lanes);
}

Pattern dense_pattern() {
  Pattern dense;
  dense.n = 40;
  dense.column_start = {0};
  for (std::int32_t j = 0; j < dense.n; ++j) {
    for (std::int32_t i = 0; i < dense.n; ++i) dense.row.push_back(i);
    dense.column_start.push_back(dense.nnz());
  }
  return dense;
}

TEST(ChooseSolver, ChoosesForManyLinearSystems) {
  const Pattern dense = dense_pattern();
  const Candidate one = choose_solver(dense, 1, 1, {.model = model(), .budget = ThreadBudget{1}});
  EXPECT_EQ(one.strategy.solver.lanes, 1);
  EXPECT_EQ(one.why_not, "");
  EXPECT_GT(one.expected_seconds, 0);
  const Candidate many = choose_solver(dense, 1000, 2, {.model = model(), .budget = ThreadBudget{1}});
  EXPECT_EQ(many.strategy.solver.backend, "lanes");
  EXPECT_GE(many.strategy.solver.lanes, 8);
  EXPECT_THROW((void)choose_solver(dense, 0), Error);
  EXPECT_THROW((void)choose_solver(dense, 1, -1), Error);
}

// Backend::make() does not refine, so that factors in float would cost accuracy, however fast they are.
TEST(ChooseSolver, TakesSolversInDouble) {
  const Pattern dense = dense_pattern();
  const Shape shape = shape_of(dense, 1000);
  std::mt19937_64 random(1);
  std::vector<Sample> known = samples();
  Strategy in_float = solver("lanes", 16);
  in_float.solver.single = true;
  for (const Kernel kernel : {Kernel::factor, Kernel::solve}) {
    known.push_back(sample_of(kernel, shape, in_float, 0, random));
    known.back().seconds = 1e-9;
  }
  const CandidateOptions options{.model = std::make_shared<PerformanceModel>(known), .budget = ThreadBudget{1}};
  ASSERT_TRUE(candidates(shape, options)[0].strategy.solver.single);
  const Candidate chosen = choose_solver(dense, 1000, 1, options);
  EXPECT_FALSE(chosen.strategy.solver.single);
  EXPECT_EQ(chosen.why_not, "");
}

TEST(Candidates, UseOneThreadForShortSolutions) {
  const auto shares = [](std::int32_t n) {
    const std::vector<Candidate> all = candidates(full_shape(n, 1), {.model = model(), .budget = ThreadBudget{2}});
    return std::any_of(all.begin(), all.end(), [](const Candidate& c) { return c.strategy.solver.threads > 1; });
  };
  EXPECT_FALSE(shares(2));
  const bool can = std::any_of(backends().begin(), backends().end(),
                               [](const Backend& b) { return b.why_not(full_shape(720, 1), ThreadBudget{2}).empty(); });
  EXPECT_EQ(shares(720), can);
}

TEST(Candidates, SayWhyTheyCannotRun) {
  std::vector<Sample> known = samples();
  for (Sample& s : known) {
    if (s.kernel == Kernel::solve && s.strategy.solver.backend == "eigen") s.backward_error = 1e-3;
  }
  const auto ranked =
      candidates(sparse_shape(22, 4),
                 {.model = std::make_shared<PerformanceModel>(known), .budget = ThreadBudget{2}, .without = {"lanes"}});
  ASSERT_FALSE(ranked.empty());
  const bool others = std::any_of(backends().begin(), backends().end(), [](const Backend& b) {
    return b.id != "eigen" && b.id != "lanes" && b.why_not(sparse_shape(22, 4), {}).empty();
  });
  EXPECT_EQ(ranked[0].why_not.empty(), others);
  for (const Candidate& c : ranked) {
    EXPECT_EQ(c.strategy.solver.backend == "lanes", c.why_not == "left out");
    if (c.strategy.solver.backend == "eigen" && !c.strategy.solver.single) {
      EXPECT_EQ(c.why_not, "its solutions had a backward error of 1.0e-03");
    }
  }
}

}  // namespace
}  // namespace assur
