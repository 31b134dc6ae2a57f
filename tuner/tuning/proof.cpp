#include "tuning/proof.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "assur/plan.hpp"
#include "dispatch/counts.hpp"
#include "dispatch/dispatcher.hpp"
#include "dispatch/strategies.hpp"
#include "dispatch/together_rules.hpp"
#include "numbers.hpp"
#include "tuning/refinement.hpp"

namespace assur::tuning {
namespace {

constexpr std::size_t kStrategies = 4;  // of a mechanism
constexpr std::array kScenes = {"slider_crank", "bricard_joints",  "delta",       "double_wishbone",
                                "excavator",    "geared_five_bar", "jansen",      "scissor:20",
                                "hexa",         "three_rps",       "four_bar:30", "stewart:platforms=9"};

struct Expected {
  Strategy strategy;
  double seconds;
};

// What the model expects of every strategy of one formulation that makes sense. Strategies that run alike come once.
std::vector<Expected> expected_of(const GroupedSystem& s, const PerformanceModel& model, const Field& field) {
  const std::vector<Shape> shapes = class_shapes(s);
  StrategySpace space;
  space.formulations = {s.formulation};
  space.lanes = powers_of_two(kMostLanes);
  space.together = s.levels > 1 && why_not_together(s).empty();
  std::vector<Expected> all;
  std::set<std::vector<std::int32_t>> seen;  // backend, together, lanes of the classes
  const Scales scales{model, field.table, {}};
  for (const Strategy& strategy : strategies(space, {.table = field.table})) {
    if (!field.why_not(strategy).empty()) continue;
    if (!std::all_of(shapes.begin(), shapes.end(), [&](const Shape& c) { return can_run(strategy, c, scales); }))
      continue;
    Plan plan = uniform_plan(strategy, s, shapes);
    std::vector<std::int32_t> essence = {
        static_cast<std::int32_t>(&find_backend(field.table, strategy.solver.backend) - field.table.data()),
        strategy.run.together ? 1 : 0};
    for (const Plan::Choice& c : plan.choices) essence.push_back(c.solver.lanes);
    if (!seen.insert(std::move(essence)).second) continue;
    expect(plan, s, Mode::latency, model);
    all.push_back({strategy, plan.expected_seconds});
  }
  return all;
}

// The time of a strategy in the cells of a scene; infinite if it has none.
double seconds_of(const Strategy& strategy, std::span<const CellResult> results, const std::string& family) {
  for (const CellResult& cell : results) {
    if (cell.cell.family != family) continue;
    for (const Result& r : cell.results) {
      if (r.sample.strategy == strategy) return r.sample.seconds;
    }
  }
  return kInfinity;
}

}  // namespace

ProofCells proof_cells(const std::string& text, const PerformanceModel& model, const Field& field, std::size_t most) {
  const Scene scene = sample(text);
  std::vector<Expected> all;
  for (const Formulation f : formulations_of(group_equations(scene, {.formulation = Formulation::irreducible}))) {
    const std::vector<Expected> some = expected_of(group_equations(scene, {.formulation = f}), model, field);
    all.insert(all.end(), some.begin(), some.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const Expected& a, const Expected& b) { return a.seconds < b.seconds; });
  if (all.size() > most) all.resize(most);
  ProofCells out;
  if (all.empty()) return out;
  out.first = all[0].strategy;
  out.expected_seconds = all[0].seconds;
  for (const Expected& e : all) {
    const Formulation f = e.strategy.run.formulation;
    auto cell = std::find_if(out.cells.begin(), out.cells.end(), [&](const Cell& c) { return c.formulation == f; });
    if (cell == out.cells.end()) {
      cell = out.cells.insert(out.cells.end(), Cell{});
      cell->kind = Cell::Kind::steps;
      cell->family = text;
      cell->formulation = f;
      cell->scene = [scene] { return scene; };
    }
    cell->only.push_back(e.strategy);
  }
  return out;
}

std::vector<Proof> prove(Campaign& campaign, const Field& field) {
  const PerformanceModel model = model_of(campaign.results());
  std::vector<ProofCells> asked;
  std::vector<Cell> cells;
  for (const char* scene : kScenes) {
    asked.push_back(proof_cells(scene, model, field, kStrategies));
    cells.insert(cells.end(), asked.back().cells.begin(), asked.back().cells.end());
  }
  campaign.run(cells);
  std::vector<Proof> all;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const ProofCells& of = asked[i];
    Proof proof{.scene = kScenes[i], .chosen = to_string(of.first), .fastest = {}};
    proof.seconds = seconds_of(of.first, campaign.results(), proof.scene);
    proof.expected_seconds = of.expected_seconds;
    proof.fastest_seconds = kInfinity;
    for (const Cell& cell : of.cells) {
      for (const Strategy& s : cell.only) {
        const double seconds = seconds_of(s, campaign.results(), proof.scene);
        if (seconds >= proof.fastest_seconds) continue;
        proof.fastest_seconds = seconds;
        proof.fastest = to_string(s);
      }
    }
    if (std::isfinite(proof.seconds)) all.push_back(std::move(proof));
  }
  return all;
}

}  // namespace assur::tuning
