// The commands of `assur`, one file each. They print to standard output, or to standard error what is no result, and
// return the exit status; assur::Error is caught by main().
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assur/performance.hpp"
#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"

namespace assur::command {

enum Exit : int { kDone = 0, kNumerical = 1, kBadInput = 2, kEnvironment = 3, kInterrupted = 130 };

// Options that every command takes.
struct Common {
  bool json = false;                          // standard output is one JSON object and nothing else
  bool quiet = false;                         // nothing but results and errors
  int threads = 0;                            // --threads N, at most; 0: as many as the machine's budget
  std::string db;                             // --db FILE: this tuning database and no other
  Parameters set;                             // --set name=value
  std::vector<std::filesystem::path> tables;  // --tables FOLDER: tables of scenes may lie there, too
};

struct InspectOptions {
  std::string scene;
  std::vector<std::string> outputs;  // empty: those of the scene
  Formulation formulation = Formulation::groups;
};

struct RunOptions {
  std::string scene;
  std::optional<double> start, dt;    // s; those of the scene if left out
  std::optional<std::int64_t> steps;  // left out: up to the scene's end
  std::vector<std::string> outputs;   // empty: those of the scene
  std::string strategy = "auto";
  std::vector<std::string> without;  // backends that `auto` leaves out
  std::optional<Mode> mode;          // left out: throughput where the ensemble or the strategy asks for it
  std::string ensemble;              // a CSV of parameters, one member a row; empty: the scene alone
  double accuracy = 0;               // PrepareOptions::accuracy
  int iterations = 0;                // 0: as many as convergence takes
  std::string csv;                   // "-": standard output; empty: none
  std::string errors;                // a CSV of each group in each step; empty: none
  std::string animate;               // a page on which the mechanism moves; empty: none
  std::string plot;                  // the outputs over time, as SVG; empty: none
  bool reference = false;
  bool certify = false;
  bool pin = false;  // each thread on a core of its own
};

struct CompareOptions {
  std::string scene;
  std::vector<std::string> outputs;                                   // empty: those of the scene
  std::optional<std::int64_t> steps;                                  // left out: those of the scene, within reason
  std::vector<double> accuracies = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};  // that `auto` is asked for
  std::vector<std::string> strategies;                                // empty: all that are worth it
  std::string html;                                                   // empty: no page
};

struct PlanOptions {
  std::string scene;
  std::vector<std::string> outputs;  // empty: those of the scene
  Mode mode = Mode::latency;
  double accuracy = 0;               // PrepareOptions::accuracy
  std::vector<std::string> without;  // backends
  std::string save;                  // a file for load_plan(); empty: none
};

// What to ask the tuning database, and of which samples: those that fit all that is set.
struct DbOptions {
  std::string question;             // "info", "samples", ...
  std::string file;                 // of export and import
  std::optional<std::int64_t> run;  // its number, as info shows it
  std::string machine, library, kernel;
  bool all = false;
};

struct TuneOptions {
  std::string profile = "quick";
  std::optional<double> budget;     // s, instead of the profile's
  std::vector<std::string> scenes;  // sample only what these need; empty: everything
  std::string csv;                  // write the samples here, too; empty: nowhere
  std::string trial;                // hidden: try this strategy, and nothing else
};

struct CheckOptions {
  bool quick = false;               // the fastest cases of each family, with fewer strategies
  std::string only;                 // cases whose names begin so; empty: all
  std::vector<std::string> scenes;  // these instead of the suite's own cases
};

struct ReportOptions {
  std::string out = "assur-report";  // folder
  bool quick = false;
  std::optional<double> budget;  // s; left out: 150 if quick, else 1,500
  double watts = 0;              // of the processor, for energy that cannot be read; 0: not known
  std::string peers;             // a CSV of bench/peers/peers.sh, to be shown; empty: none
};

// Throws Error (input) for --threads beyond the processors that this process may use; warns beyond the machine's
// budget.
void check_threads(const Common& common);

// Throws Error (input) for an output (option, file) that is one of the inputs, one of the tuning databases that are
// read, or another output. "" and "-" are none.
void refuse_overwriting(const Common& common, const std::vector<std::pair<std::string, std::string>>& outputs,
                        const std::vector<std::string>& inputs);

// The same for the tables of a scene, which are known once it was read. Asked before anything is written.
void refuse_overwriting(const std::vector<std::pair<std::string, std::string>>& outputs, const Scene& scene);

int inspect(const Common& common, const InspectOptions& options);
int run(const Common& common, const RunOptions& options);
int compare(const Common& common, const CompareOptions& options);
int plan(const Common& common, const PlanOptions& options);
int backends(const Common& common);
int db(const Common& common, const DbOptions& options);
int check(const Common& common, const CheckOptions& options);
int report(const Common& common, const ReportOptions& options);

// What is known of this machine: from --db alone, which throws Error (environment) if it cannot be read, else from all
// databases.
[[nodiscard]] MachineModel machine_model_of(const Common& common);
int tune(const Common& common, const TuneOptions& options);

}  // namespace assur::command
