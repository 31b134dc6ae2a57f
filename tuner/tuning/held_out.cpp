#include "tuning/held_out.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "backends/backends.hpp"
#include "numbers.hpp"

namespace assur::tuning {
namespace {

constexpr double kTooScattered = 0.25;  // relative spread above which a time is not used
constexpr int kSolutions = 3;           // solutions for one factorisation: a Newton step, velocity, acceleration

const Sample* find(const CellResult& cell, Kernel kernel, const Strategy& strategy) {
  for (const Result& r : cell.results) {
    if (r.sample.kernel == kernel && r.sample.strategy == strategy) return &r.sample;
  }
  return nullptr;
}

// A candidate's time in a cell, for all groups: measured, and predicted by the model.
struct Times {
  double measured = kNan, expected = 0;
};

Times times(const PerformanceModel& model, const CellResult& cell, const Sample& s, int groups) {
  const double packs = std::ceil(static_cast<double>(groups) / s.strategy.solver.lanes);
  if (s.kernel == Kernel::pack) return {packs * s.seconds, packs * model.pack(s.shape, s.strategy).seconds};
  const Sample* solve = find(cell, Kernel::solve, s.strategy);
  if (solve == nullptr) return {};
  const auto expected = [&](Kernel kernel) { return model.kernel(kernel, s.shape, s.strategy).seconds; };
  return {packs * (s.seconds + kSolutions * solve->seconds),
          packs * (expected(Kernel::factor) + kSolutions * expected(Kernel::solve))};
}

// Regret of the choice among the allowed candidates; NaN if fewer than two can be compared.
double regret(const PerformanceModel& model, const CellResult& cell, int groups,
              const std::function<bool(const Strategy&)>& allowed) {
  double best = kInfinity, chosen = best, least_expected = best;
  int candidates = 0;
  for (const Result& r : cell.results) {
    const Sample& s = r.sample;
    if ((s.kernel != Kernel::factor && s.kernel != Kernel::pack) || !allowed(s.strategy)) continue;
    if (s.strategy.solver.lanes >= 2 * groups || s.spread > kTooScattered * s.seconds) continue;
    const Times t = times(model, cell, s, groups);
    if (std::isnan(t.measured)) continue;
    ++candidates;
    best = std::min(best, t.measured);
    if (t.expected >= least_expected) continue;
    least_expected = t.expected;
    chosen = t.measured;
  }
  return candidates < 2 ? kNan : chosen / best - 1;
}

}  // namespace

Regret regret(const PerformanceModel& model, std::span<const CellResult> cells) {
  std::vector<double> all;
  for (const CellResult& cell : cells) {
    if (!cell.cell.held_out) continue;
    const bool packs = cell.cell.kind == Cell::Kind::packs;
    for (const int groups : packs ? std::vector{cell.cell.groups} : std::vector{1, 16}) {
      for (const bool lanes : {true, false}) {
        const double r = regret(model, cell, groups, [&](const Strategy& s) {
          return (lanes || !properties_of(s.solver.backend).fills_lanes) && s.solver.reuse == Reuse::fresh &&
                 !s.solver.once;
        });
        if (!std::isnan(r)) all.push_back(r);
        if (groups > 1 && !packs) break;  // for matrices, only these backends solve groups side by side
      }
    }
  }
  if (all.empty()) return {};
  std::sort(all.begin(), all.end());
  const auto rank = [&](double share) {
    return all[static_cast<std::size_t>(std::ceil(share * static_cast<double>(all.size()))) - 1];
  };
  const double sum = std::accumulate(all.begin(), all.end(), 0.0);
  return {rank(0.5), rank(0.95), all.back(), sum / static_cast<double>(all.size()), all.size()};
}

}  // namespace assur::tuning
