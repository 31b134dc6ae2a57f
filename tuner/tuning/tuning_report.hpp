// Results of a tuning run, for people and as JSON.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "measure/noise.hpp"
#include "output/json.hpp"
#include "output/page.hpp"
#include "tuning/campaign.hpp"
#include "tuning/held_out.hpp"
#include "tuning/proof.hpp"

namespace assur::output {

struct TuningSummary {
  std::optional<std::int64_t> run;  // id in the database; empty: not stored
  std::string database;             // file; "": none
  std::string profile;
  std::string grade;  // good, fair, noisy
  std::string reason;
  double seconds = 0;
  tuning::CampaignFigures figures;
  tuning::Regret regret;
  std::vector<tuning::Proof> proofs;
  std::map<std::string, std::string> failed;  // backends that failed their trial, with the reason
  std::span<const tuning::CellResult> cells;
};

// The strategy without its formulation, which matrices do not have.
[[nodiscard]] std::string short_text(const Strategy& strategy);

// The fastest candidate of a cell.
struct Winner {
  std::string family;              // together with `kernel`: the series in which winners can be compared
  Kernel kernel = Kernel::factor;  // for Kernel::factor, `seconds` includes three solutions
  bool side_by_side = false;       // true: sixteen matrices; false: one
  std::int32_t n = 0, groups = 1;
  std::string strategy;
  double seconds = 0;  // for one matrix or group; step: of the mechanism
};

// The winners of all cells, sorted by family and size; for bare matrices one for a single matrix and one for sixteen
// side by side.
[[nodiscard]] std::vector<Winner> winners(std::span<const tuning::CellResult> cells);

void print(Page& page, const TuningSummary& summary);
[[nodiscard]] Json to_json(const TuningSummary& summary);

}  // namespace assur::output
