// What a tuning run found, for people and as JSON.
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

namespace assur::output {

struct TuningSummary {
  std::optional<std::int64_t> run;  // of the database; empty: stored nowhere
  std::string database;             // file; "": none
  std::string profile;
  std::string grade;  // good, fair, noisy
  std::string reason;
  double seconds = 0;
  tuning::CampaignFigures figures;
  tuning::Regret regret;
  std::map<std::string, std::string> failed;  // backends that did not survive their trial, and how
  std::span<const tuning::CellResult> cells;
};

// The fastest candidate of a cell.
struct Winner {
  std::string family;              // of what is comparable: told with what was timed
  Kernel kernel = Kernel::factor;  // factor: with three solutions
  bool side_by_side = false;       // of sixteen matrices, else of one
  std::int32_t n = 0, groups = 1;
  std::string strategy;
  double seconds = 0;  // for one matrix or group; step: of the mechanism
};

// Of every cell, sorted by family and size; of bare matrices for one alone and for sixteen side by side.
[[nodiscard]] std::vector<Winner> winners(std::span<const tuning::CellResult> cells);

void print(Page& page, const TuningSummary& summary);
[[nodiscard]] Json to_json(const TuningSummary& summary);

}  // namespace assur::output
