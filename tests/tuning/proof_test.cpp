// Whole steps of mechanisms that the tuner's cells do not contain.
#include "tuning/proof.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "assur/plan.hpp"
#include "dispatch/counts.hpp"
#include "tuning/refinement.hpp"

namespace assur::tuning {
namespace {

TEST(Proof, RacesTheStrategiesThatAreExpectedToBeTheFastest) {
  const Field field{backends(), ThreadBudget{1}};
  for (const char* scene : {"jansen", "scissor:20", "four_bar:30", "delta"}) {
    const ProofCells proof = proof_cells(scene, PerformanceModel(), field, 4);
    std::set<std::string> strategies;
    for (const Cell& cell : proof.cells) {
      const auto ground = open(cell, field);
      ASSERT_EQ(ground->candidates().size(), cell.only.size());
      for (const Candidate& c : ground->candidates()) {
        EXPECT_EQ(c.strategy.run.formulation, cell.formulation);
        EXPECT_EQ(c.kernel, Kernel::step);
        strategies.insert(to_string(c.strategy));
      }
    }
    EXPECT_EQ(strategies.size(), 4u) << scene;
    EXPECT_EQ(strategies.count(to_string(proof.first)), 1u) << scene;
    const PrepareOptions how{.strategy = to_string(proof.first),
                             .budget = ThreadBudget{1},
                             .model = std::make_shared<const PerformanceModel>()};
    EXPECT_NEAR(prepare(sample(scene), how).plan().expected_seconds / proof.expected_seconds, 1, 1e-12) << scene;
  }
}

// On a clock of its own, on which every block takes the same time.
TEST(Proof, IsStoredAsTimesOfWholeSteps) {
  double now = 0;
  measure::Instruments instruments;
  instruments.clock = [&] { return now += 2e-3; };
  instruments.switches = [](int) { return std::int64_t{0}; };
  CampaignOptions options;
  options.field = {backends(), ThreadBudget{1}};
  options.seconds = 20'000;
  std::vector<Sample> stored;
  options.store = [&](const CellResult& cell) {
    for (const Result& r : cell.results) stored.push_back(r.sample);
  };
  Campaign campaign(options, instruments);
  const std::vector<Proof> proofs = prove(campaign, options.field);
  EXPECT_EQ(proofs.size(), 12u);
  for (const Proof& p : proofs) {
    EXPECT_GE(p.regret(), 0) << p.scene;
    EXPECT_TRUE(std::isfinite(p.seconds) && p.expected_seconds > 0) << p.scene;
  }
  for (const Sample& s : stored) EXPECT_EQ(s.kernel, Kernel::step);
  const PerformanceModel model(stored);
  for (const Proof& p : proofs) {
    const Strategy chosen = parse_strategy(p.chosen);
    const GroupedSystem structure = group_equations(sample(p.scene), {.formulation = chosen.run.formulation});
    const auto steps = model.steps(shape_of_step(structure, class_shapes(structure)));
    EXPECT_TRUE(std::any_of(steps.begin(), steps.end(), [&](const auto& s) { return s.strategy == chosen; }))
        << p.scene;
  }
}

}  // namespace
}  // namespace assur::tuning
