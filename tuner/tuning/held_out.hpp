// The regret of a model on held-out cells.
#pragma once

#include <span>

#include "tuning/campaign.hpp"

namespace assur::tuning {

// time(chosen) / time(best) - 1 over all questions. A question is a cell with a number of groups side by side and a set
// of backends.
struct Regret {
  double median = 0, p95 = 0, max = 0, mean = 0;
  std::size_t questions = 0;  // 0: nothing was held out
};

[[nodiscard]] Regret regret(const PerformanceModel& model, std::span<const CellResult> cells);

}  // namespace assur::tuning
