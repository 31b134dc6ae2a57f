// Chooses further cells: between sizes at which the best two strategies are close and the model is uncertain.
#pragma once

#include <span>
#include <vector>

#include "tuning/campaign.hpp"

namespace assur::tuning {

// At most `most` new cells between neighbouring sizes of measured families. The first cells are expected to
// improve the choices of the model most. Empty if no two neighbours are far enough apart.
[[nodiscard]] std::vector<Cell> propose(const PerformanceModel& model, std::span<const CellResult> cells,
                                        std::size_t most);

// The model of all samples except held-out ones.
[[nodiscard]] PerformanceModel model_of(std::span<const CellResult> cells);

// Spends the remaining time of a campaign on new cells; after a few cells it fits a new model. until_settled: also
// measures all cells again for each new model, and ends when three models in a row have not reduced the mean regret on
// held-out cells.
void refine(Campaign& campaign, bool until_settled);

}  // namespace assur::tuning
