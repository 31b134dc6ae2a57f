// The paper's platform: accuracy in every formulation, and what is left out where only the handles' angles are wanted.
#include <gtest/gtest.h>

#include <iostream>

#include "references/stewart.hpp"
#include "simulation/deviation.hpp"

namespace assur {
namespace {

using references::Posture;
using references::QuadJet;
using test::Deviation;
using test::Run;

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

TEST(Stewart, MeetsTheClosedFormInEveryFormulation) {
  const Scene scene = sample("stewart");
  const ClosedForm closed_form(scene);
  for (const std::string formulation : {"global", "groups", "irreducible"}) {
    for (const std::string backend : {"eigen", "klu"}) {
      SCOPED_TRACE(formulation + "/" + backend);
      const Run r = test::run(scene, formulation + "/" + backend);
      ASSERT_EQ(r.report().status.code, Code::ok);
      ASSERT_EQ(r.trajectory.rows(), 1001u);
      EXPECT_TRUE(r.report().events.empty());
      EXPECT_TRUE(r.report().fallbacks.empty());
      const ErrorFigures& error = r.report().error;
      EXPECT_LE(error.position, 1e-14);
      EXPECT_GT(error.position, 0);  // it was measured
      // Normwise backward errors of the linear systems: n^(1/2) roundings of a pivoted elimination are 12 eps at most.
      EXPECT_LE(error.velocity, 1e-14);
      EXPECT_LE(error.acceleration, 1e-14);
      const Motion off = closed_form.deviation(r.trajectory);
      EXPECT_LE(off.value, 1e-13);
      EXPECT_LE(off.rate, 1e-12);
      EXPECT_LE(off.acceleration, 1e-11);
      std::cout << formulation << "/" << backend << ": " << test::text(off) << "; residuals " << error.position << " "
                << error.velocity << " " << error.acceleration << "; iterations " << r.counters().newton_iterations
                << " of " << r.counters().group_solutions << ", most " << r.counters().most_iterations << "\n";
    }
  }
}

// What is solved at every posture of a formulation: groups, and their unknowns in all and in the deeper level alone.
struct Work {
  std::string strategy;
  std::int64_t first, groups, unknowns;  // unknowns of the first level; groups and unknowns of each of the second
};

// Per Newton iteration a group evaluates, factorizes and solves once; evaluates once more; and with derivatives it
// factorizes once more and solves twice more.
void expect_work(const Counters& c, const Work& w, std::int64_t postures, bool derivatives) {
  EXPECT_EQ(c.steps, 1000);
  EXPECT_EQ(c.substeps, postures);
  EXPECT_EQ(c.rejected, 0);
  const std::int64_t groups = w.groups + (w.first > 0 ? 1 : 0), unknowns = w.first + w.groups * w.unknowns;
  EXPECT_EQ(c.group_solutions, groups * postures);
  EXPECT_EQ(c.factorizations, c.newton_iterations + (derivatives ? groups * postures : 0));
  EXPECT_EQ(c.factorized_unknowns, c.evaluated_equations - (derivatives ? 0 : unknowns * postures));
  EXPECT_EQ(c.solved_unknowns, c.factorized_unknowns + (derivatives ? unknowns * postures : 0));
  // Each level: iterations x unknowns.
  const std::int64_t in_newton = c.evaluated_equations - unknowns * postures;
  const std::int64_t deeper = c.newton_iterations * w.unknowns - in_newton;  // = first level's x (unknowns - first)
  if (w.first > 0) {
    ASSERT_EQ(deeper % (w.unknowns - w.first), 0);
    const std::int64_t iterations = deeper / (w.unknowns - w.first);
    EXPECT_GE(iterations, 0);
    EXPECT_LE(iterations, c.newton_iterations);
  } else {
    EXPECT_EQ(deeper, 0);
  }
}

TEST(Stewart, WorkOfTheFullRunIsCounted) {
  const std::size_t columns = 9 * (4 + 6 * 5 + 6 * 2) + 6 * 3;  // O, u, v, w; B, e, r, c, d; P, t; handles
  for (const Work& w : {Work{"groups/klu", 12, 6, 15}, Work{"irreducible/klu", 0, 6, 9}, Work{"global/klu", 0, 1, 102}}) {
    SCOPED_TRACE(w.strategy);
    const Run r = test::run(sample("stewart"), w.strategy);
    ASSERT_TRUE(r.report().status.ok());
    EXPECT_EQ(r.trajectory.columns().size(), columns);
    EXPECT_EQ(r.counters().stored_values, 1001 * static_cast<std::int64_t>(columns));
    if (w.strategy != "irreducible/klu") {
      expect_work(r.counters(), w, 1001, true);
    } else {
      EXPECT_EQ(r.counters().group_solutions, 18 * 1001);  // 3 + 3 + 3 for each leg; the terminal is driven
      EXPECT_EQ(r.counters().evaluated_equations, 3 * (r.counters().newton_iterations + r.counters().group_solutions));
    }
  }
}

TEST(Stewart, HandlesAloneNeedNoDerivativesAndNoDeeperBlocks) {
  const Scene scene = sample("stewart"), handles = scene.with_outputs(kHandles);
  for (const Work& w : {Work{"groups/eigen", 12, 6, 9}, Work{"groups/klu", 12, 6, 9}, Work{"irreducible/eigen", 0, 6, 3},
                        Work{"irreducible/klu", 0, 6, 3}, Work{"global/klu", 0, 1, 66}}) {
    SCOPED_TRACE(w.strategy);
    const Run full = test::run(scene, w.strategy), r = test::run(handles, w.strategy);
    ASSERT_TRUE(r.report().status.ok());
    expect_work(r.counters(), w, 1001, false);
    EXPECT_EQ(r.counters().stored_values, 6 * 1001);
    EXPECT_LT(r.counters().stored_values, full.counters().stored_values);
    EXPECT_LT(r.counters().factorizations, full.counters().factorizations);
    EXPECT_LT(r.counters().factorized_unknowns, full.counters().factorized_unknowns);
    EXPECT_LT(r.counters().solved_unknowns, full.counters().solved_unknowns);
    EXPECT_LT(r.counters().evaluated_equations, full.counters().evaluated_equations);
    EXPECT_EQ(r.report().error.velocity, 0);
    EXPECT_EQ(r.report().error.acceleration, 0);
    EXPECT_LE(r.report().error.position, 1e-14);

    const Structure& structure = *r.simulator.prepared().structure;
    EXPECT_EQ(structure.left_out.levels.size(), structure.groups.size());
    for (const LeftOut::Level& level : structure.left_out.levels) {
      EXPECT_EQ(level.derivatives, 0) << level.group;
      EXPECT_FALSE(level.for_predictor) << level.group;
    }
    std::cout << w.strategy << ": factorizations " << r.counters().factorizations << " of "
              << full.counters().factorizations << ", solved " << r.counters().solved_unknowns << " of "
              << full.counters().solved_unknowns << ", evaluated " << r.counters().evaluated_equations << " of "
              << full.counters().evaluated_equations << "\n";

    // The same angles.
    for (std::size_t leg = 0; leg < 6; ++leg) {
      const std::size_t column = full.trajectory.index("handle" + std::to_string(leg + 1));
      for (std::size_t k = 0; k < 1001; ++k) EXPECT_NEAR(r.trajectory(k, leg), full.trajectory(k, column), 1e-13);
    }
  }
}

TEST(Stewart, DerivativesForThePredictorAloneAreListed) {
  const Scene handles = sample("stewart").with_outputs(kHandles);
  for (const Work& w : {Work{"groups/klu+predict=taylor:2", 12, 6, 9}, Work{"irreducible/klu+predict=taylor:2", 0, 6, 3}}) {
    SCOPED_TRACE(w.strategy);
    const Run r = test::run(handles, w.strategy);
    ASSERT_TRUE(r.report().status.ok());
    expect_work(r.counters(), w, 1001, true);
    EXPECT_EQ(r.counters().stored_values, 6 * 1001);
    EXPECT_GT(r.report().error.acceleration, 0);
    const Structure& structure = *r.simulator.prepared().structure;
    EXPECT_EQ(structure.left_out.levels.size(), structure.groups.size());
    for (const LeftOut::Level& level : structure.left_out.levels) {
      EXPECT_EQ(level.derivatives, 2) << level.group;
      EXPECT_TRUE(level.for_predictor) << level.group;
    }
  }
  // taylor:1 needs velocities, no accelerations.
  const Run r = test::run(handles, "groups/klu+predict=taylor:1");
  for (const LeftOut::Level& level : r.simulator.prepared().structure->left_out.levels) EXPECT_EQ(level.derivatives, 1);
  EXPECT_EQ(r.report().error.acceleration, 0);
  EXPECT_GT(r.report().error.velocity, 0);
}

TEST(Stewart, FixedIterationsAreTaken) {
  for (const int n : {1, 2, 3}) {
    const Run r = test::run(sample("stewart"), "groups/klu+predict=taylor:2", {.iterations = n});
    ASSERT_TRUE(r.report().status.ok());
    const Run free = test::run(sample("stewart"), "groups/klu+predict=taylor:2");
    // The legs' iterations: 15 unknowns each, those of the terminal (12 unknowns) are as many as it takes.
    const std::int64_t all = r.counters().newton_iterations;
    const std::int64_t unknowns = r.counters().evaluated_equations - (12 + 6 * 15) * 1001;
    const std::int64_t of_terminal = (15 * all - unknowns) / 3, of_legs = all - of_terminal;
    EXPECT_EQ((15 * all - unknowns) % 3, 0);
    EXPECT_EQ(of_legs, 6 * 1000 * n);  // the start posture is assembled, and needs none
    const std::int64_t free_all = free.counters().newton_iterations;
    EXPECT_EQ(of_terminal, (15 * free_all - (free.counters().evaluated_equations - (12 + 6 * 15) * 1001)) / 3);
    // The paper's single iteration is enough at 1 rad/s and dt = 0.01: prediction 1e-7, squared by Newton.
    EXPECT_LE(r.report().error.position, 1e-14) << n;
  }
}

}  // namespace
}  // namespace assur
