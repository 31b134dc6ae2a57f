// What a run of one mechanism and one of an ensemble have in common.
#pragma once

#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "commands/commands.hpp"
#include "commands/errors_csv.hpp"
#include "commands/run_report.hpp"
#include "measure/step_times.hpp"
#include "output/progress.hpp"

namespace assur::command {

// The files that are written: (option, file), "" for those that were not asked for.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> outputs_of(const RunOptions& options);

// The scene with its options, and with these values of parameters. Throws Error (input) if an output is a table of it.
[[nodiscard]] Scene scene_of(const Common& common, const RunOptions& options, const Parameters& set);

[[nodiscard]] PrepareOptions how_of(const Common& common, const RunOptions& options);
[[nodiscard]] StepLimits limits_of(const RunOptions& options);

// Shows how many of `steps` steps are done, and looks for Ctrl-C; for run(). While many run side by side the rows that
// it hears of are not single steps, and `times` only tells when to look at the clock.
[[nodiscard]] Simulator::Observer observer(output::Progress& progress, measure::StepTimes& times, std::int64_t steps);

// The page, or the JSON object.
void print(const Common& common, const RunOptions& options, const output::RunSummary& summary);

[[nodiscard]] Exit exit_of(Code code);

// --errors: throws Error (input) where there are no single steps to look at.
void check_errors(const RunOptions& options, const PrepareOptions& how);
// The motion once more, with a look at every group after each step, so that the times of the first run are not those of
// looking. False if interrupted.
[[nodiscard]] bool write_errors(Simulator& simulator, const RunOptions& options, output::ErrorsCsv& csv,
                                output::Progress& progress);

// The motion of this run once more, step by step and with all points. False if interrupted: the page then shows what
// was reached.
[[nodiscard]] bool write_animation(const Prepared& prepared, const Report& report, PrepareOptions how,
                                   const RunOptions& options, std::ostream& page, output::Progress& progress);

// Where the start posture cannot be assembled: the page with the guess and the closest posture.
void write_refused(const Scene& scene, const PrepareOptions& how, const std::string& file);

// --ensemble.
int run_ensemble(const Common& common, const RunOptions& options);

}  // namespace assur::command
