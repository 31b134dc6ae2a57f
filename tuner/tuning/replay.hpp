// A finished tuning run once more, from its samples: what was known of the machine at which time.
#pragma once

#include <span>
#include <vector>

#include "assur/performance.hpp"
#include "tuning/campaign.hpp"
#include "tuning/held_out.hpp"

namespace assur::tuning {

// The cells of a run over general_cells(), in the order in which their first samples were stored. Of a cell only its
// kind, n, groups and held_out are known.
[[nodiscard]] std::vector<CellResult> cells_of(std::span<const Sample> samples);

// What was known after some of the cells.
struct Stage {
  std::size_t cells = 0, samples = 0;  // that the model knows
  double share = 0;                    // of the time of all timed calls but those that were held out
  Regret regret;                       // on what was held out
};

// After 1, 2, ... of `most` parts that took the same time; fewer where there are fewer cells.
[[nodiscard]] std::vector<Stage> replay(std::span<const CellResult> cells, int most);

}  // namespace assur::tuning
