#include "measure/ways.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "assur/backend.hpp"
#include "backends/backends.hpp"

namespace assur::measure {
namespace {

constexpr std::array kFixed = {1, 2, 3};  // the paper's tEnd2
constexpr std::int32_t kLanes = 8;        // one width stands for all: the dispatcher weighs the others
constexpr std::int32_t kMostDense = 600;  // unknowns

constexpr std::array kPredictors = {Predictor{Predictor::Kind::taylor, 0}, Predictor{Predictor::Kind::taylor, 1},
                                    Predictor{Predictor::Kind::taylor, 2}, Predictor{Predictor::Kind::hermite, 5},
                                    Predictor{Predictor::Kind::past, 1},   Predictor{Predictor::Kind::past, 3},
                                    Predictor{Predictor::Kind::past, 5}};

// What one class is solved with, threads aside: those are the plan's.
std::string text_of(Strategy s) {
  s.run.threads = 1;
  return to_string(s);
}

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
  std::vector<Formulation> formulations = {Formulation::irreducible, Formulation::global};
  if (!scene.groups().empty()) formulations.push_back(Formulation::groups);
  std::vector<Way> all;
  for (const Backend& backend : backends()) {
    if (!backend.why_not({}, {}).empty()) continue;
    Strategy plain;
    plain.solver.backend = backend.id;
    const auto add = [&](auto turn) {
      Way way{plain};
      turn(way.strategy);
      all.push_back(std::move(way));
    };
    for (const Formulation formulation : formulations) {
      plain.run.formulation = formulation;
      all.push_back({plain});
      if (formulation == Formulation::global) continue;  // a single group
      if (backend.steady) add([](Strategy& s) { s.solver.lanes = kLanes; });
      if (budget.threads > 1 && !backend.takes_turns) add([&](Strategy& s) { s.run.threads = budget.threads; });
    }
    plain.run.formulation = Formulation::irreducible;
    if (budget.threads > 1 && backend.why_not({}, budget).empty())
      add([&](Strategy& s) { s.solver.threads = budget.threads; });
  }
  return all;
}

std::vector<Way> variations(const Strategy& solver) {
  std::vector<Way> all = fixed_iterations(solver);
  Strategy s = solver;
  for (const Predictor& predictor : kPredictors) {
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

std::string essence(const Plan& plan) {
  std::vector<std::string> texts;
  for (const Plan::Choice& c : plan.choices) texts.push_back(text_of(plan.strategy(c)));
  if (std::set<std::string>(texts.begin(), texts.end()).size() <= 1)
    texts.resize(std::min<std::size_t>(texts.size(), 1));
  std::string all = texts.empty() ? std::string(name(plan.run.formulation)) : "";
  for (const std::string& text : texts) all += (all.empty() ? "" : " | ") + text;
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
