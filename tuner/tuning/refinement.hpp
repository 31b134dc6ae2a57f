// Where one more cell tells most: between sizes where the best two are close and the model is unsure.
#pragma once

#include <span>
#include <vector>

#include "tuning/campaign.hpp"

namespace assur::tuning {

// At most `most` new cells, each between two neighbouring sizes of a family that was measured, those first from which
// the model's choice is expected to gain most. Empty if no two neighbours are far enough apart.
[[nodiscard]] std::vector<Cell> propose(const PerformanceModel& model, std::span<const CellResult> cells,
                                        std::size_t most);

// Everything that is known but for what was held out.
[[nodiscard]] PerformanceModel model_of(std::span<const CellResult> cells);

// Spends the time that a campaign has left on new cells, a few between two models. until_settled: measures all cells
// again between two models, and ends once three models in a row have not lowered the mean regret on what was held out.
void refine(Campaign& campaign, bool until_settled);

}  // namespace assur::tuning
