// Offered candidates run; other candidates are refused with the given reason.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "assur/assur.hpp"
#include "backends/backends.hpp"
#include "files/shipped_files.hpp"
#include "samples/samples.hpp"

namespace assur {
namespace {

constexpr ThreadBudget kBudget{2};

// A few steps of every scene of scenes/ and of every other sample.
std::vector<Scene> shipped() {
  std::vector<Scene> scenes;
  for (const auto& file : test::shipped_files()) scenes.push_back(read_scene(file));
  for (const samples::SampleMechanism& s : samples::table()) {
    if (std::ranges::none_of(scenes, [&](const Scene& scene) { return scene.name() == s.name; })) {
      scenes.push_back(sample(s.name));
    }
  }
  for (Scene& scene : scenes) {
    const TimeGrid grid = scene.time();
    scene = scene.with_time({grid.start, grid.start + 3 * grid.step, grid.step});
  }
  return scenes;
}

std::vector<std::string> all_but(std::string_view id) {
  std::vector<std::string> others;
  for (const Backend& b : backends()) {
    if (b.id != id) others.emplace_back(b.id);
  }
  return others;
}

// "" if the scene runs to the end.
std::string outcome(const Scene& scene, const PrepareOptions& options) {
  try {
    Simulator simulator(prepare(scene, options));
    (void)simulator.run();
    const Status status = simulator.report().status;
    return status.ok() ? "" : std::string(name(status.code));
  } catch (const Error& error) {
    return error.what();
  }
}

// Text of each candidate for a class of the plan, and why it cannot run.
std::map<std::string, std::string> offered(const Prepared& prepared, const PrepareOptions& options) {
  std::map<std::string, std::string> all;
  for (const Plan::Choice& choice : prepared.plan().choices) {
    for (Candidate& c : candidates(choice.shape, {.budget = options.budget, .without = options.without})) {
      c.strategy.run.formulation = prepared.plan().run.formulation;
      all[to_string(c.strategy)] = c.why_not;
    }
    all[to_string(prepared.plan().strategy(choice))] = "";
  }
  return all;
}

void expect_as_offered(const Scene& scene, const PrepareOptions& options) {
  SCOPED_TRACE(scene.name());
  ASSERT_EQ(outcome(scene, options), "");
  for (const auto& [text, why_not] : offered(prepare(scene, options), options)) {
    const Strategy strategy = parse_strategy(text);
    if (!why_not.empty() && find_backend(backends(), strategy.solver.backend).why_not({}, {}).empty() &&
        find_backend(backends(), strategy.solver.backend).device) {
      continue;  // a GPU that runs is only considered for large groups
    }
    PrepareOptions forced = options;
    forced.strategy = text;
    const std::string ended = outcome(scene, forced);
    if (why_not.empty()) {
      EXPECT_EQ(ended, "") << text;
    } else {
      EXPECT_NE(ended.find(why_not), std::string::npos)
          << text << " is refused by \"" << ended << "\", not by \"" << why_not << "\"";
    }
  }
}

TEST(Offers, RunOrAreRefusedWithTheReasonGiven) {
  for (const Scene& scene : shipped()) {
    expect_as_offered(scene, {.budget = kBudget});
    expect_as_offered(scene, {.budget = ThreadBudget{1}, .without = {"lanes", "klu"}, .accuracy = 1e-6});
  }
}

TEST(Offers, RunForThroughput) {
  for (const Scene& scene : shipped()) expect_as_offered(scene, {.budget = kBudget, .mode = Mode::throughput});
}

// Only one backend is available at a time.
TEST(Offers, RunWithASingleBackend) {
  const Scene scene = sample("stewart:steps=5"), long_enough_for_chunks = sample("stewart:steps=250");
  for (const Backend& backend : backends()) {
    if (!backend.why_not({}, {}).empty()) continue;
    for (const Mode mode : {Mode::latency, Mode::throughput}) {
      const PrepareOptions options{.budget = kBudget, .mode = mode, .without = all_but(backend.id)};
      expect_as_offered(scene, options);
      EXPECT_EQ(outcome(long_enough_for_chunks, options), "") << backend.id;
      Ensemble side_by_side(9, [&](std::size_t i) {
        return prepare(sample("stewart:steps=5", {{"omega", 0.5 + 0.1 * static_cast<double>(i)}}), options);
      });
      (void)side_by_side.run();
      EXPECT_TRUE(side_by_side.report().status.ok()) << backend.id;
    }
  }
}

// Backends that solve one group at a time are not offered with several threads.
TEST(Offers, LeaveOutIdleThreads) {
  for (const Backend& backend : backends()) {
    if (!backend.takes_turns || !backend.why_not({}, {}).empty()) continue;
    const Prepared prepared = prepare(sample("stewart"), {.budget = kBudget, .without = all_but(backend.id)});
    EXPECT_EQ(prepared.plan().run.threads, 1);
    for (const Candidate& c : candidates(prepared.plan().choices[0].shape, {.budget = kBudget})) {
      EXPECT_FALSE(c.strategy.solver.backend == backend.id && c.strategy.run.threads > 1) << to_string(c.strategy);
    }
  }
}

TEST(Offers, RefuseAStrategyWithAnExcludedSolver) {
  EXPECT_EQ(outcome(sample("stewart:steps=2"), {.strategy = "irreducible/lanes", .without = {"lanes"}}),
            "backend lanes cannot run here: left out");
}

}  // namespace
}  // namespace assur
