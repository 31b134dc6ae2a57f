// Ensembles: many variants of one mechanism over the same times, side by side in SIMD lanes and on threads.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/rows.hpp"
#include "assur/simulator.hpp"

namespace assur {

class BoundMembers;  // for use inside the library

// Results of an ensemble in SI units, contiguous [member][time][output]. Rows that a member did not reach are NaN.
// Members are counted from 0. Indices are not checked. Copies share the values; spans are valid as long as one exists.
class EnsembleTrajectory {
 public:
  // Names of the outputs: "C.x", "C.vx", "angle.rate", ... (docs/scenes.md lists all kinds)
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  // Times of the rows, s; the same for all members.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  // Number of members, including those that could not start.
  [[nodiscard]] std::size_t members() const { return rows_.size(); }
  // Number of rows that a member reached; 0 if it could not start.
  [[nodiscard]] std::size_t rows(std::size_t member) const { return rows_[member]; }
  // All outputs of a member at times()[k].
  [[nodiscard]] std::span<const double> row(std::size_t member, std::size_t k) const {
    return {values_.get() + (member * times_.size() + k) * columns_.size(), columns_.size()};
  }
  // One output of a member at times()[row].
  [[nodiscard]] double operator()(std::size_t member, std::size_t row, std::size_t column) const {
    return this->row(member, row)[column];
  }
  // All values: members x times x columns.
  [[nodiscard]] std::span<const double> values() const {
    return {values_.get(), rows_.size() * times_.size() * columns_.size()};
  }

 private:
  friend class Ensemble;
  std::vector<std::string> columns_;
  std::vector<double> times_;
  std::vector<std::size_t> rows_;
  // Uninitialised memory, placed by the first thread that writes it.
  std::shared_ptr<double[]> values_;
};

// One column of a member over the rows that it reached. SI units. All figures are NaN if there are no rows; `minimum`,
// `maximum` and `mean` are NaN if a row is NaN.
struct ColumnSummary {
  static constexpr double kNoRows = std::numeric_limits<double>::quiet_NaN();
  double minimum = kNoRows, maximum = kNoRows;            // over the rows, not between them
  double minimum_time = kNoRows, maximum_time = kNoRows;  // s: the first row with this value
  double mean = kNoRows;                                  // of the rows, each with the same weight
  double last = kNoRows;                                  // in the last row

  [[nodiscard]] double range() const { return maximum - minimum; }
};

// Summaries of the members of an ensemble, whose rows are not stored. Indices are not checked.
class EnsembleSummary {
 public:
  // The columns that are summarised.
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  // Number of members, including those that could not start.
  [[nodiscard]] std::size_t members() const { return rows_.size(); }
  // Number of rows that a member reached; 0 if it could not start.
  [[nodiscard]] std::size_t rows(std::size_t member) const { return rows_[member]; }
  // The summary of columns()[column] of a member.
  [[nodiscard]] const ColumnSummary& operator()(std::size_t member, std::size_t column) const {
    return values_[member * columns_.size() + column];
  }

 private:
  friend class Ensemble;
  std::vector<std::string> columns_;
  std::vector<std::size_t> rows_;
  std::vector<ColumnSummary> values_;  // members x columns
};

// Writes a CSV with the columns `member` (counted from 1), `t` and all outputs. Each number is the shortest text that
// reads back as the same double; NaN is empty. Rows that a member did not reach are left out. If writing
// fails, the state of `out` says so.
void write_csv(std::ostream& out, const EnsembleTrajectory& trajectory);

// Writes NumPy's format .npy like write_npy() of a Trajectory: an array of members x rows, with the fields `t` and all
// outputs. In rows that a member did not reach the outputs are NaN.
void write_npy(std::ostream& out, const EnsembleTrajectory& trajectory, const NpyOptions& options = {});

// Runs the members of an ensemble. Threads may use ensembles as they use simulators: each ensemble serves one thread at
// a time, and different ensembles share no data that changes. After a fork(), both processes may use those ensembles
// that were not running. References that an ensemble returns are valid until its next run.
class Ensemble {
 public:
  // The end of one member.
  struct Outcome {
    // ok, `inaccurate` (the member arrived nevertheless), or the reason why it stopped. Of a member that could not
    // start it is not_assembled, or singular if its posture has no velocities: `cannot` gives the reason.
    Status status;
    double reached = 0;         // last time with a valid posture, s
    std::string cannot;         // reason why the member could not start; "": it started
    bool alone = false;         // true if it ran apart from the others, because it could not keep step with them
    double alone_from = 0;      // the time from which it ran alone, s; set if `alone`
    std::vector<Event> events;  // events of this member
  };

  // `member` prepares the i-th variant, i = 0, 1, ...; the constructor calls it in this order on the calling thread. An
  // Error of kind input or numerical that it throws becomes the outcome of that member; if no member can be prepared,
  // the constructor throws the first of these errors. Other exceptions propagate. In an ensemble, controlled drivers
  // follow their laws. The first member that can be prepared gives the plan: W members (Plan::lanes) run in the lanes
  // of a pack, and P threads (RunSettings::threads) take packs in turn. Members of another structure share packs among
  // themselves, by the plan of the first of them; a member whose structure no other one has runs alone. So does a
  // member with another start time, which first moves from its own start posture to the first of the times. Members
  // with callbacks run alone as well, unless they are copies of one Prepared. A member whose outputs differ from those
  // of the first cannot take part. Throws Error: input for no members, for settings as in Simulator, and for a deadline
  // among them; environment if a backend of the plan cannot run here.
  Ensemble(std::size_t members, const std::function<Prepared(std::size_t)>& member, StepSettings settings = {});
  // The members are rows of a table: `scene` with other values of its parameters and numbers, as by
  // Scene::with_values(). values[i * names.size() + k] is the value of names[k] in the i-th member. No scene is made
  // for a member: how its numbers follow from the values is recorded once and repeated in the lanes in which members
  // run. Groups that no driver moves are solved there, too, once for each member and run. Start postures are assembled
  // there, too, from the guesses that the values give; parts of the mechanism that no output depends on may be left out
  // of this. Members whose start posture does not follow from the guess group by group, or whose equations differ from
  // those of the first member, are prepared one by one when they run, and so are all members of a scene with redundant
  // equations or functions of the program, and of a table of ratios; report().fallbacks then gives their number and the
  // reason. All members use the time grid of prepared(). `options` as in prepare(); otherwise as above, but if no
  // member can be prepared, the outcomes tell why: the constructor then throws only if the scene as written is refused,
  // too, for another reason than its posture. Throws Error (input) also for an unknown or repeated name, and for values
  // that do not make whole rows. Needs the library assur::assur.
  Ensemble(const Scene& scene, std::vector<std::string> names, std::vector<double> values,
           const PrepareOptions& options = {}, StepSettings settings = {});
  Ensemble(Ensemble&&) noexcept;             // the other ensemble may then only be destroyed or assigned to
  Ensemble& operator=(Ensemble&&) noexcept;  // the other ensemble may then only be destroyed or assigned to
  ~Ensemble();

  // Replaces the table of values, and with it the members; their number may change. prepared() stays. This takes no
  // time, unless a name whose value was the same in all members gets another one. Throws Error (input), and changes
  // nothing, if the values do not make whole rows, or if the constructor had no table.
  void bind(std::vector<double> values);

  // Runs all members over the time grid of prepared(). The results are bitwise identical for every number of
  // threads; the number of lanes may change their last bits (docs/strategies.md says when). The calling thread calls
  // `observer` (rows done, rows in all; of all members), which may return true to stop. All threads of the plan call
  // laws and callbacks. Exceptions from them and from the observer propagate. Throws Error (environment) if there is no
  // memory for the results.
  EnsembleTrajectory run(const Observer& observer = {});
  // The same over `times` (s), which begin with prepared().time.start. Throws also Error (input) if `times` are empty,
  // begin at another time, descend, or are not finite.
  EnsembleTrajectory run(std::span<const double> times, const Observer& observer = {});
  // The same, and keeps these columns only, in this order; each row is that of run(), bit by bit. Throws also Error
  // (input) for an unknown column.
  EnsembleTrajectory run(const std::vector<std::string>& columns, const Observer& observer = {});
  // The same over `times` (s).
  EnsembleTrajectory run(const std::vector<std::string>& columns, std::span<const double> times,
                         const Observer& observer = {});

  // Runs all members as run() does, and keeps summaries of these columns instead of rows: the memory does not grow with
  // the number of times. Figures are those of the rows of run(), bit by bit. Throws as run(), and Error (input) for an
  // unknown column.
  EnsembleSummary summarize(const std::vector<std::string>& columns, const Observer& observer = {});
  // The same over `times` (s).
  EnsembleSummary summarize(const std::vector<std::string>& columns, std::span<const double> times,
                            const Observer& observer = {});

  // Runs all members as run() does, and gives rows to `sink` instead of keeping them: all rows of a member when it is
  // done, or block by block. All threads of the plan call the sink, each for members of its own; the blocks of a member
  // come in their order. A member that reached no row gives none; outcomes() tells why. Rows are those of run(), bit by
  // bit. Exceptions from the sink propagate. Throws as run(), and Error (input) for an unknown column, an empty sink,
  // or a number that is 0 in `selection`.
  void stream(const RowSelection& selection, const RowSink& sink, const Observer& observer = {});
  // The same over `times` (s).
  void stream(const RowSelection& selection, const RowSink& sink, std::span<const double> times,
              const Observer& observer = {});

  // Number of members, including those that cannot start.
  [[nodiscard]] std::size_t members() const;
  // Names of the outputs, as in EnsembleTrajectory::columns().
  [[nodiscard]] const std::vector<std::string>& columns() const;
  // The first member that could be prepared, with one chunk; of a table perhaps the scene as written. Throws Error
  // (numerical) if neither can be assembled.
  [[nodiscard]] Prepared prepared() const;
  [[nodiscard]] const TimeGrid& time() const;  // the time grid of prepared()
  // The last run: sums and largest errors of all members; before the first run it is empty. The status is that of the
  // first member that failed, else of the first inaccurate one; its place is that member. `reached` is the smallest of
  // all members.
  [[nodiscard]] const Report& report() const;
  // The last run: the end of each member. Empty before the first run.
  [[nodiscard]] const std::vector<Outcome>& outcomes() const;

 private:
  explicit Ensemble(std::unique_ptr<BoundMembers> members, StepSettings settings);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace assur
