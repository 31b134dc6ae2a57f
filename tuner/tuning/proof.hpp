// The proof of a tuning run: on mechanisms unlike those of its cells, the strategy that the model expects to be the
// fastest against the next ones.
#pragma once

#include <string>
#include <vector>

#include "tuning/campaign.hpp"

namespace assur::tuning {

struct Proof {
  std::string scene;
  std::string chosen, fastest;  // strategies that all classes share
  double seconds = 0;           // one step by the chosen one
  double expected_seconds = 0;  // the same, by the model
  double fastest_seconds = 0;

  [[nodiscard]] double regret() const { return seconds / fastest_seconds - 1; }
};

// Cells of whole steps of a mechanism, one for each formulation, with the `most` strategies on one thread that the
// model expects to be the fastest. `first` is the fastest one.
struct ProofCells {
  std::vector<Cell> cells;
  Strategy first;
  double expected_seconds = 0;  // of `first`
};
[[nodiscard]] ProofCells proof_cells(const std::string& scene, const PerformanceModel& model, const Field& field,
                                     std::size_t most);

// Measures such cells of a dozen mechanisms with joints, gears, chains, many small groups and large ones. Their times
// are samples like others: they decide on plans for these mechanisms (Dispatched::is_measured).
[[nodiscard]] std::vector<Proof> prove(Campaign& campaign, const Field& field);

}  // namespace assur::tuning
