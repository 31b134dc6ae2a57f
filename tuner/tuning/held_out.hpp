// How good a model's choices are, on cells that it has not seen.
#pragma once

#include <span>

#include "tuning/campaign.hpp"

namespace assur::tuning {

// time(chosen) / time(best) - 1 over all questions; a question is a cell, how many groups there are side by side, and
// which backends may be used.
struct Regret {
  double median = 0, p95 = 0, max = 0, mean = 0;
  std::size_t questions = 0;  // 0: nothing was held out
};

[[nodiscard]] Regret regret(const PerformanceModel& model, std::span<const CellResult> cells);

}  // namespace assur::tuning
