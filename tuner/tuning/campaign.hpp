// A tuning run: measures cells in turn, each within its share of the time, and stores each one when it is done.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "measure/race.hpp"
#include "tuning/cells.hpp"
#include "tuning/entrants.hpp"
#include "tuning/history.hpp"

namespace assur::tuning {

// Result of one candidate in one cell.
struct Result {
  Sample sample;               // the median of all passes
  int rounds = 0;              // timed in the last pass; 0: measured by an interrupted run
  bool hopeless = false;       // true if it left the race early, with few rounds
  std::vector<Sample> passes;  // one for each time that the cell was measured, the fastest first

  explicit Result(Sample first) : sample(first), passes{std::move(first)} {}
  void add(Sample pass);
};
// Adds a pass to the result of its candidate in `known`, or a new result.
void add(std::vector<Result>& known, const Result& more);

struct Refusal {
  Candidate candidate;
  std::string why;
};
struct CellResult {
  Cell cell;
  std::vector<Result> results;
  std::vector<Refusal> refused;  // not timed: wrong, cannot run, or too slow
  bool earlier = false;          // measured by an interrupted run
  bool cut_short = false;        // time ran out before every candidate had its turn
};

// Adds Kernel::around of this shape: the time of a step minus the times of its packs, if both were timed.
void add_around(CellResult& cell, std::span<const Entrant> entrants, const Shape& shape);

struct CampaignOptions {
  Field field;
  double seconds = 60;                           // for all cells
  double most_for_cell = 5;                      // s, for a cell of weight 1
  measure::RaceRules race;                       // except for its time
  std::function<void(const CellResult&)> store;  // called once for each cell with samples
  std::vector<Sample> earlier = {};              // samples of an interrupted run, whose cells are not measured again
  std::function<void(double seconds, const Cell&)> progress = nullptr;  // before each cell
};

struct CampaignFigures {
  // Numbers of cells. earlier: measured by an interrupted run; cut_short: ended before every candidate was measured;
  // both are included in `measured`.
  std::size_t planned = 0, measured = 0, earlier = 0, cut_short = 0;
  int passes = 1;  // over all cells
  std::int64_t samples = 0;
  measure::RaceFigures race;
  std::vector<double> slowness;  // slowness of the machine in each measured cell
  double seconds = 0;
  bool interrupted = false;
  std::vector<std::string> failures;  // cells that could not be opened

  // Part of the planned cells that were measured completely.
  [[nodiscard]] double coverage() const {
    return planned > 0 ? static_cast<double>(measured - cut_short) / static_cast<double>(planned) : 1;
  }
  // Relative difference of the slowness of the machine between the 90th and the 10th percentile of the cells.
  [[nodiscard]] double drift() const;
};

class Campaign {
 public:
  // instruments: as for a race.
  Campaign(CampaignOptions options, measure::Instruments instruments);

  // Measures cells until all are done, the time but `kept` seconds is used up, or stop() is true. May be called again
  // with more cells.
  void run(const std::vector<Cell>& cells, double kept = 0);

  // Measures all cells so far again, because disturbances of a machine change from minute to minute.
  void again();

  // Results of all cells so far, including those of an interrupted run.
  [[nodiscard]] const std::vector<CellResult>& results() const { return results_; }
  [[nodiscard]] const CampaignFigures& figures() const { return figures_; }
  [[nodiscard]] double seconds_left() const;

 private:
  // Calls work(cell, ground, seconds) for each cell while there is time.
  template <class Work>
  void visit(const std::vector<Cell>& cells, double kept, const Work& work);
  [[nodiscard]] CellResult measure_cell(const Cell& cell, Ground& ground, double seconds);
  [[nodiscard]] CellResult earlier(const Cell& cell, const Ground& ground) const;
  void note(const CellResult& result, double n, const std::vector<std::pair<Candidate, double>>& setups);
  [[nodiscard]] bool is_known(const Cell& cell, const Ground& ground) const;
  void keep(CellResult result);
  void store(const CellResult& result) const;

  CampaignOptions options_;
  measure::Instruments instruments_;
  History history_;
  std::vector<CellResult> results_;
  CampaignFigures figures_;
  double begin_;
};

}  // namespace assur::tuning
