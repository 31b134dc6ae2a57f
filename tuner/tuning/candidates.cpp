#include "tuning/candidates.hpp"

#include <algorithm>
#include <array>

#include "dispatch/candidates.hpp"
#include "dispatch/strategies.hpp"

namespace assur::tuning {
namespace {

constexpr std::array<std::int32_t, 5> kWidths = {1, 8, 16, 4, 2};  // most useful first
constexpr std::int32_t kWorthThreads = 100;  // unknowns from which several threads may speed up one factorisation

// The turn of a strategy: the most promising ones come first, then each backend once, because time may be short.
int turn_of(const Backend& backend, const SolverSettings& s) {
  if (s.single) return 3;
  if (backend.device) return s.lanes == 1 ? 1 : 2;
  if (backend.fills_lanes && (s.lanes == 1 || s.lanes == 8)) return 0;
  return !backend.fills_lanes && s.threads == 1 ? 1 : 2;
}

template <class Wanted>
std::vector<Strategy> in_turns(const Field& field, const StrategySpace& space, const Shape& shape,
                               const Wanted& wanted) {
  std::vector<Strategy> all = strategies(
      space, {.table = field.table, .shape = shape, .wanted = [&](const Backend& b, const Strategy& s) {
                return !(b.device && shape.n < kWorthDevice) && wanted(b, s.solver) && field.why_not(s).empty();
              }});
  const auto turn = [&](const Strategy& s) { return turn_of(find_backend(field.table, s.solver.backend), s.solver); };
  std::stable_sort(all.begin(), all.end(), [&](const Strategy& a, const Strategy& b) { return turn(a) < turn(b); });
  return all;
}

}  // namespace

std::vector<Strategy> linear_solvers(const Field& field, const Shape& shape, int most_lanes) {
  StrategySpace space;
  space.lanes.assign(kWidths.begin(), kWidths.end());
  space.threads = powers_of_two(field.budget.threads);
  space.policies = {{}, {.single = true}};
  return in_turns(field, space, shape, [&](const Backend& backend, const SolverSettings& s) {
    // The model predicts the other float times from these.
    if (s.single && (s.threads > 1 || s.lanes == 2 || s.lanes == 4)) return false;
    if (s.threads > 1 && !(backend.threads && shape.n >= kWorthThreads)) return false;
    return s.lanes == 1 || (backend.fills_lanes && s.lanes <= most_lanes);
  });
}

std::vector<Strategy> pack_strategies(const Field& field, Formulation formulation, const Shape& shape, bool policies) {
  StrategySpace space;
  space.formulations = {formulation};
  space.lanes.assign(kWidths.begin(), kWidths.end());
  // The time of +reuse= depends on the motion, so one posture cannot show it; `auto` does not weigh +separate.
  if (policies) space.policies = {{}, {.once = true}};
  return in_turns(field, space, shape, [&](const Backend& backend, const SolverSettings& s) {
    if (s.lanes == 1) return true;
    if (backend.fills_lanes) return s.lanes <= shape.groups && (!s.once || s.lanes == 8);
    // These evaluate equations in lanes and factorise lane by lane.
    return !backend.takes_turns && shape.groups > 4 && s.lanes < 2 * shape.groups;
  });
}

std::vector<Strategy> together_strategies(const Field& field, Formulation formulation, std::int32_t groups) {
  StrategySpace space;
  space.formulations = {formulation};
  space.lanes.assign(kWidths.begin(), kWidths.end());
  space.together = true;
  std::vector<Strategy> all =
      in_turns(field, space, {}, [&](const Backend&, const SolverSettings& s) { return s.lanes < 2 * groups; });
  std::erase_if(all, [](const Strategy& s) { return !s.run.together; });
  return all;
}

}  // namespace assur::tuning
