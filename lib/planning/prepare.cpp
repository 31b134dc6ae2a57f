#include <algorithm>

#include "assur/machine.hpp"
#include "assur/plan.hpp"
#include "planning/throughput.hpp"

namespace assur {
namespace {

// Where nothing has been measured on the machine at hand, a plan exists all the same. Lanes are the fastest for sparse
// groups of any size that was tried (factor and three solves against KLU's refactor: 2.8 times for one group, 12 times
// for eight); they write their elimination down step by step, so a matrix that fills up is not for them.
constexpr std::int32_t kMostPerRow = 8;
constexpr std::int32_t kMostInLanes = 4000;  // unknowns
constexpr std::int32_t kDenseUpTo = 8;

struct Unmeasured {
  std::string backend, reason;
};
Unmeasured choose_unmeasured(const Shape& shape, bool has_klu) {
  if (shape.n <= kMostInLanes && shape.nnz <= kMostPerRow * shape.n) return {"lanes", "not measured: sparse, in lanes"};
  if (shape.n <= kDenseUpTo || !has_klu) return {"eigen", "not measured: dense"};
  return {"klu", "not measured: large or filled"};
}

Predictor automatic_predictor(const Structure& s) {
  const bool all = std::all_of(s.groups.begin(), s.groups.end(), [&](const Group& g) {
    return g.wanted_derivatives == 2 && s.classes[static_cast<std::size_t>(g.group_class)].first_wanted == 0;
  });
  // Where accelerations are not wanted, past positions predict as well and cost no factorisation.
  return all ? Predictor{Predictor::Kind::hermite, 5} : Predictor{Predictor::Kind::past, 5};
}

void refuse_undetermined(const Structure& s) {
  if (s.undetermined.empty()) return;
  std::string names;
  for (std::size_t i = 0; i < s.undetermined.size(); ++i) {
    if (i == 12) {
      names += ", ... (" + std::to_string(s.undetermined.size()) + " in all)";
      break;
    }
    names += (i == 0 ? "" : ", ") + s.undetermined[i];
  }
  throw Error(Error::Kind::input, "undetermined: nothing fixes " + names + "; add a constraint or a driver");
}

void check_controlled(const Scene& scene, const std::vector<std::string>& controlled) {
  std::string known;
  for (const Driver& d : scene.drivers()) known += (known.empty() ? "" : ", ") + d.name;
  for (const std::string& name : controlled) {
    if (std::none_of(scene.drivers().begin(), scene.drivers().end(), [&](const Driver& d) { return d.name == name; })) {
      throw Error(Error::Kind::input, "'" + name + "' cannot be controlled, it is no driver; there are: " + known);
    }
  }
}

struct ClassSize {
  std::int32_t groups = 0;
  std::int32_t side_by_side = 0;  // most groups on one level
};

std::vector<ClassSize> class_sizes(const Structure& s) {
  std::vector<ClassSize> sizes(s.classes.size());
  std::vector<std::int32_t> on_level(s.classes.size(), 0), level(s.classes.size(), -1);
  for (const Group& g : s.groups) {  // level after level
    const auto c = static_cast<std::size_t>(g.group_class);
    on_level[c] = level[c] == g.level ? on_level[c] + 1 : 1;
    level[c] = g.level;
    ++sizes[c].groups;
    sizes[c].side_by_side = std::max(sizes[c].side_by_side, on_level[c]);
  }
  return sizes;
}

void check_backend(const Backend& backend, const Plan::Choice& choice) {
  const auto refuse = [&](const std::string& why) {
    throw Error(Error::Kind::environment, "backend " + std::string(backend.id) + " cannot run here: " + why);
  };
  const std::string why_not = backend.why_not(choice.shape, ThreadBudget{choice.strategy.q});
  if (!why_not.empty()) refuse(why_not);
  if (choice.strategy.single && !backend.single) refuse("it has no float version; leave out +float");
}

// The machine is asked only where the answer matters: that takes longer than to prepare a small scene.
void check_budget(const Strategy& wanted, const std::optional<ThreadBudget>& given) {
  if (given && given->threads < 1) {
    throw Error(Error::Kind::input, "a budget has at least one thread, not " + std::to_string(given->threads));
  }
  const auto threads = std::int64_t{wanted.p} * wanted.q;
  if (threads == 1) return;
  const std::int32_t most = (given ? *given : this_machine().budget()).threads;
  if (threads > most) {
    throw Error(Error::Kind::environment, "strategy " + to_string(wanted) + " cannot run here: it takes " +
                                              std::to_string(threads) + " threads and the budget is " +
                                              std::to_string(most) + "; choose a smaller PxQ or a larger budget");
  }
}

// In throughput what the strategy does not say is chosen for the machine, whatever backends do the work.
void fill_machine(Strategy& wanted, const PrepareOptions& options, const TimeGrid& grid) {
  if (options.mode != Mode::throughput) return;
  if (options.strategy == "auto") {
    wanted.lanes = kThroughputLanes;
    wanted.p = (options.budget ? *options.budget : this_machine().budget()).threads;
    check_budget(wanted, options.budget);
  }
  if (options.strategy.find("+chunks=") == std::string::npos) wanted.chunks = chunks_for(wanted, grid.steps());
}

Prepared prepare_at(const Scene& scene, const PrepareOptions& options, std::vector<double> posture, double time) {
  const bool automatic = options.strategy == "auto";
  Strategy wanted = parse_strategy(automatic ? "irreducible/lanes:8" : options.strategy);
  fill_machine(wanted, options, scene.time());
  check_controlled(scene, options.controlled);
  StructureOptions structure_options;
  structure_options.formulation = wanted.formulation;
  structure_options.controlled = options.controlled;
  structure_options.posture = std::move(posture);
  structure_options.time = time;
  if (wanted.predictor.kind == Predictor::Kind::taylor)
    structure_options.predictor_derivatives = wanted.predictor.order;
  if (wanted.predictor.kind == Predictor::Kind::hermite) structure_options.predictor_derivatives = 2;

  Prepared out;
  out.scene = std::make_shared<const Scene>(scene);
  out.controlled = options.controlled;
  auto structure = std::make_shared<Structure>(analyze(scene, structure_options));
  refuse_undetermined(*structure);
  if (!structure->cannot_assemble.empty()) throw Error(Error::Kind::numerical, structure->cannot_assemble);
  out.table = backends();
  out.plan.formulation = wanted.formulation;
  out.plan.predictor =
      wanted.predictor.kind == Predictor::Kind::automatic ? automatic_predictor(*structure) : wanted.predictor;

  out.plan.lanes = wanted.lanes;
  out.plan.chunks = wanted.chunks;
  out.plan.threads = wanted.p;
  const std::vector<ClassSize> sizes = class_sizes(*structure);
  const bool has_klu = find_backend(out.table, "klu").why_not({}, {}).empty();
  for (std::size_t c = 0; c < structure->classes.size(); ++c) {
    Plan::Choice choice;
    choice.group_class = static_cast<std::int32_t>(c);
    choice.shape = {structure->classes[c].n, structure->pattern(choice.group_class).nnz(), sizes[c].groups,
                    1 + structure->classes[c].derivatives};
    choice.strategy = wanted;
    choice.strategy.predictor = out.plan.predictor;
    choice.reason = "forced";
    if (automatic) {
      const Unmeasured chosen = choose_unmeasured(choice.shape, has_klu);
      choice.strategy.backend = chosen.backend;
      choice.reason = chosen.reason;
      if (chosen.backend != "lanes") choice.strategy.lanes = 1;
    }
    // W is "up to": lanes that no group could fill would be computed for nothing.
    while (choice.strategy.lanes / 2 >= sizes[c].side_by_side) choice.strategy.lanes /= 2;
    check_backend(find_backend(out.table, choice.strategy.backend), choice);
    out.plan.choices.push_back(std::move(choice));
  }
  check_budget(wanted, options.budget);
  if (!structure->redundant.empty()) {
    out.reselect = [scene, options](std::vector<double> at, double t) {
      return prepare_at(scene, options, std::move(at), t);
    };
  }
  out.structure = std::move(structure);
  return out;
}

}  // namespace

Prepared prepare(const Scene& scene, const PrepareOptions& options) { return prepare_at(scene, options, {}, 0); }

}  // namespace assur
