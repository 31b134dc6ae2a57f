// A tuning run: cells in turn, each within its share of the time, each stored when it is done.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "measure/race.hpp"
#include "tuning/cells.hpp"
#include "tuning/entrants.hpp"
#include "tuning/history.hpp"

namespace assur::tuning {

// What came of one candidate in one cell.
struct Result {
  Sample sample;
  bool hopeless = false;  // timed a few times only
};
struct Refusal {
  Candidate candidate;
  std::string why;
};
struct CellResult {
  Cell cell;
  std::vector<Result> results;
  std::vector<Refusal> refused;  // never timed: wrong, cannot run, or too slow to be tried
  bool cut_short = false;        // time ran out before every candidate had its turn
};

struct CampaignOptions {
  Field field;
  double seconds = 60;                           // for all cells
  measure::RaceRules race;                       // but for the time
  std::function<void(const CellResult&)> store;  // once for each cell that has samples
  std::function<bool(const Sample&)> stored = [](const Sample&) { return false; };  // by an earlier, interrupted run
  std::function<void(double seconds, std::size_t done, std::size_t of, const Cell&)> progress = nullptr;
};

struct CampaignFigures {
  std::size_t planned = 0, measured = 0, skipped = 0;  // cells; skipped: stored before
  std::int64_t samples = 0;
  measure::RaceFigures race;
  double seconds = 0;
  bool interrupted = false;
  std::vector<std::string> failures;  // cells that could not be opened
};

class Campaign {
 public:
  // clock, involuntary switches and stop() as a race has them.
  Campaign(CampaignOptions options, measure::Instruments instruments);

  // Until all cells are done, the time is used up, or stop() says so. May be called again with more cells.
  void run(const std::vector<Cell>& cells);

  [[nodiscard]] const CampaignFigures& figures() const { return figures_; }
  [[nodiscard]] double seconds_left() const;

 private:
  [[nodiscard]] CellResult measure_cell(const Cell& cell, Ground& ground, double seconds);
  [[nodiscard]] bool was_stored(const Ground& ground) const;

  CampaignOptions options_;
  measure::Instruments instruments_;
  History history_;
  CampaignFigures figures_;
  double begin_;
};

}  // namespace assur::tuning
