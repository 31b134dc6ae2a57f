// A tuning run: cells in turn, each within its share of the time, each stored when it is done.
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

// What came of one candidate in one cell.
struct Result {
  Sample sample;               // the middle one of all passes
  int rounds = 0;              // that were timed at last; 0: by an interrupted run
  bool hopeless = false;       // then only a few
  std::vector<Sample> passes;  // one for each time that the cell was measured, the fastest first

  explicit Result(Sample first) : sample(first), passes{std::move(first)} {}
  void add(Sample pass);
};
// One more pass of a candidate that `known` has, or else a new one.
void add(std::vector<Result>& known, const Result& more);

struct Refusal {
  Candidate candidate;
  std::string why;
};
struct CellResult {
  Cell cell;
  std::vector<Result> results;
  std::vector<Refusal> refused;  // never timed: wrong, cannot run, or too slow to be tried
  bool earlier = false;          // measured by an interrupted run
  bool cut_short = false;        // time ran out before every candidate had its turn
};

// What is left of a step without its packs, `shape` of it, where both were timed: Kernel::around.
void add_around(CellResult& cell, std::span<const Entrant> entrants, const Shape& shape);

struct CampaignOptions {
  Field field;
  double seconds = 60;                           // for all cells
  double most_for_cell = 5;                      // s, for a cell of weight 1
  measure::RaceRules race;                       // but for the time
  std::function<void(const CellResult&)> store;  // once for each cell that has samples
  std::vector<Sample> earlier = {};              // of an interrupted run: their cells are not measured again
  std::function<void(double seconds, const Cell&)> progress = nullptr;  // before each cell
};

struct CampaignFigures {
  // Cells; earlier, cut_short: of those measured, by an interrupted run, and before every candidate had its turn.
  std::size_t planned = 0, measured = 0, earlier = 0, cut_short = 0;
  int passes = 1;  // over all cells, as far as the time went
  std::int64_t samples = 0;
  measure::RaceFigures race;
  std::vector<double> slowness;  // of the machine, in each cell measured
  double seconds = 0;
  bool interrupted = false;
  std::vector<std::string> failures;  // cells that could not be opened

  // Share of the cells planned that were measured whole.
  [[nodiscard]] double coverage() const {
    return planned > 0 ? static_cast<double>(measured - cut_short) / static_cast<double>(planned) : 1;
  }
  // How much slower the machine was in one cell of ten, at least, than in another one of ten; relative.
  [[nodiscard]] double drift() const;
};

class Campaign {
 public:
  // As a race has them.
  Campaign(CampaignOptions options, measure::Instruments instruments);

  // Until all cells are done, the time is used up, or stop() says so. May be called again with more cells.
  void run(const std::vector<Cell>& cells);

  // Measures every cell so far once more: what a machine does now and then differs from one minute to the next.
  void again();

  // Of all cells so far, those of an earlier run as well.
  [[nodiscard]] const std::vector<CellResult>& results() const { return results_; }
  [[nodiscard]] const CampaignFigures& figures() const { return figures_; }
  [[nodiscard]] double seconds_left() const;

 private:
  // work(cell, ground, seconds) for each cell, as long as there is time.
  template <class Work>
  void visit(const std::vector<Cell>& cells, const Work& work);
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
