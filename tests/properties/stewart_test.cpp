// The platform of the paper: accuracy in every formulation, and groups left out if only angles of handles are outputs.
#include <gtest/gtest.h>

#include <cmath>

#include "errors/deviation.hpp"
#include "plan/preparation.hpp"
#include "references/stewart.hpp"

namespace assur {
namespace {

using references::Posture;
using references::QuadJet;
using test::Deviation;
using test::Result;

const std::vector<std::string> kHandles = {"handle1.value", "handle2.value", "handle3.value",
                                           "handle4.value", "handle5.value", "handle6.value"};

struct ClosedForm {
  std::vector<Posture<QuadJet>> postures;  // with the members of the terminal
  std::vector<std::vector<QuadJet>> handles;

  explicit ClosedForm(const Scene& scene) {
    for (std::int64_t k = 0; k <= scene.time().steps(); ++k) {
      postures.push_back(references::stewart(scene, scene.time().time(k)));
      auto& handle = handles.emplace_back();
      for (int leg = 1; leg <= 6; ++leg) {
        handle.push_back(references::stewart_handle(scene, postures.back(), std::to_string(leg)));
      }
      references::add_members(scene, postures.back());
    }
  }

  [[nodiscard]] Motion deviation(const Trajectory& trajectory) const {
    Deviation deviation(trajectory);
    for (std::size_t k = 0; k < trajectory.rows(); ++k) {
      for (const auto& [name, at] : postures[k]) deviation.add(k, name, at);
      for (std::size_t leg = 0; leg < 6; ++leg) deviation.add(k, "handle" + std::to_string(leg + 1), handles[k][leg]);
    }
    return deviation.worst();
  }
};

TEST(Stewart, AgreesWithTheClosedFormInEveryFormulation) {
  const Scene scene = sample("stewart");
  const ClosedForm closed_form(scene);
  for (const std::string formulation : {"global", "groups", "irreducible"}) {
    for (const std::string& backend : test::solvers()) {
      SCOPED_TRACE(formulation + "/" + backend);
      const Result r = test::run(scene, formulation + "/" + backend);
      ASSERT_EQ(r.report().status.code, Code::ok);
      ASSERT_EQ(r.trajectory.rows(), 1001u);
      EXPECT_TRUE(r.report().events.empty());
      EXPECT_TRUE(r.report().fallbacks.empty());
      const ErrorFigures& error = r.report().error;
      EXPECT_LE(error.position, 1e-14);
      EXPECT_GT(error.position, 0);  // zero would mean that nothing was measured
      // Normwise backward errors of the linear systems: a pivoted elimination has about n^(1/2) roundings, at most 12
      // eps here.
      EXPECT_LE(error.velocity, 1e-14);
      EXPECT_LE(error.acceleration, 1e-14);
      const Motion off = closed_form.deviation(r.trajectory);
      EXPECT_LE(off.value, 1e-13);
      EXPECT_LE(off.rate, 1e-12);
      EXPECT_LE(off.acceleration, 1e-11);
    }
  }
}

// The first level has one group of `first` unknowns (0: no such group), the next level `groups` groups of `unknowns`
// each.
struct Work {
  std::string strategy;
  std::int64_t first, groups, unknowns;

  // Each attempt at a posture solves the first level, and groups of the next level until one rejects the attempt.
  static std::int64_t attempts(const Counters& c) { return 1 + c.steps + c.substeps + c.rejected; }
  [[nodiscard]] std::int64_t of_first(const Counters& c) const { return first > 0 ? attempts(c) : 0; }
  [[nodiscard]] std::int64_t solutions_times_unknowns(const Counters& c) const {
    return first * of_first(c) + unknowns * (c.group_solutions - of_first(c));
  }
  // Returns a, the iterations on the first level. Solves a + b = all Newton iterations and a * first + b * unknowns =
  // all equations that they evaluate.
  [[nodiscard]] std::int64_t iterations_of_first(const Counters& c) const {
    const std::int64_t in_newton = c.evaluated_equations - solutions_times_unknowns(c);
    const std::int64_t rest = c.newton_iterations * unknowns - in_newton;
    if (first == 0) return rest;
    return rest % (unknowns - first) == 0 ? rest / (unknowns - first) : -1;
  }
};

// A Newton iteration evaluates, factorizes and solves once; a final evaluation checks the residual. Derivatives need
// one more factorization and two solves.
void expect_work(const Counters& c, const Work& w, bool derivatives) {
  EXPECT_EQ(c.steps, 1000);
  EXPECT_LE(c.rejected, 5);
  const std::int64_t groups = w.groups + (w.first > 0 ? 1 : 0), attempts = Work::attempts(c);
  EXPECT_LE(c.group_solutions, groups * attempts);
  EXPECT_GE(c.group_solutions, groups * (attempts - c.rejected));
  const std::int64_t unknowns = w.solutions_times_unknowns(c);
  EXPECT_EQ(c.factorizations, c.newton_iterations + (derivatives ? c.group_solutions : 0));
  EXPECT_EQ(c.factorized_unknowns, c.evaluated_equations - (derivatives ? 0 : unknowns));
  EXPECT_EQ(c.solved_unknowns, c.factorized_unknowns + (derivatives ? unknowns : 0));
  EXPECT_GE(w.iterations_of_first(c), 0);
  EXPECT_LE(w.iterations_of_first(c), 2 * w.of_first(c));
}

TEST(Stewart, CountsTheWorkOfTheFullRun) {
  // In `irreducible` the terminal is driven. A leg has 15 unknowns: three blocks of 3, and 6 that presolve eliminates.
  const std::size_t columns = 9 * (4 + 6 * 5 + 6 * 2) + 6 * 3;  // O, u, v, w; B, e, r, c, d and P, t of legs; angles
  for (const Work& w : {Work{"groups/" + test::sparse(), 12, 6, 15}, Work{"irreducible/" + test::sparse(), 0, 18, 3},
                        Work{"global/" + test::sparse(), 0, 1, 102}}) {
    SCOPED_TRACE(w.strategy);
    const Result r = test::run(sample("stewart"), w.strategy);
    ASSERT_TRUE(r.report().status.ok());
    EXPECT_EQ(r.trajectory.columns().size(), columns);
    EXPECT_EQ(r.counters().stored_values, 1001 * static_cast<std::int64_t>(columns));
    expect_work(r.counters(), w, true);
  }
}

TEST(Stewart, HandlesNeedNoDerivativesAndNoDeeperBlocks) {
  const Scene scene = sample("stewart"), handles = scene.with_outputs(kHandles);
  for (const Work& w :
       {Work{"groups/eigen", 12, 6, 9}, Work{"groups/" + test::sparse(), 12, 6, 9}, Work{"irreducible/eigen", 0, 6, 3},
        Work{"irreducible/" + test::sparse(), 0, 6, 3}, Work{"global/" + test::sparse(), 0, 1, 66}}) {
    SCOPED_TRACE(w.strategy);
    const Result full = test::run(scene, w.strategy), r = test::run(handles, w.strategy);
    ASSERT_TRUE(r.report().status.ok());
    expect_work(r.counters(), w, false);
    EXPECT_EQ(r.counters().stored_values, 6 * 1001);
    EXPECT_LT(r.counters().stored_values, full.counters().stored_values);
    EXPECT_LT(r.counters().factorizations, full.counters().factorizations);
    EXPECT_LT(r.counters().factorized_unknowns, full.counters().factorized_unknowns);
    EXPECT_LT(r.counters().solved_unknowns, full.counters().solved_unknowns);
    EXPECT_LT(r.counters().evaluated_equations, full.counters().evaluated_equations);
    EXPECT_TRUE(std::isnan(r.report().error.velocity));  // neither computed nor measured
    EXPECT_TRUE(std::isnan(r.report().error.acceleration));
    EXPECT_LE(r.report().error.position, 1e-14);

    const GroupedSystem& structure = *preparation(r.simulator.prepared()).structure;
    EXPECT_EQ(structure.left_out.levels.size(), structure.groups.size());
    for (const LeftOut::Level& level : structure.left_out.levels) {
      EXPECT_EQ(level.derivatives, 0) << level.group;
      EXPECT_FALSE(level.for_predictor) << level.group;
    }

    // The angles equal those of the full run.
    for (std::size_t leg = 0; leg < 6; ++leg) {
      const std::size_t column = full.trajectory.index("handle" + std::to_string(leg + 1));
      for (std::size_t k = 0; k < 1001; ++k) EXPECT_NEAR(r.trajectory(k, leg), full.trajectory(k, column), 1e-13);
    }
  }
}

TEST(Stewart, ListsDerivativesThatOnlyThePredictorNeeds) {
  const Scene handles = sample("stewart").with_outputs(kHandles);
  for (const Work& w : {Work{"groups/" + test::sparse() + "+predict=taylor:2", 12, 6, 9},
                        Work{"irreducible/" + test::sparse() + "+predict=taylor:2", 0, 6, 3}}) {
    SCOPED_TRACE(w.strategy);
    const Result r = test::run(handles, w.strategy);
    ASSERT_TRUE(r.report().status.ok());
    expect_work(r.counters(), w, true);
    EXPECT_EQ(r.counters().stored_values, 6 * 1001);
    EXPECT_GT(r.report().error.acceleration, 0);
    const GroupedSystem& structure = *preparation(r.simulator.prepared()).structure;
    EXPECT_EQ(structure.left_out.levels.size(), structure.groups.size());
    for (const LeftOut::Level& level : structure.left_out.levels) {
      EXPECT_EQ(level.derivatives, 2) << level.group;
      EXPECT_TRUE(level.for_predictor) << level.group;
    }
  }
  // taylor:1 needs velocities but no accelerations.
  const Result r = test::run(handles, "groups/" + test::sparse() + "+predict=taylor:1");
  for (const LeftOut::Level& level : preparation(r.simulator.prepared()).structure->left_out.levels)
    EXPECT_EQ(level.derivatives, 1);
  EXPECT_TRUE(std::isnan(r.report().error.acceleration));
  EXPECT_GT(r.report().error.velocity, 0);
}

TEST(Stewart, TakesFixedIterationsBeyondTheFirstLevel) {
  const Work work{"groups/" + test::sparse() + "+predict=taylor:2", 12, 6, 15};
  const Result free = test::run(sample("stewart"), work.strategy);
  for (const int n : {1, 2, 3}) {
    const Result r = test::run(sample("stewart"), work.strategy, {.iterations = n});
    ASSERT_TRUE(r.report().status.ok());
    const Counters& c = r.counters();
    expect_work(c, work, true);
    const std::int64_t of_first = work.iterations_of_first(c);
    EXPECT_EQ(of_first, work.iterations_of_first(free.counters()));  // the first level takes as many as it needs
    // The start posture is already assembled, so that its six legs need no iterations.
    EXPECT_EQ(c.newton_iterations - of_first, n * (c.group_solutions - work.of_first(c) - 6));
    EXPECT_EQ(c.most_iterations, std::max<std::int64_t>(n, free.counters().most_iterations));
    // The single iteration of the paper suffices at 1 rad/s and dt = 0.01.
    EXPECT_LE(r.report().error.position, 1e-14) << n;
  }
}

}  // namespace
}  // namespace assur
