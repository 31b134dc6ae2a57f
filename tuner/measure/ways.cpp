#include "measure/ways.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "assur/backend.hpp"
#include "backends/backends.hpp"
#include "dispatch/strategies.hpp"
#include "dispatch/together_rules.hpp"

namespace assur::measure {
namespace {

constexpr std::array kFixed = {1, 2, 3};  // the paper's tEnd2
constexpr std::int32_t kLanes = 8;        // one width represents all; the dispatcher considers the others
constexpr std::int32_t kMostDense = 600;  // unknowns

}  // namespace

std::string_view name(Knob knob) noexcept {
  static constexpr std::array<std::string_view, 5> kNames = {"solver", "predictor", "iterations", "precision",
                                                             "policy"};
  return kNames[static_cast<std::size_t>(knob)];
}

std::string to_string(const Way& way) {
  return to_string(way.strategy) + (way.iterations > 0 ? " --iterations " + std::to_string(way.iterations) : "");
}

std::vector<Way> solvers(const Scene& scene, ThreadBudget budget) {
  const GroupedSystem structure = group_equations(scene, {.formulation = Formulation::irreducible});
  StrategySpace space;
  space.formulations = formulations_of(structure);
  space.lanes = {1, kLanes};
  space.together = why_not_together(structure).empty();
  if (budget.threads > 1) space.packs = space.threads = {1, budget.threads};
  const auto wanted = [](const Backend& backend, const Strategy& s) {
    const bool irreducible = s.run.formulation == Formulation::irreducible;
    const int turned = (s.solver.lanes > 1) + (s.run.threads > 1) + (s.solver.threads > 1);
    return turned <= 1 && (s.solver.lanes == 1 || backend.steady) && (s.solver.threads == 1 || irreducible);
  };
  std::vector<Way> all;
  for (Strategy& s : strategies(space, {.table = backends(), .wanted = wanted})) all.push_back({std::move(s)});
  return all;
}

std::vector<Way> variations(const Strategy& solver) {
  std::vector<Way> all = fixed_iterations(solver);
  Strategy s = solver;
  for (const Predictor& predictor : kTypicalPredictors) {
    s.run.predictor = predictor;
    all.push_back({s, 0, Knob::predictor});
    for (const int iterations : kFixed) all.push_back({s, iterations, Knob::iterations});
  }
  const auto with = [&](Knob knob, auto turn) {
    Strategy turned = solver;
    turn(turned);
    all.push_back({turned, 0, knob});
    all.push_back({turned, 1, Knob::iterations});
  };
  if (find_backend(backends(), solver.solver.backend).single) {
    with(Knob::precision, [](Strategy& t) { t.solver.single = true; });
    with(Knob::precision, [](Strategy& t) { t.solver.single = t.solver.refine = true; });
    with(Knob::precision, [](Strategy& t) { t.solver.single = t.solver.once = true; });
  }
  with(Knob::precision, [](Strategy& t) { t.solver.refine = true; });
  with(Knob::policy, [](Strategy& t) { t.solver.once = true; });
  with(Knob::policy, [](Strategy& t) { t.solver.reuse = Reuse::step; });
  with(Knob::policy, [](Strategy& t) { t.solver.reuse = Reuse::run; });
  with(Knob::policy, [](Strategy& t) { t.solver.separate = true; });
  return all;
}

std::vector<Way> fixed_iterations(const Strategy& solver) {
  std::vector<Way> all;
  for (const int iterations : kFixed) all.push_back({solver, iterations, Knob::iterations});
  return all;
}

std::string text_of(const Plan& plan) {
  std::vector<std::string> texts;
  for (const Plan::Choice& c : plan.choices) texts.push_back(to_string(plan.strategy(c)));
  const bool uniform = std::set<std::string>(texts.begin(), texts.end()).size() <= 1;
  std::string all = texts.empty() ? std::string(name(plan.run.formulation)) : texts[0];
  for (std::size_t c = 1; c < texts.size() && !uniform; ++c) all += " | " + texts[c];
  return all;
}

std::string essence(const Plan& plan) {
  Plan alone = plan;  // without the threads, which belong to the whole plan
  for (Plan::Choice& c : alone.choices) c.threads = 1;
  std::string all = text_of(alone);
  const bool by_level = !plan.level_threads.empty();
  const std::int32_t most =
      by_level ? *std::max_element(plan.level_threads.begin(), plan.level_threads.end()) : plan.run.threads;
  if (most == 1) return all;
  all += ", p = ";
  if (!by_level) return all + std::to_string(most);
  for (std::size_t level = 0; level < plan.level_threads.size(); ++level) {
    all += (level == 0 ? "" : " ") + std::to_string(plan.level_threads[level]);
  }
  return all;
}

bool is_hopeless(const Plan& plan) {
  return std::any_of(plan.choices.begin(), plan.choices.end(), [](const Plan::Choice& c) {
    return c.shape.n > kMostDense && properties_of(c.solver.backend).dense;
  });
}

}  // namespace assur::measure
