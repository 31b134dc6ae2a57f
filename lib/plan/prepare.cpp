#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "dispatch/candidates.hpp"
#include "dispatch/counts.hpp"
#include "dispatch/dispatcher.hpp"
#include "dispatch/strategies.hpp"
#include "dispatch/throughput.hpp"
#include "dispatch/together_rules.hpp"
#include "executors/step_code.hpp"
#include "graph/spins.hpp"
#include "parallel/machine.hpp"
#include "plan/function_check.hpp"
#include "plan/preparation.hpp"
#include "plan/prepare_at.hpp"
#include "structure/same_structure.hpp"

namespace assur {
namespace {

Predictor automatic_predictor(const GroupedSystem& s) {
  const bool all = std::all_of(s.groups.begin(), s.groups.end(), [&](const SolvedGroup& g) {
    return g.wanted_derivatives == 2 && s.classes[static_cast<std::size_t>(g.group_class)].first_wanted == 0;
  });
  // If accelerations are not wanted, a prediction from past positions is as good and costs no factorisation.
  return all ? Predictor{Predictor::Kind::hermite, 5} : Predictor{Predictor::Kind::past, 5};
}

// Names the bodies if they only spin, else the unknowns.
void refuse_undetermined(const GroupedSystem& s) {
  if (s.undetermined.empty()) return;
  const std::set<std::string_view> free_names(s.undetermined.begin(), s.undetermined.end());
  std::vector<Index> free, explained;
  for (Index c = 0; c < static_cast<Index>(s.system->coordinates.size()); ++c) {
    if (free_names.count(s.system->coordinate_name(c)) != 0) free.push_back(c);
  }
  std::vector<Diagnostic> findings;
  for (const Spin& spin : spins(*s.system, free)) {
    explained.insert(explained.end(), spin.unknowns.begin(), spin.unknowns.end());
    findings.push_back({"/bodies/" + spin.body, "undetermined: the body may turn about " + spin.line +
                                                    ", and an output or a driver depends on this turn; ask only for "
                                                    "points on the line, or hold the body"});
  }
  std::sort(explained.begin(), explained.end());
  if (!findings.empty() && std::includes(explained.begin(), explained.end(), free.begin(), free.end())) {
    throw Error(Error::Kind::input, std::move(findings));
  }
  std::string names;
  for (std::size_t i = 0; i < s.undetermined.size(); ++i) {
    if (i == 12) {
      names += ", ... (" + std::to_string(s.undetermined.size()) + " in all)";
      break;
    }
    names += (i == 0 ? "" : ", ") + s.undetermined[i];
  }
  throw Error(Error::Kind::input, "undetermined: no equation determines " + names + "; add a constraint or a driver");
}

void check_controlled(const Scene& scene, const std::vector<std::string>& controlled) {
  std::string known;
  for (const Driver& d : scene.drivers()) known += (known.empty() ? "" : ", ") + d.name;
  for (const std::string& name : controlled) {
    if (std::none_of(scene.drivers().begin(), scene.drivers().end(), [&](const Driver& d) { return d.name == name; })) {
      throw Error(Error::Kind::input,
                  "'" + name + "' cannot be controlled, because it is not a driver; the drivers are: " + known);
    }
  }
}

std::shared_ptr<const PerformanceModel> model_of(const PrepareOptions& options) {
  return options.model ? options.model : machine_model().model;
}

void check_backend(const Backend& backend, const Plan::Choice& choice, std::span<const std::string> without) {
  const auto refuse = [&](const std::string& why) {
    throw Error(Error::Kind::environment, "backend " + std::string(backend.id) + " cannot run here: " + why);
  };
  if (std::find(without.begin(), without.end(), backend.id) != without.end()) refuse("left out");
  const std::string why_not = backend.why_not(choice.shape, ThreadBudget{choice.solver.threads});
  if (!why_not.empty()) refuse(why_not);
  if (choice.solver.single && !backend.single) refuse("it has no float version; leave out +float");
}

// Asks the machine only if no budget is given.
std::int32_t threads_at_most(const PrepareOptions& options) {
  return (options.budget ? *options.budget : available_budget()).threads;
}

void check_budget(const Strategy& wanted, const PrepareOptions& options) {
  const auto threads = std::int64_t{wanted.run.threads} * wanted.solver.threads;
  if (threads == 1) return;
  const std::int32_t most = threads_at_most(options);
  if (threads > most) {
    throw Error(Error::Kind::environment, "strategy " + to_string(wanted) + " cannot run here: it takes " +
                                              std::to_string(threads) + " threads and the budget is " +
                                              std::to_string(most) + "; choose a smaller PxQ or a larger budget");
  }
}

std::shared_ptr<const GroupedSystem> structure_for(const Scene& scene, const PrepareOptions& options,
                                                   Formulation formulation, const Predictor& predictor,
                                                   const KnownStart& start) {
  StructureOptions wanted;
  wanted.formulation = formulation;
  wanted.controlled = options.controlled;
  switch (predictor.kind) {
    case Predictor::Kind::taylor:
      wanted.predictor_derivatives = predictor.order;
      break;
    case Predictor::Kind::hermite:
      wanted.predictor_derivatives = 2;
      break;
    case Predictor::Kind::past:
    case Predictor::Kind::automatic:
      break;
  }
  auto structure = std::make_shared<const GroupedSystem>(group_equations(scene, wanted, start));
  refuse_undetermined(*structure);
  if (!structure->cannot_assemble.empty()) {
    // A wrong Jacobian may be the reason, and a check at the guess finds it.
    std::vector<Diagnostic> why{{"", structure->cannot_assemble}};
    const System& s = *structure->system;
    const std::vector<Diagnostic> wrong = find_wrong_functions(s, s.guess, scene.time(), options.controlled);
    why.insert(why.end(), wrong.begin(), wrong.end());
    throw Error(Error::Kind::numerical, std::move(why));
  }
  return structure;
}

void check_together(const GroupedSystem& s, const Strategy& wanted) {
  const std::string why_not = why_not_together(s, wanted);
  if (why_not.empty()) return;
  throw Error(Error::Kind::environment,
              "strategy " + to_string(wanted) + " cannot run here: " + why_not + "; leave out +together");
}

// The size of a class, without counts of operations.
Shape size_of(const GroupedSystem& s, std::int32_t group_class, std::int32_t groups) {
  const GroupClass& c = s.classes[static_cast<std::size_t>(group_class)];
  return {.n = c.n, .nnz = s.pattern(group_class).nnz(), .groups = groups, .rhs = 1 + c.derivatives};
}

std::vector<Shape> sizes_of(const GroupedSystem& s) {
  const std::vector<ClassSize> sizes = class_sizes(s);
  std::vector<Shape> shapes;
  for (std::size_t c = 0; c < sizes.size(); ++c) {
    shapes.push_back(size_of(s, static_cast<std::int32_t>(c), sizes[c].groups));
  }
  return shapes;
}

// The plan for a strategy text, which holds for every class.
Plan forced_plan(const GroupedSystem& s, const Strategy& wanted, const PrepareOptions& options) {
  // Shares of unequal packs need the expected times, for which operations are counted.
  const bool is_expected = wanted.run.threads > 1 || options.model;
  check_names(options.without, backends());
  if (wanted.run.together) check_together(s, wanted);
  Plan plan = uniform_plan(wanted, s, is_expected ? class_shapes(s) : sizes_of(s));
  plan.reason = "forced";
  for (Plan::Choice& choice : plan.choices) {
    choice.reason = "forced";
    check_backend(find_backend(backends(), choice.solver.backend), choice, options.without);
  }
  check_budget(wanted, options);
  if (is_expected) expect(plan, s, options.mode, *model_of(options));
  return plan;
}

// The other formulations, if they are cheap to try.
std::vector<Formulation> others_to_try(const GroupedSystem& irreducible) {
  constexpr std::int64_t kMostWeighed = 2000;  // unknowns; a choice: analysing a larger scene again takes long
  std::int64_t unknowns = 0;
  for (const SolvedGroup& g : irreducible.groups) unknowns += std::ssize(g.unknowns);
  std::vector<Formulation> others;
  if (unknowns <= kMostWeighed) others = formulations_of(irreducible);
  std::erase(others, Formulation::irreducible);
  return others;
}

struct Choice {
  std::shared_ptr<const GroupedSystem> structure;
  Plan plan;
};

Choice automatic_choice(const Scene& scene, const PrepareOptions& options, const KnownStart& start) {
  const std::shared_ptr<const PerformanceModel> model = model_of(options);
  check_names(options.without, backends());
  const Scales scales{*model, backends(), options.without};
  const Task task{options.mode, threads_at_most(options)};
  struct InOneFormulation {
    std::shared_ptr<const GroupedSystem> structure;
    Dispatched choice;
  };
  const auto choose = [&](Formulation formulation) {
    auto structure = structure_for(scene, options, formulation, {}, start);
    Dispatched choice = dispatch(*structure, task, scales);
    return InOneFormulation{std::move(structure), std::move(choice)};
  };
  // Measured times of whole steps are compared with each other only.
  const auto is_faster = [&](const Dispatched& a, const Dispatched& b) {
    const bool both = a.is_measured && b.is_measured;
    const double of_a = both ? a.plan.expected_seconds : a.modelled_seconds;
    return of_a < (both ? b.plan.expected_seconds : b.modelled_seconds) * (1 - scales.tie);
  };
  InOneFormulation best = choose(Formulation::irreducible);
  for (const Formulation formulation : others_to_try(*best.structure)) {
    try {
      InOneFormulation other = choose(formulation);
      if (is_faster(other.choice, best.choice)) best = std::move(other);
    } catch (const Error&) {
      // The scene cannot be prepared in this formulation, or its declared groups are invalid: keep the first one.
    }
  }
  return {std::move(best.structure), std::move(best.choice.plan)};
}

// The plan of `like`, if the scene has the same structure.
std::optional<Choice> choice_like(const Preparation& like, const Scene& scene, const PrepareOptions& options,
                                  const KnownStart& start) {
  Choice choice;
  choice.structure = structure_like(scene, options, start, like);
  if (!same_structure(*like.structure, *choice.structure)) return std::nullopt;
  choice.plan = like.plan;
  return choice;
}

// The same scene with another independent set of its equations: each class is solved as the one nearest in size was.
Choice choice_again(const Scene& scene, const PrepareOptions& options, const KnownStart& start,
                    const GroupedSystem& before, const Plan& plan) {
  Choice again{structure_for(scene, options, before.formulation, plan.run.predictor, start), plan};
  const GroupedSystem& s = *again.structure;
  if (s.levels != before.levels) again.plan.level_threads.clear();
  const std::string why_not = plan.run.together ? why_not_together(s) : "";
  if (!why_not.empty()) {
    again.plan.run.together = false;
    again.plan.reason += "; level after level: " + why_not;
  }
  again.plan.choices.clear();
  const std::vector<ClassSize> sizes = class_sizes(s);
  for (std::size_t c = 0; c < s.classes.size(); ++c) {
    const auto distance = [&](const Plan::Choice& to) { return std::abs(to.shape.n - s.classes[c].n); };
    Plan::Choice choice =
        *std::min_element(plan.choices.begin(), plan.choices.end(),
                          [&](const Plan::Choice& a, const Plan::Choice& b) { return distance(a) < distance(b); });
    choice.group_class = static_cast<std::int32_t>(c);
    choice.shape = size_of(s, choice.group_class, sizes[c].groups);
    again.plan.choices.push_back(std::move(choice));
  }
  return again;
}

// Puts the parts together. is_first: the functions of the scene must be checked.
Preparation finished(const Scene& scene, const PrepareOptions& options, Choice& choice, bool is_first) {
  if (is_first) {
    std::vector<Diagnostic> wrong =
        find_wrong_functions(*choice.structure->system, choice.structure->start, scene.time(), options.controlled);
    if (!wrong.empty()) throw Error(Error::Kind::input, std::move(wrong));
  }
  Preparation out;
  out.scene = std::make_shared<const Scene>(scene);
  out.name = scene.name();
  out.time = scene.time();
  out.controlled = options.controlled;
  out.table = backends();
  if (options.machine_code) out.code = step_code();
  out.plan = std::move(choice.plan);
  if (!choice.structure->redundant.empty() && !out.plan.choices.empty()) {
    out.reselect = [scene = out.scene, options, plan = out.plan, before = choice.structure](
                       std::vector<double> at, double t, std::vector<std::int32_t> checked) {
      const KnownStart start{std::move(at), t, false, AtRest::left_out, std::move(checked)};
      Choice again = choice_again(*scene, options, start, *before, plan);
      return finished(*scene, options, again, false);
    };
  }
  out.structure = std::move(choice.structure);
  return out;
}

}  // namespace

Preparation prepare_at(const Scene& scene, const PrepareOptions& options, const KnownStart& start,
                       const Preparation* like) {
  if (options.budget && options.budget->threads < 1) {
    throw Error(Error::Kind::input,
                "a budget needs at least one thread, not " + std::to_string(options.budget->threads));
  }
  if (!(options.accuracy >= 0) || !std::isfinite(options.accuracy)) {
    throw Error(Error::Kind::input,
                "an accuracy is a relative error such as 1e-8, or 0, not " + std::to_string(options.accuracy));
  }
  check_controlled(scene, options.controlled);
  if (like != nullptr) {
    if (std::optional<Choice> alike = choice_like(*like, scene, options, start))
      return finished(scene, options, *alike, true);
  }
  Choice choice;
  if (options.strategy == "auto") {
    choice = automatic_choice(scene, options, start);
  } else {
    const Strategy wanted = parse_strategy(options.strategy);
    choice.structure = structure_for(scene, options, wanted.run.formulation, wanted.run.predictor, start);
    choice.plan = forced_plan(*choice.structure, wanted, options);
  }
  Plan& plan = choice.plan;
  plan.accuracy = options.accuracy;
  if (plan.run.predictor.kind == Predictor::Kind::automatic)
    plan.run.predictor = automatic_predictor(*choice.structure);
  if (options.mode == Mode::throughput && options.strategy.find("+chunks=") == std::string::npos) {
    plan.run.chunks = chunks_for(plan.lanes, plan.run.threads, scene.time().steps());
  }
  return finished(scene, options, choice, start.is_first);
}

Prepared prepare(const Scene& scene, const PrepareOptions& options) {
  return Preparation::shared(prepare_at(scene, options, {}));
}

Prepared prepare_like(const Prepared& like, const Scene& scene, const PrepareOptions& options) {
  return Preparation::shared(prepare_at(scene, options, {}, &preparation(like)));
}

std::shared_ptr<const GroupedSystem> structure_like(const Scene& scene, const PrepareOptions& options,
                                                    const KnownStart& start, const Preparation& like) {
  return structure_for(scene, options, like.plan.run.formulation, like.plan.run.predictor, start);
}

}  // namespace assur
