// All strategies give the same motion of all mechanisms, within bounds from residuals and conditions of postures.
#include <gtest/gtest.h>

#include "errors/conditions.hpp"
#include "files/shipped_files.hpp"
#include "motion/limited.hpp"
#include "plan/preparation.hpp"
#include "properties/random_strategy.hpp"
#include "properties/small_random_scenes.hpp"

namespace assur {
namespace {

using test::Draw;

using test::Result;

constexpr ThreadBudget kBudget{4};

constexpr int kMostGroupsAtOnce = 2;  // p of the paper's strategies

// The forward error is measured with the reference in quad precision. It is bounded by the residual r and the condition
// c: r c for positions, r c^2 for rates, r c^3 for accelerations, relative to the largest output of the scene.
void expect_the_motion_of_the_reference(const Scene& scene, const std::string& strategy, double condition) {
  SCOPED_TRACE(scene.name() + " " + strategy);
  Simulator s(prepare(scene, {strategy, {}, kBudget}));
  const Trajectory t = s.run();
  const Report& report = s.report();
  ASSERT_EQ(report.status.code, Code::ok) << "at " << report.reached;
  ASSERT_EQ(t.rows(), static_cast<std::size_t>(scene.time().steps()) + 1);
  // Newton's method ends at residuals of 8 eps, the refinement of linear systems at four times as much.
  EXPECT_GT(report.error.position, 0);
  EXPECT_LE(report.error.position, 1e-13);
  EXPECT_LE(report.error.velocity, 1e-13);
  // Systems that are solved for some of their unknowns only are not measured (report.hpp).
  if (!std::isnan(report.error.acceleration)) {
    EXPECT_LE(report.error.acceleration, 1e-13);
  }

  const double residual = test::residual_of(report, report);
  // Forward errors are relative to each output, the bound to the largest output of its kind.
  double spread[3] = {1, 1, 1}, largest[3] = {0, 0, 0}, smallest[3];
  std::fill(smallest, smallest + 3, std::numeric_limits<double>::infinity());
  std::map<std::pair<std::string, int>, double> outputs;  // largest values; the components of a point share one
  for (std::size_t c = 0; c < t.columns().size(); ++c) {
    const std::string& column = t.columns()[c];
    const int d = test::derivative_of(column);
    double& size = outputs[{column.substr(0, column.find('.')), d}];
    for (std::size_t k = 0; k < t.rows(); ++k) size = std::max(size, std::abs(t(k, c)));
  }
  for (const auto& [name, size] : outputs) {
    largest[name.second] = std::max(largest[name.second], size);
    if (size > 0) smallest[name.second] = std::min(smallest[name.second], size);
  }
  for (int d = 0; d < 3; ++d) spread[d] = largest[d] > 0 ? largest[d] / smallest[d] : 1;
  const ForwardError e = forward_error(s.prepared(), t);
  EXPECT_LE(e.position, residual * condition * spread[0]);
  EXPECT_LE(e.velocity, residual * std::pow(condition, 2) * spread[1]);
  EXPECT_LE(e.acceleration, residual * std::pow(condition, 3) * spread[2]);
}

double worst_condition(const Scene& scene) {
  const std::vector<double> all = test::conditions(scene, test::grid_of(scene), 5);
  return *std::max_element(all.begin(), all.end());
}

std::string any_strategy(Draw& draw, const Scene& scene) {
  Strategy s = test::random_strategy(draw, scene);
  s.run.chunks = draw.maybe() ? 1 : 1 + static_cast<std::int32_t>(draw.below(9));
  return to_string(s);
}

TEST(Strategies, AllGiveTheSameMotionOfRandomMechanisms) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Draw draw(seed);
    const Scene scene = seed % 2 == 0 ? test::planar_mechanism(draw) : test::spatial_mechanism(draw);
    const double condition = worst_condition(scene);
    for (int k = 0; k < 4; ++k) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", condition " + std::to_string(condition));
      expect_the_motion_of_the_reference(scene, any_strategy(draw, scene), condition);
      if (testing::Test::HasFailure()) return;
    }
  }
}

// Every solver of this build in every formulation, alone and in lanes, with each way to factorise.
std::vector<std::string> every_kind_of_strategy() {
  std::vector<std::string> out;
  for (const std::string formulation : {"global/", "groups/", "irreducible/"}) {
    for (const Backend* backend : test::backends_here()) {
      for (const std::string options : {"", ":4+once", "+separate", ":8+reuse=run", "+reuse=step+refine"}) {
        out.push_back(formulation + std::string(backend->id) + options);
      }
      if (backend->single) out.push_back(formulation + std::string(backend->id) + ":2+float");
    }
  }
  return out;
}

TEST(Strategies, AllGiveTheSameMotionOfShippedScenes) {
  int moving = 0;
  for (const auto& file : test::shipped_files()) {
    const Scene whole = read_scene(file);
    const TimeGrid grid = whole.time();
    const Scene scene = whole.with_time({grid.start, grid.start + 10 * grid.step, grid.step});
    if (preparation(prepare(scene)).structure->groups.empty())
      continue;  // nothing moves, so that no strategy solves anything
    ++moving;
    const double condition = worst_condition(scene);
    for (const std::string& strategy : every_kind_of_strategy()) {
      expect_the_motion_of_the_reference(scene, strategy, condition);
      if (testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GE(moving, 5);
}

// ---- the strategies of the paper

struct OfThePaper {
  std::string name, strategy;
};

std::vector<OfThePaper> strategies_of_the_paper() {
  std::vector<OfThePaper> out = {
      {"GMKL", "global/lapack"},      {"GMKL", "global/lapack 1x2"},    {"GMA27", "global/klu"},
      {"GMA27", "global/mumps"},      {"GMA27", "global/ma27"},         {"GEMKL", "groups/lapack"},
      {"GEMKL", "groups/lapack 1x2"}, {"GEOMP+MKL", "groups/team 1x2"}, {"GEOMP+MA27", "groups/klu"}};
  for (int p = 2; p <= kMostGroupsAtOnce; ++p) {
    const std::string split = " " + std::to_string(p);
    for (const std::string& strategy : {"groups/team" + split + "x2", "groups/lapack" + split + "x1"}) {
      out.push_back({"GEOMP+MKL", strategy});
    }
    out.push_back({"GEOMP+MA27", "groups/klu" + split + "x1"});
  }
  return out;
}

TEST(Strategies, OfThePaperRun) {
  const Scene scene = sample("stewart:steps=20");
  const double condition = worst_condition(scene);
  for (const OfThePaper& s : strategies_of_the_paper()) {
    const Strategy parsed = parse_strategy(s.strategy);
    if (!find_backend(backends(), parsed.solver.backend).why_not({}, ThreadBudget{parsed.solver.threads}).empty())
      continue;
    SCOPED_TRACE(s.name);
    expect_the_motion_of_the_reference(scene, s.strategy, condition);
    // The paper allows several readings: velocity and acceleration share a factorisation or have one each, and a whole
    // step may use one factorisation.
    for (const std::string reading : {"+separate", "+once"}) {
      const std::size_t end = std::min(s.strategy.find(' '), s.strategy.size());
      expect_the_motion_of_the_reference(scene, s.strategy.substr(0, end) + reading + s.strategy.substr(end),
                                         condition);
    }
  }
}

// The assignment of packs to threads does not change the results.
TEST(Strategies, AreBitwiseEqualForAllThreads) {
  const Scene platform = sample("stewart:legs=22,steps=40"), rings = sample("rings:legs=7,n=60,steps=20");
  const Scene limited = test::limited_four_bar(Law::polynomial({0.5, 1})).time(0, 2, 0.01).build();
  for (const Scene& scene : {platform, rings, limited}) {
    for (const Backend* backend : test::backends_here()) {
      const std::string id(backend->id);
      if (id == "mumps" || id == "ma27") continue;  // these use one thread
      for (const std::string& head :
           {"groups/" + id, "irreducible/" + id + ":4+once", "groups/" + id + ":2+reuse=run"}) {
        Simulator one(prepare(scene, {head, {}, kBudget}));
        const Trajectory expected = one.run();
        for (const std::string split : {" 2x1", " 3x1"}) {
          SCOPED_TRACE(scene.name() + " " + head + split);
          Simulator more(prepare(scene, {head + split, {}, kBudget}));
          EXPECT_EQ(more.run().values(), expected.values());
          EXPECT_EQ(more.run().values(), expected.values());
          EXPECT_EQ(more.report().status.code, one.report().status.code);
          EXPECT_EQ(more.report().counters.newton_iterations, one.report().counters.newton_iterations);
          EXPECT_EQ(more.report().counters.factorizations, one.report().counters.factorizations);
          EXPECT_EQ(more.report().error.position, one.report().error.position);
          EXPECT_EQ(more.report().events.size(), one.report().events.size());
        }
      }
    }
  }
}

TEST(Strategies, ExplainWhyTheyCannotRun) {
  const Scene scene = sample("four_bar:step=0.1,steps=2");
  const auto refusal = [&](const std::string& strategy, ThreadBudget budget) -> std::string {
    try {
      (void)prepare(scene, {strategy, {}, budget});
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), Error::Kind::environment) << strategy;
      return e.what();
    }
    ADD_FAILURE() << strategy << " runs";
    return "";
  };
  for (const Backend& b : backends()) {
    const std::string id(b.id);
    const std::string why = b.why_not({}, {});
    if (!why.empty()) {
      EXPECT_EQ(refusal("groups/" + id, kBudget), "backend " + id + " cannot run here: " + why);
      continue;
    }
    if (!b.single) {
      EXPECT_NE(refusal("groups/" + id + "+float", kBudget).find("it has no float version"), std::string::npos);
    }
    const std::string no_threads = b.why_not({}, ThreadBudget{2});
    if (!no_threads.empty()) {
      EXPECT_EQ(refusal("groups/" + id + " 1x2", kBudget), "backend " + id + " cannot run here: " + no_threads);
    }
    EXPECT_NE(refusal("groups/" + id + " 3x1", {2}).find("takes 3 threads and the budget is 2"), std::string::npos);
    // Chunks and lanes do not change the number of threads that a strategy takes.
    EXPECT_NE(refusal("groups/" + id + ":8+chunks=4 3x1", {2}).find("takes 3 threads"), std::string::npos);
  }
}

}  // namespace
}  // namespace assur
