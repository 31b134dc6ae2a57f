// Error against run time of one scene: many ways to run it, the true error of each, and their times beside each other.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "measure/pareto.hpp"
#include "measure/race.hpp"
#include "measure/ways.hpp"

namespace assur::measure {

// One way and what came of it.
struct WorkPrecisionRow {
  std::string strategy;               // a text, or class by class what `auto` took
  int iterations = 0;                 // fixed; 0: as many as convergence takes
  std::optional<Knob> knob;           // empty: none, it is what `auto` took
  std::vector<double> accuracies;     // that were asked for: all for which it did just this; 0: as exact as doubles are
  std::vector<double> picked;         // of these: those for which `auto` took it
  std::string status = "ok";          // or the name of a Code, or why it cannot run
  std::optional<ForwardError> error;  // empty: failed, or there is no yardstick
  std::optional<double> estimated;    // the worst of the estimates; empty: nobody made one
  std::optional<double> seconds;      // of one step, median; empty: failed, or interrupted
  double spread = 0;                  // of seconds: median absolute deviation
  std::size_t rounds = 0;
  bool on_front = false;

  // The worst of the three; NaN if not known.
  [[nodiscard]] double worst_error() const;
  [[nodiscard]] Trade trade() const;
};

struct WorkPrecision {
  std::vector<WorkPrecisionRow> rows;  // the fastest first, those without a time last
  std::int64_t steps = 0;              // that were compared
  bool interrupted = false;
  std::string no_yardstick;  // why nothing is known of true errors; empty: it is

  // What `auto` lost for this accuracy: its time over that of the fastest way which reaches it, less 1. Empty if not
  // even its own does, or times or errors are missing.
  [[nodiscard]] std::optional<double> behind(double accuracy) const;
  // The fastest row with at most this error; null if there is none.
  [[nodiscard]] const WorkPrecisionRow* fastest_within(double error) const;
  // The row that `auto` took; null if it could not.
  [[nodiscard]] const WorkPrecisionRow* pick(double accuracy) const;
};

struct WorkPrecisionOptions {
  std::vector<double> accuracies;  // to ask for, each > 0
  // Each with every accuracy, beside `auto`; left out: all solvers, and every knob of the fastest.
  std::optional<std::vector<Strategy>> strategies = {};
  ThreadBudget budget;
  std::shared_ptr<const PerformanceModel> model = nullptr;  // null: machine_model()
  RaceRules rules;                                          // of the race of all
  std::function<void(std::int64_t done, std::int64_t of)> progress = {};
  Instruments instruments = {};
};

// The scene with at most so many steps of its grid.
[[nodiscard]] Scene first_steps(const Scene& scene, std::int64_t most);

// Every way is run over the whole grid first, and its motion compared with the one in quad precision; only then it is
// timed, in turns with all others. Accuracies are asked of `auto` and of each strategy and predictor; fixed iterations
// do not heed them. Throws Error: input for a grid without steps, environment if a strategy that is asked for cannot
// run here.
[[nodiscard]] WorkPrecision work_precision(const Scene& scene, const WorkPrecisionOptions& options);

}  // namespace assur::measure
