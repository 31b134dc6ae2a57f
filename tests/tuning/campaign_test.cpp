// Budget, restart and interruption, on a clock that advances with each reading.
#include "tuning/campaign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "dispatch/pace.hpp"
#include "tuning/refinement.hpp"

namespace assur::tuning {
namespace {

constexpr double kTick = 2e-3;  // s; a block of one call is long enough

class CampaignTest : public testing::Test {
 protected:
  CampaignTest() {
    options_.field = {backends(), ThreadBudget{1}};
    options_.seconds = 20'000;
    options_.store = [this](const CellResult& cell) { stored_.push_back(cell); };
  }
  measure::Instruments instruments() {
    measure::Instruments out;
    out.clock = [this] { return now_ += kTick * slow_; };
    out.slowness = [this] { return slow_; };
    out.switches = [](int) { return std::int64_t{0}; };
    out.stop = [this] { return stored_.size() >= stop_after_; };
    return out;
  }
  static std::vector<Cell> cells() {
    std::vector<Cell> out;
    for (const std::int32_t n : {3, 5, 8, 12}) {
      Cell c;
      c.family = "full";
      c.n = c.per_row = n;
      out.push_back(c);
    }
    return out;
  }

  double now_ = 0, slow_ = 1;
  std::size_t stop_after_ = std::numeric_limits<std::size_t>::max();
  CampaignOptions options_;
  std::vector<CellResult> stored_;
};

TEST_F(CampaignTest, StoresEachCellOnceWithFactorAndSolveOfEveryCandidate) {
  Campaign campaign(options_, instruments());
  campaign.run(cells());
  ASSERT_EQ(stored_.size(), 4u);
  for (const CellResult& cell : stored_) {
    EXPECT_FALSE(cell.cut_short);
    std::set<std::string> factor, solve;
    for (const Result& r : cell.results) {
      EXPECT_EQ(r.sample.shape.n, cell.cell.n);
      EXPECT_GT(r.sample.seconds, 0);
      EXPECT_GT(r.sample.repetitions, 0);
      EXPECT_LE(r.sample.backward_error, 1e-13);
      (r.sample.kernel == Kernel::factor ? factor : solve).insert(to_string(r.sample.strategy));
    }
    EXPECT_EQ(factor, solve);
    EXPECT_EQ(factor.size() + cell.refused.size(), linear_solvers(options_.field, {.n = cell.cell.n}, 16).size());
  }
  EXPECT_EQ(campaign.figures().measured, 4u);
  EXPECT_FALSE(campaign.figures().interrupted);
}

TEST_F(CampaignTest, KeepsToItsBudget) {
  options_.seconds = 1;  // 500 readings of the clock, too few for all cells
  Campaign campaign(options_, instruments());
  campaign.run(cells());
  // The excess is the current block, and a few readings of the clock for each of about sixty candidates.
  EXPECT_LE(now_, 1 + 200 * kTick);
  EXPECT_EQ(campaign.figures().planned, 4u);
}

TEST_F(CampaignTest, ContinuesAnInterruptedRun) {
  stop_after_ = 2;
  Campaign first(options_, instruments());
  first.run(cells());
  EXPECT_TRUE(first.figures().interrupted);
  ASSERT_EQ(stored_.size(), 2u);

  for (const CellResult& cell : stored_) {
    for (const Result& r : cell.results) options_.earlier.push_back(r.sample);
  }
  stored_.clear();
  stop_after_ = std::numeric_limits<std::size_t>::max();
  Campaign second(options_, instruments());
  second.run(cells());
  ASSERT_EQ(stored_.size(), 2u);
  EXPECT_EQ(stored_[0].cell.n, 8);
  EXPECT_EQ(stored_[1].cell.n, 12);
  EXPECT_EQ(second.figures().measured, 4u);
  EXPECT_EQ(second.figures().earlier, 2u);
  ASSERT_EQ(second.results().size(), 4u);
  EXPECT_EQ(second.results()[0].results.size(), first.results()[0].results.size());
}

TEST_F(CampaignTest, CorrectsTimesToTheUsualPace) {
  options_.progress = [this](double, const Cell& cell) { slow_ = cell.n > 5 ? 2 : 1; };
  Campaign campaign(options_, instruments());
  campaign.run(cells());
  ASSERT_EQ(stored_.size(), 4u);
  for (const CellResult& cell : stored_) {
    // Each block takes one reading of the clock.
    for (const Result& r : cell.results) {
      EXPECT_LE(r.sample.seconds, kTick * (1 + 1e-9)) << to_string(r.sample.strategy);
      EXPECT_NEAR(r.sample.slowness, cell.cell.n > 5 ? 2 : 1, 1e-9) << to_string(r.sample.strategy);
    }
  }
  EXPECT_EQ(campaign.figures().drift(), 1.0);
}

// Several threads wait for the slowest core, whose pace is not that of this one.
TEST_F(CampaignTest, DoesNotCorrectTimesOfSeveralThreads) {
  options_.field.budget = ThreadBudget{2};
  slow_ = 2;
  Cell meeting;
  meeting.kind = Cell::Kind::meeting;
  Campaign campaign(options_, instruments());
  campaign.run({meeting});
  ASSERT_EQ(stored_.size(), 1u);
  ASSERT_EQ(stored_[0].results.size(), 1u);
  // A block of one call takes one reading of the clock, which is two ticks because the machine is slow.
  const Result& r = stored_[0].results[0];
  const double raw = 2 * kTick * r.rounds / static_cast<double>(r.sample.repetitions);
  EXPECT_NEAR(r.sample.seconds, raw, 1e-9);
  EXPECT_EQ(r.sample.slowness, 1);
  EXPECT_EQ(slowed(r.sample, 2).seconds, r.sample.seconds);
}

TEST(Around, IsTheTimeOfAStepWithoutItsPacks) {
  const Shape shape{.n = 102, .terms = 700};
  std::vector<Entrant> entrants;
  CellResult cell;
  const auto enter = [&](Kernel kernel, int n, const std::string& strategy, double seconds, int packs) {
    Entrant e{kernel, {.n = n}, parse_strategy(strategy)};
    e.packs_of_step = packs;
    entrants.push_back(e);
    if (seconds == 0) return;  // this entrant was not timed
    Sample s;
    s.kernel = kernel;
    s.shape = e.shape;
    s.strategy = e.strategy;
    s.seconds = seconds;
    s.spread = kernel == Kernel::step ? 30e-9 : 20e-9;
    s.slowness = 1.25;
    cell.results.emplace_back(std::move(s));
  };
  const auto step_of = [&](const std::string& strategy, double seconds, double large_pack) {
    enter(Kernel::step, 15, strategy, seconds, 0);
    enter(Kernel::pack, 15, strategy, 0.5e-6, 2);
    enter(Kernel::pack, 12, strategy, large_pack, 1);
  };
  step_of("groups/lanes", 5e-6, 2e-6);
  step_of("groups/lanes:8", 5e-6, 0);              // one pack was not timed
  step_of("groups/eigen", 3.02e-6, 2e-6);          // only noise remains for the time around packs
  enter(Kernel::step, 15, "groups/klu", 5e-6, 0);  // its packs were not timed
  const std::size_t timed = cell.results.size();
  add_around(cell, entrants, shape);
  ASSERT_EQ(cell.results.size(), timed + 1);
  const Sample& around = cell.results.back().sample;
  EXPECT_EQ(around.kernel, Kernel::around);
  EXPECT_EQ(around.shape, shape);
  EXPECT_EQ(to_string(around.strategy), "groups/lanes");
  EXPECT_NEAR(around.seconds, 2e-6, 1e-12);
  EXPECT_NEAR(around.spread, std::hypot(30e-9, 40e-9, 20e-9), 1e-15);
  EXPECT_EQ(around.slowness, 1.25);
}

TEST(Around, TimesEveryClassOfAStep) {
  Cell cell;
  cell.kind = Cell::Kind::around;
  cell.scene = [] { return sample("stewart"); };
  const Field field{backends(), ThreadBudget{1}};
  const auto ground = open(cell, field);
  ASSERT_TRUE(ground->around());
  EXPECT_EQ(ground->around()->n, 6 * 15 + 12);
  EXPECT_GT(ground->around()->terms, 0);
  for (const Candidate& c : ground->candidates())
    EXPECT_TRUE(c.strategy.solver.backend == "lanes" && c.strategy.solver.lanes >= 2);
  const auto entrants = ground->enter({Kernel::step, parse_strategy("groups/lanes:8")});
  std::map<std::int32_t, int> packs;
  for (const Entrant& e : entrants) {
    if (e.kernel == Kernel::pack) packs[e.shape.n] = e.packs_of_step;
  }
  EXPECT_EQ(packs, (std::map<std::int32_t, int>{{12, 1}, {15, 1}}));
  cell.kind = Cell::Kind::steps;
  EXPECT_EQ(open(cell, field)->enter({Kernel::step, parse_strategy("groups/lanes:8")}).size(), 1u);
}

// A level with few groups takes fewer lanes than the strategy says.
TEST(Around, StoresPacksUnderTheLanesThatTheyTake) {
  Cell cell;
  cell.kind = Cell::Kind::around;
  const Field field{backends(), ThreadBudget{1}};
  cell.scene = [] { return sample("four_bar:6"); };
  for (const Candidate& c : open(cell, field)->candidates()) EXPECT_EQ(c.strategy.solver.lanes, 1);
  cell.scene = [] { return sample("stewart"); };
  const auto ground = open(cell, field);
  for (const Entrant& e : ground->enter({Kernel::step, parse_strategy("groups/lanes:8")})) {
    if (e.kernel == Kernel::pack) {
      EXPECT_EQ(e.strategy.solver.lanes, e.shape.groups == 1 ? 1 : 8);
    }
  }
}

// A call of +together solves all packs; the sample is the share of one.
TEST_F(CampaignTest, StoresTheShareOfAPackOfAllLevels) {
  Cell cell;
  cell.kind = Cell::Kind::together;
  cell.family = "dyads in series";
  cell.scene = [] { return sample("four_bar:20"); };
  cell.formulation = Formulation::irreducible;
  Campaign campaign(options_, instruments());
  campaign.run({cell});
  ASSERT_EQ(stored_.size(), 1u);
  std::set<std::string> strategies;
  for (const Result& r : stored_[0].results) {
    strategies.insert(to_string(r.sample.strategy));
    EXPECT_EQ(r.sample.kernel, Kernel::pack);
    EXPECT_EQ(r.sample.shape.groups, 20);
    // A block takes one reading of the clock.
    const double packs = std::ceil(20.0 / r.sample.strategy.solver.lanes);
    EXPECT_NEAR(r.sample.seconds * packs * static_cast<double>(r.sample.repetitions), kTick * r.rounds, 1e-9);
  }
  EXPECT_EQ(strategies, (std::set<std::string>{"irreducible/lanes:16+together", "irreducible/lanes:4+together",
                                               "irreducible/lanes:8+together"}));
}

TEST_F(CampaignTest, MeasuresEqualMatricesOnce) {
  std::vector<Cell> twice = cells();
  twice.push_back(twice.front());
  Campaign campaign(options_, instruments());
  campaign.run(twice);
  EXPECT_EQ(stored_.size(), 4u);
  EXPECT_EQ(campaign.figures().planned, 4u);
}

TEST_F(CampaignTest, ReportsAFailedCellAndContinues) {
  std::vector<Cell> some = cells();
  some[1].scene = [] { return sample("no such thing"); };
  Campaign campaign(options_, instruments());
  campaign.run(some);
  EXPECT_EQ(stored_.size(), 3u);
  ASSERT_EQ(campaign.figures().failures.size(), 1u);
  EXPECT_NE(campaign.figures().failures[0].find("full, n = 5: "), std::string::npos);
}

TEST_F(CampaignTest, AnUnwritableDatabaseEndsTheRun) {
  options_.store = [](const CellResult&) { throw Error(Error::Kind::environment, "the disk is full"); };
  Campaign campaign(options_, instruments());
  EXPECT_THROW(campaign.run(cells()), Error);
}

class RefinementTest : public CampaignTest {
 protected:
  static Cell full(std::int32_t n) {
    Cell c;
    c.family = "full";
    c.n = c.per_row = n;
    c.at = full;
    return c;
  }
  static std::vector<Cell> three_sizes() {
    std::vector<Cell> cells = {full(3), full(9), full(27), full(5)};
    cells.back().held_out = true;
    return cells;
  }
};

TEST_F(RefinementTest, MeasuresBetweenTheSizesUntilTheyAreClose) {
  options_.most_for_cell = 10;
  Campaign campaign(options_, instruments());
  campaign.run(three_sizes());
  refine(campaign, false);
  std::set<std::int32_t> sizes;
  for (const CellResult& c : campaign.results()) sizes.insert(c.cell.n);
  EXPECT_EQ(sizes.size(), campaign.results().size());
  EXPECT_GT(sizes.size(), 8u);
  EXPECT_GT(campaign.seconds_left(), 0);  // stopped because nothing was left to do
  for (auto n = sizes.begin(); std::next(n) != sizes.end(); ++n) {
    const double a = *n, b = *std::next(n), middle = std::round(std::sqrt(a * b));
    EXPECT_TRUE(middle < 1.12 * a || b < 1.12 * middle) << a << ' ' << b;
  }
}

TEST_F(RefinementTest, EndsWithTheBudget) {
  options_.seconds = 40;
  options_.most_for_cell = 2;
  Campaign campaign(options_, instruments());
  campaign.run(three_sizes());
  refine(campaign, false);
  EXPECT_LE(now_, 40 + 2);
}

TEST_F(RefinementTest, PatientRunsEndWhenTheRegretSettles) {
  options_.most_for_cell = 10;
  Campaign all(options_, instruments());
  all.run(three_sizes());
  refine(all, false);
  stored_.clear();
  Campaign patient(options_, instruments());
  patient.run(three_sizes());
  refine(patient, true);
  EXPECT_LE(patient.results().size(), all.results().size());
  // The regret does not fall in three passes after the first.
  EXPECT_GE(patient.figures().passes, 4);
  EXPECT_EQ(patient.results()[0].results[0].passes.size(), static_cast<std::size_t>(patient.figures().passes));
  EXPECT_GT(stored_.size(), patient.results().size());
}

TEST_F(CampaignTest, UsesTheMedianOfSeveralPasses) {
  Campaign campaign(options_, instruments());
  campaign.run(cells());
  const std::size_t cells = campaign.results().size();
  const std::int64_t samples = campaign.figures().samples;
  for (int pass = 0; pass < 2; ++pass) campaign.again();
  EXPECT_EQ(campaign.results().size(), cells);
  EXPECT_EQ(campaign.figures().measured, cells);
  EXPECT_EQ(campaign.figures().samples, 3 * samples);
  EXPECT_EQ(stored_.size(), 3 * cells);
  for (const CellResult& cell : campaign.results()) {
    for (const Result& r : cell.results) {
      ASSERT_EQ(r.passes.size(), 3u);
      EXPECT_LE(r.passes[0].seconds, r.passes[1].seconds);
      EXPECT_LE(r.passes[1].seconds, r.passes[2].seconds);
      EXPECT_EQ(r.sample.seconds, r.passes[1].seconds);
    }
  }
}

TEST(History, FindsHopelessCandidatesFromTwoSmallerSizes) {
  const Candidate candidate{Kernel::factor, parse_strategy("groups/eigen")};
  History history;
  EXPECT_EQ(history.hopeless("rings", candidate, 100, 1, 1), "");
  history.note("rings", candidate, {10, 25e-6, 1e-6, 0});
  EXPECT_EQ(history.hopeless("rings", candidate, 100, 1, 1), "");
  history.note("rings", candidate, {20, 70e-6, 2e-6, 0});
  EXPECT_EQ(history.hopeless("rings", candidate, 40, 1, 1), "far behind at smaller sizes");
  EXPECT_EQ(history.hopeless("rings", candidate, 15, 1, 1), "");  // only one smaller size is known
  EXPECT_EQ(history.hopeless("full", candidate, 40, 1, 1), "");   // another family
  history.note("full", candidate, {10, 25e-6, 1e-6, 0});
  history.note("full", candidate, {20, 48e-6, 2e-6, 0});
  EXPECT_EQ(history.hopeless("full", candidate, 40, 1, 1), "");  // the candidate catches up
}

TEST(History, FindsCandidatesThatTakeTooLong) {
  const Candidate candidate{Kernel::factor, parse_strategy("groups/lanes")};
  History history;
  history.note("full", candidate, {50, 1e-3, 1e-3, 0.001});
  history.note("full", candidate, {100, 8e-3, 8e-3, 0.01});
  EXPECT_EQ(history.hopeless("full", candidate, 200, 1, 0.2), "");  // a call takes 64 ms, its analysis 80 ms
  EXPECT_EQ(history.hopeless("full", candidate, 200, 1, 0.07), "its analysis takes too long");
  EXPECT_EQ(history.hopeless("full", candidate, 200, 1, 0.05), "one call takes too long");
  EXPECT_EQ(history.hopeless("full", candidate, 100, 19, 0.2), "");
  EXPECT_EQ(history.hopeless("full", candidate, 100, 21, 0.2), "its analysis takes too long");  // of all groups
}

TEST(History, KnowsSetupsOfCandidatesThatWereNotTimed) {
  const Candidate candidate{Kernel::pack, parse_strategy("groups/team+once")};
  History history;
  history.note("rings", candidate, {240, 1e-3, 1e-3, 0.01});
  history.note("rings", candidate, {720, std::numeric_limits<double>::infinity(), 1e-2, 0.27});
  EXPECT_EQ(history.hopeless("rings", candidate, 2000, 1, 6), "");
  EXPECT_EQ(history.hopeless("rings", candidate, 2000, 8, 6), "its analysis takes too long");
}

TEST(History, ExpectsVariantsToBeAnalysedLikeTheirBackend) {
  const Candidate plain{Kernel::pack, parse_strategy("groups/team")};
  const Candidate variant{Kernel::pack, parse_strategy("groups/team:4+once")};
  History history;
  history.note("rings", plain, {240, 1e-3, 1e-3, 0.01});
  history.note("rings", plain, {720, 27e-3, 27e-3, 0.27});
  EXPECT_EQ(history.hopeless("rings", variant, 2000, 1, 6), "");
  EXPECT_EQ(history.hopeless("rings", variant, 2000, 8, 6), "its analysis takes too long");
  EXPECT_EQ(history.hopeless("rings", variant, 2000, 1, 0.6), "its analysis takes too long");
}

}  // namespace
}  // namespace assur::tuning
