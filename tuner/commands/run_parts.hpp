// Common parts of runs of one mechanism and of an ensemble.
#pragma once

#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "assur/modes.hpp"
#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "commands/commands.hpp"
#include "commands/run_report.hpp"
#include "measure/step_times.hpp"
#include "output/progress.hpp"
#include "output/replace_file.hpp"

namespace assur::command {

// The output files: (option, file), "" if not requested.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> outputs_of(const RunOptions& options);

// Reads the scene with its options and these parameters. Throws Error (input) if an output file is one of its tables.
[[nodiscard]] Scene scene_of(const Common& common, const RunOptions& options, const Parameters& set);

[[nodiscard]] PrepareOptions how_of(const Common& common, const RunOptions& options);
[[nodiscard]] StepSettings settings_of(const RunOptions& options);

// An observer for run() that shows the progress in `steps` steps and checks for Ctrl-C. If mechanisms run side by side,
// its rows are not single steps, and `times` only decides when to read the clock.
[[nodiscard]] Observer observer(output::Progress& progress, measure::StepTimes& times, std::int64_t steps);

// Prints the page, or the JSON object.
void print(const Common& common, const RunOptions& options, const output::RunSummary& summary);

[[nodiscard]] Exit exit_of(Code code);

// Throws Error (input) if --errors is given and there are no single steps.
void check_errors(const RunOptions& options, const PrepareOptions& how);
// Repeats the motion for --errors and examines every group after each step, so that this does not affect the times of
// the first run. The file has a row for each step and group; unknown values are empty. False if interrupted.
[[nodiscard]] bool write_errors(Simulator& simulator, const RunOptions& options, output::Replacement& csv,
                                output::Progress& progress);

// Repeats the motion for --animate and --picture, step by step and with all points; null: not requested. False if
// interrupted; page and picture then show the motion so far.
[[nodiscard]] bool write_animation(const Prepared& prepared, const Report& report, PrepareOptions how,
                                   const std::vector<ModeChoice>& modes, const RunOptions& options, std::ostream* page,
                                   std::ostream* picture, output::Progress& progress);

// The mechanism in motion, as SVG. Empty for one that cannot be drawn.
[[nodiscard]] std::string moving_picture_of(const Prepared& prepared, const PrepareOptions& how,
                                            const RunOptions& options);

// The page for a scene that cannot be assembled: the guess and the closest posture.
void write_refused(const Scene& scene, const PrepareOptions& how, const std::string& file);

// Runs an ensemble (--ensemble).
int run_ensemble(const Common& common, const RunOptions& options);

}  // namespace assur::command
