// Runs of several mechanisms of one structure in the lanes of a tile. A lane that cannot follow in lockstep (its step
// has to be halved, it reaches a limit) goes on alone, as any other simulation; the others are not held up.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/report.hpp"
#include "side_by_side/tile.hpp"

namespace assur {

// One mechanism over its times.
struct LaneRun {
  Variant variant;
  std::span<const double> times;  // the first one is that of the variant
  double* rows = nullptr;         // of results, filled: `split` of them, the others behind `beyond`
  double* beyond = nullptr;
  std::size_t split = static_cast<std::size_t>(-1);
  std::size_t done = 0;  // rows filled
  Status status;         // ok, why the run stopped, or where it was first in doubt
  double reached = 0;    // last time with a valid posture
  bool alone = false;    // from the time `alone_from` on
  double alone_from = 0;
  ErrorFigures error;  // estimates; where it went alone, residuals, too
  std::vector<Event> events;
  std::vector<std::string> fallbacks;  // where it went alone
  std::string cannot;                  // why it could not be started; empty: it was

  // The posture at one of the times, where somebody wants it, or at `reached` if the run does not get there.
  std::size_t posture_wanted = static_cast<std::size_t>(-1);
  std::vector<double> posture;
  std::vector<double> outputs;     // at `reached`, where that is no row
  std::vector<double> uniqueness;  // at the start, see Tile

  [[nodiscard]] double* row(std::size_t k, std::size_t columns) const {
    return k < split ? rows + k * columns : beyond + (k - split) * columns;
  }
};

// What the runs of a tile add up to.
struct Totals {
  Counters counters;
  ErrorFigures error;
  Effort effort;
  void merge(const Totals& o);
};

class SideBySide {
 public:
  // Throws Error (environment) if a backend of the plan cannot run here.
  SideBySide(const Prepared& prepared, const StepLimits& limits)
      : prepared_(prepared), limits_(limits), tile_(prepared, limits) {}

  [[nodiscard]] int lanes() const { return tile_.lanes(); }
  [[nodiscard]] const std::vector<std::string>& columns() const { return tile_.columns(); }
  [[nodiscard]] const OutputProgram& outputs() const { return tile_.outputs(); }

  // All of them have the same number of times and, the n-th from the (n-1)-th, the same steps. `proceed` is asked
  // after every step; false stops all. What laws and callbacks throw passes through.
  void run(std::span<LaneRun* const> lanes, const std::function<bool()>& proceed);

  // All of one run, apart from any other.
  void run_alone(LaneRun& run, const std::function<bool()>& proceed);

  [[nodiscard]] Totals totals() const;
  void clear_totals();

 private:
  [[nodiscard]] std::size_t follow(std::span<LaneRun* const> lanes, std::size_t from,
                                   const std::function<bool()>& proceed);
  void measure_errors(std::span<LaneRun* const> lanes, std::size_t row);
  void check_accuracy(std::span<LaneRun* const> lanes, std::size_t row);
  void alone(LaneRun& lane, Variant at, std::size_t row, bool to_the_end, const std::function<bool()>& proceed);
  [[nodiscard]] std::optional<Simulator> simulator_of(LaneRun& lane, Variant at) const;
  void write_row(int lane, LaneRun& run, std::size_t row);

  Prepared prepared_;
  StepLimits limits_;
  Tile tile_;
  Totals of_those_alone_;
  bool stopped_ = false;
};

// Adds whole turns to the angles of a run, from a row on, so that they follow those of the row `before`, which is of
// the same time as `here`.
void shift_by_turns(const OutputProgram& outputs, const double* before, const double* here, LaneRun& run,
                    std::size_t from, std::size_t columns);

}  // namespace assur
