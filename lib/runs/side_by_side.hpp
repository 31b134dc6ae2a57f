// Runs several mechanisms of one structure in the lanes of a tile. A mechanism that cannot keep step (its step must be
// halved, or it reaches a limit) continues alone by a Simulator; the others go on.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assur/report.hpp"
#include "runs/bound_members.hpp"
#include "runs/row_consumers.hpp"
#include "runs/tile.hpp"

namespace assur {

// One mechanism over its times.
struct LaneRun {
  Variant variant;                  // unless it is a bound member
  std::size_t member = 0;           // of BoundMembers
  bool unbound = false;             // true: the member was not bound and has not run, because it must be prepared
  std::span<const double> times;    // the first one is that of the variant
  double* rows = nullptr;           // receives the first `split` rows of results; `beyond` the others
  RowConsumer* consumer = nullptr;  // not null: is given each row, and only the latest one is kept
  std::size_t taken = 0;            // rows that the consumer has
  double* beyond = nullptr;
  std::size_t split = static_cast<std::size_t>(-1);
  std::size_t done = 0;  // rows filled
  Status status;         // ok, the first doubt, or the reason why the run stopped
  double reached = 0;    // last time with a valid posture
  bool alone = false;    // true: it ran alone from the time `alone_from` on
  double alone_from = 0;
  ErrorFigures error;  // estimates; residuals only if it ran alone
  std::vector<Event> events;
  std::vector<std::string> fallbacks;  // fallbacks of the part that it ran alone
  std::string cannot;                  // reason why it could not start; "": it started

  // Posture at the time with index posture_wanted, or at `reached` if the run ends before.
  std::size_t posture_wanted = static_cast<std::size_t>(-1);
  std::vector<double> posture;
  std::vector<double> outputs;     // at `reached`, if `reached` lies between two times of the run
  std::vector<double> uniqueness;  // see Tile::uniqueness(), at the start; if a posture is wanted

  [[nodiscard]] double* row(std::size_t k, std::size_t columns) const {
    if (consumer != nullptr) return rows;
    return k < split ? rows + k * columns : beyond + (k - split) * columns;
  }
};

// Sums and largest errors of the runs of a tile.
struct Totals {
  Counters counters;
  ErrorFigures error;
  Effort effort;
  void merge(const Totals& o);
};

// The mechanisms of one tile.
class SideBySide {
 public:
  // members: null, or those that run() binds instead of taking LaneRun::variant. Throws Error (environment) if a
  // backend of the plan cannot run here.
  SideBySide(const Preparation& prepared, const StepSettings& settings, const BoundMembers* members = nullptr);

  [[nodiscard]] int lanes() const { return tile_.lanes(); }
  [[nodiscard]] const std::vector<std::string>& columns() const { return tile_.columns(); }
  [[nodiscard]] const OutputProgram& outputs() const { return tile_.outputs(); }

  // Runs all lanes. They must have the same number of times, and the same step from each time to the next. `proceed` is
  // called after every step; false stops all. Exceptions from laws and callbacks propagate.
  void run(std::span<LaneRun* const> lanes, const std::function<bool()>& proceed);

  // Runs one mechanism alone, from begin to end.
  void run_alone(LaneRun& run, const std::function<bool()>& proceed);

  [[nodiscard]] Totals totals() const;
  void clear_totals();

 private:
  // Lanes, by their index.
  using Lanes = std::vector<std::size_t>;
  [[nodiscard]] Status start(const Lanes& lanes, std::span<const Variant* const> variants);
  [[nodiscard]] Lanes near_guess(const Lanes& lanes, std::span<const Variant* const> variants) const;
  [[nodiscard]] Lanes started_near(Lanes lanes, std::span<const Variant* const> variants);
  [[nodiscard]] Lanes startable(const Lanes& lanes, std::span<const Variant* const> variants, Lanes& in_tile);
  void assemble(std::vector<LaneRun*>& together, std::vector<Variant>& at);
  [[nodiscard]] std::pair<std::size_t, Status> follow(std::span<LaneRun* const> lanes, std::size_t from,
                                                      const std::function<bool()>& proceed);
  void measure_errors(std::span<LaneRun* const> lanes, std::size_t row);
  void check_accuracy(std::span<LaneRun* const> lanes, std::size_t row);
  void alone(LaneRun& lane, Variant at, std::size_t row, bool to_the_end, const std::function<bool()>& proceed);
  [[nodiscard]] std::optional<Simulator> simulator_of(LaneRun& lane, Variant at) const;
  void write_row(int lane, LaneRun& run, std::size_t row);
  void give_row(LaneRun& run, std::size_t row) const;

  Preparation prepared_;
  StepSettings settings_;
  Tile tile_;
  std::unique_ptr<MemberBinder> binder_;  // null: the variants are given
  Totals of_those_alone_;
  std::vector<double> latest_;  // rows of lanes whose rows are taken
  bool stopped_ = false;
};

// Whole turns, by which the angles of a run continue those of another run. `before` and `here` are rows of both at the
// same time.
class Turns {
 public:
  Turns(const OutputProgram& outputs, const double* before, const double* here);

  // Adds the turns to the angles of a row, and to the sums of angles.
  void add_to(double* row) const;

 private:
  const OutputProgram& outputs_;
  std::vector<std::pair<std::size_t, double>> turns_;  // columns and angles, rad
};

}  // namespace assur
