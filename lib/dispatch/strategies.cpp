#include "dispatch/strategies.hpp"

#include <algorithm>

#include "dispatch/together_rules.hpp"
#include "equations/system.hpp"

namespace assur {
namespace {

bool means_something(const Backend& backend, const Strategy& s) {
  const SolverSettings& solver = s.solver;
  if (solver.single && !backend.single) return false;
  if (solver.once && solver.separate) return false;
  if (solver.threads > 1 && solver.lanes > 1) return false;
  if (s.run.threads > 1 && backend.takes_turns) return false;
  return s.run.formulation != Formulation::global || (solver.lanes == 1 && s.run.threads == 1);
}

// Calls `visit` with every solver of the space for one backend.
template <class Visit>
void each_solver(const StrategySpace& space, const Backend& backend, const Shape& shape, const Visit& visit) {
  for (const std::int32_t lanes : space.lanes) {
    for (const std::int32_t threads : space.threads) {
      if (!backend.why_not(shape, ThreadBudget{threads}).empty()) continue;
      for (SolverSettings solver : space.policies) {
        solver.backend = backend.id;
        solver.lanes = lanes;
        solver.threads = threads;
        visit(solver);
      }
    }
  }
}

}  // namespace

std::vector<std::int32_t> powers_of_two(std::int32_t most) {
  std::vector<std::int32_t> all = {1};
  while (all.back() <= most / 2) all.push_back(2 * all.back());
  return all;
}

std::vector<Formulation> formulations_of(const GroupedSystem& irreducible) {
  std::vector<Formulation> all = {Formulation::irreducible};
  const bool eliminates = irreducible.eliminated > 0;
  if (eliminates || !irreducible.system->groups.empty()) all.push_back(Formulation::groups);
  if (eliminates || irreducible.groups.size() > 1) all.push_back(Formulation::global);
  return all;
}

std::vector<Strategy> strategies(const StrategySpace& space, const StrategyFilter& filter) {
  std::vector<Strategy> all;
  const auto enter = [&](const Backend& backend, const Strategy& s) {
    if (means_something(backend, s) && (!filter.wanted || filter.wanted(backend, s))) all.push_back(s);
  };
  for (const Backend& backend : filter.table) {
    if (std::find(filter.without.begin(), filter.without.end(), backend.id) != filter.without.end()) continue;
    for (const Formulation formulation : space.formulations) {
      for (const std::int32_t packs : space.packs) {
        each_solver(space, backend, filter.shape, [&](const SolverSettings& solver) {
          for (const Predictor& predictor : space.predictors) {
            Strategy s{{.formulation = formulation, .predictor = predictor, .threads = packs}, solver};
            enter(backend, s);
            s.run.together = true;
            if (space.together && why_not_together(s).empty()) enter(backend, s);
          }
        });
      }
    }
  }
  return all;
}

}  // namespace assur
