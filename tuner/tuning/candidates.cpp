#include "tuning/candidates.hpp"

#include <algorithm>
#include <string_view>

namespace assur::tuning {
namespace {

constexpr int kWidths[] = {1, 8, 16, 4, 2};  // in the order of their turns
constexpr std::int32_t kWorthThreads = 100;  // unknowns from which on more threads in one factorisation may gain

bool can_run(const Field& field, const Backend& backend, const Shape& shape, const Strategy& strategy) {
  return backend.why_not(shape, ThreadBudget{strategy.solver.threads}).empty() && field.why_not(strategy).empty();
}

}  // namespace

std::vector<Strategy> linear_solvers(const Field& field, const Shape& shape, int most_lanes) {
  std::vector<Strategy> first, plain, wider, more;
  const auto enter = [&](const Backend& backend, int lanes, int q) {
    Strategy s;
    s.solver.backend = backend.id;
    s.solver.lanes = lanes;
    s.solver.threads = q;
    if (!can_run(field, backend, shape, s)) return;
    const bool leading = backend.fills_lanes && (lanes == 1 || lanes == 8);
    (leading ? first : lanes == 1 && q == 1 ? plain : wider).push_back(s);
    if (q > 1 || lanes == 2 || lanes == 4) return;  // what they take in float follows from the others'
    s.solver.single = true;                         // which refines by itself
    if (backend.single) more.push_back(s);
  };
  for (const Backend& backend : field.table) {
    for (const int w : kWidths) {
      if (w == 1 || (backend.fills_lanes && w <= most_lanes)) enter(backend, w, 1);
    }
    for (int q = 2; backend.threads && shape.n >= kWorthThreads && q <= field.budget.threads; q *= 2) {
      enter(backend, 1, q);
    }
  }
  for (const std::vector<Strategy>* next : {&plain, &wider, &more})
    first.insert(first.end(), next->begin(), next->end());
  return first;
}

std::vector<Strategy> pack_strategies(const Field& field, Formulation formulation, const Shape& shape, bool policies) {
  std::vector<Strategy> out;
  // What +reuse= takes depends on the motion: it cannot be told from one posture.
  const auto enter = [&](Strategy s, bool also_separate) {
    out.push_back(s);
    if (!policies) return;
    s.solver.once = true;
    out.push_back(s);
    s.solver.once = false;
    s.solver.separate = true;
    if (also_separate) out.push_back(s);
  };
  for (Strategy s : linear_solvers(field, shape, shape.groups)) {
    if (s.solver.single || s.solver.refine || s.solver.threads > 1)
      continue;  // of bare matrices alone: a step composes them
    s.run.formulation = formulation;
    const Backend& backend = find_backend(field.table, s.solver.backend);
    if (backend.fills_lanes && s.solver.lanes != 1 && s.solver.lanes != 8) {
      out.push_back(s);
      continue;
    }
    enter(s, true);
    // Lane by lane, but with equations side by side; no dispatcher weighs +separate.
    if (backend.fills_lanes || backend.takes_turns || shape.groups <= 4) continue;
    for (const int w : kWidths) {
      if (w == 1 || w >= 2 * shape.groups) continue;
      s.solver.lanes = w;
      enter(s, false);
    }
  }
  return out;
}

}  // namespace assur::tuning
