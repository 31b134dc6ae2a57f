// Replays a finished tuning run from its samples: the regret as a function of the time spent.
#pragma once

#include <span>
#include <vector>

#include "assur/performance.hpp"
#include "tuning/campaign.hpp"
#include "tuning/held_out.hpp"

namespace assur::tuning {

// The cells of a run over general_cells(), in the order of their first samples. Only kind, n, groups and held_out of a
// cell are set.
[[nodiscard]] std::vector<CellResult> cells_of(std::span<const Sample> samples);

// The model after a part of the run.
struct Stage {
  std::size_t cells = 0, samples = 0;  // that the model uses
  double share = 0;                    // part of the time of all timed calls, without held-out cells
  Regret regret;                       // on held-out cells
};

// Stages after 1, 2, ... of `most` parts of equal time; fewer if there are fewer cells.
[[nodiscard]] std::vector<Stage> replay(std::span<const CellResult> cells, int most);

}  // namespace assur::tuning
