// Work-precision comparison of one scene: true error and time of many ways to run it.
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

// One way with its results.
struct WorkPrecisionRow {
  std::string strategy;               // a text, or the choice of `auto` class by class
  int iterations = 0;                 // fixed number; 0: until convergence
  std::optional<Knob> knob;           // empty: the choice of `auto`
  std::vector<double> accuracies;     // accuracies that gave this run; 0: as exact as doubles allow
  std::vector<double> picked;         // accuracies among them for which `auto` chose it
  std::string status = "ok";          // or the name of a Code, or the reason why it cannot run
  std::optional<ForwardError> error;  // empty: failed, or without reference
  std::optional<double> estimated;    // largest estimate; empty: none
  std::optional<double> seconds;      // of one step, median; empty: failed, or interrupted
  double spread = 0;                  // median absolute deviation, s
  std::size_t rounds = 0;
  bool on_front = false;

  // The largest of the three errors; NaN if unknown.
  [[nodiscard]] double worst_error() const;
  [[nodiscard]] Trade trade() const;
};

struct WorkPrecision {
  std::vector<WorkPrecisionRow> rows;  // the fastest first, rows without a time last
  std::int64_t steps = 0;              // compared steps
  bool interrupted = false;
  std::string no_yardstick;  // reason why true errors are unknown; "": they are known

  // Regret of `auto` for this accuracy: its time over that of the fastest way that reaches the accuracy, less 1. Empty
  // if `auto` misses the accuracy, or if times or errors are missing.
  [[nodiscard]] std::optional<double> behind(double accuracy) const;
  // The fastest row with at most this error; null if there is none.
  [[nodiscard]] const WorkPrecisionRow* fastest_within(double error) const;
  // The row of the choice of `auto`; null if it could not run.
  [[nodiscard]] const WorkPrecisionRow* pick(double accuracy) const;
};

struct WorkPrecisionOptions {
  std::vector<double> accuracies;  // accuracies to ask for, each > 0
  // Strategies to compare with `auto`, each with every accuracy. Empty: all solvers, and variations of the fastest.
  std::optional<std::vector<Strategy>> strategies = {};
  ThreadBudget budget;
  std::shared_ptr<const PerformanceModel> model = nullptr;  // null: machine_model()
  RaceRules rules;                                          // rules of the last race
  std::function<void(std::int64_t done, std::int64_t of)> progress = {};
  Instruments instruments = {};
};

// The scene with at most this many steps of its grid.
[[nodiscard]] Scene first_steps(const Scene& scene, std::int64_t most);

// Runs every way over the whole grid and compares its motion with the one in quadruple precision; then times all ways
// in turns. `auto`, each strategy and each predictor are run with every accuracy; runs with fixed iterations ignore it.
// Throws Error: input for a grid without steps, environment if a given strategy cannot run here.
[[nodiscard]] WorkPrecision work_precision(const Scene& scene, const WorkPrecisionOptions& options);

}  // namespace assur::measure
