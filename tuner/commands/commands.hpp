// The commands of `assur`, one file each. They print results to standard output and everything else to standard error,
// and return the exit status. main() catches assur::Error.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assur/curve.hpp"
#include "assur/mjcf.hpp"
#include "assur/performance.hpp"
#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/simulator.hpp"
#include "assur/strategy.hpp"
#include "output/motion_files.hpp"
#include "sweep/design_space.hpp"

namespace assur::command {

enum Exit : int { kDone = 0, kNumerical = 1, kBadInput = 2, kEnvironment = 3, kInterrupted = 130 };

// Options that every command takes.
struct Common {
  bool json = false;                          // standard output is a single JSON object
  bool quiet = false;                         // prints results and errors only
  int threads = 0;                            // --threads N: largest number; 0: budget of the machine
  std::string db;                             // --db FILE: the only tuning database
  Parameters set;                             // --set name=value
  std::vector<std::filesystem::path> tables;  // --tables FOLDER: further folders for tables of scenes
  ModelOptions model;                         // --key NAME, --drive JOINT=LAW, for a model of MuJoCo
};

struct ImportOptions {
  std::string file;  // the model
  std::string out;   // the scene; empty: not written
};

struct InspectOptions {
  std::string scene;
  std::vector<std::string> outputs;  // empty: those of the scene
  Formulation formulation = Formulation::groups;
  bool range = false;
  std::string driver = {};  // the driver whose range is shown; empty: the only driver
  bool modes = false;       // shows the assembly modes of all groups instead
  std::string write = {};   // file for the scene; empty: not written
};

// The assembly modes in which a motion starts.
struct ModeOptions {
  std::vector<std::pair<std::string, std::size_t>> modes;            // group (empty: the only one), number
  std::vector<std::pair<std::string, std::vector<double>>> guesses;  // point, place in m

  [[nodiscard]] bool empty() const { return modes.empty() && guesses.empty(); }
};

struct RunOptions {
  std::string scene;
  ModeOptions start_modes;
  std::optional<double> start, dt;    // s; empty: those of the scene
  std::optional<std::int64_t> steps;  // empty: up to the end of the scene
  std::vector<std::string> outputs;   // empty: those of the scene
  std::string strategy = "auto";
  std::vector<std::string> without;  // backends that `auto` leaves out
  bool no_machine_code = false;      // not PrepareOptions::machine_code
  std::optional<Mode> mode;          // empty: throughput for an ensemble or a strategy with chunks, else latency
  std::string ensemble;              // CSV of parameters, a row for each member; empty: no ensemble
  double accuracy = 0;               // PrepareOptions::accuracy
  int iterations = 0;                // StepSettings::iterations
  output::MotionFileNames motion;
  NpyOptions motion_how;  // of --npy and --hdf5
  std::string errors;     // CSV with the errors of each group in each step; empty: none
  std::string animate;    // a page on which the mechanism moves; empty: none
  std::string picture;    // the mechanism in motion, as SVG; empty: none
  std::string plot;       // the outputs over time, as SVG; empty: none
  bool reference = false;
  bool certify = false;
  bool pin = false;  // keeps each thread on its own core
};

struct SweepOptions {
  std::string scene;
  std::vector<std::string> outputs;  // empty: those of the scene
  std::vector<sweep::Range> vary;
  sweep::Sampler sampler = sweep::Sampler::random;
  std::int64_t samples = 0;  // of the whole design space
  std::uint64_t seed = 0;
  std::optional<std::pair<std::int64_t, std::int64_t>> range;  // samples from the first up to, without, the second
  std::vector<std::string> reduce = {"min", "max"};            // figures of each output
  std::int64_t best = 0;                                       // samples to list: those with the smallest first figure
  std::string strategy = "auto";
  std::string target;               // CSV with a curve to compare paths with; empty: none
  std::string trace;                // the point whose path is compared; empty: the last joint of linkages, or none
  std::string compare = "nearest";  // name of the distance; linkages have shape distances
  std::string out;                  // CSV with a row for each sample
  std::string html;                 // a page with figures over parameters, and the best samples in motion; empty: none
};

struct CompareOptions {
  std::string scene;
  std::vector<std::string> outputs;                                   // empty: those of the scene
  std::optional<std::int64_t> steps;                                  // empty: those of the scene, up to a limit
  std::vector<double> accuracies = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};  // accuracies to ask `auto` for
  std::vector<std::string> strategies;                                // empty: all that make sense
  std::string html;                                                   // empty: no page
};

struct PlanOptions {
  std::string scene;
  std::vector<std::string> outputs;  // empty: those of the scene
  std::string strategy = "auto";
  Mode mode = Mode::latency;
  double accuracy = 0;               // PrepareOptions::accuracy
  std::vector<std::string> without;  // backends
  std::string save;                  // a file for load_plan(); empty: none
  std::string machine;               // beginning of the fingerprint of another machine of the database; empty: this one
};

// A query to the tuning database; all set members together select the samples.
struct DbOptions {
  std::string question;             // "info", "samples", ...
  std::string file;                 // of export or import
  std::string csv;                  // samples: also written to this file
  std::string strategy;             // samples: only strategies that contain this text
  std::optional<std::int32_t> n;    // samples: only this number of unknowns
  std::optional<std::int64_t> run;  // number of a run, as `info` shows it
  std::string machine, library, kernel;
  bool all = false;
};

struct TuneOptions {
  std::string profile = "quick";
  std::optional<double> budget;     // s; empty: that of the profile
  std::vector<std::string> scenes;  // measures only for these scenes; empty: for all
  std::string csv;                  // CSV for the samples; empty: none
  std::string trial;                // hidden option: only tries this strategy
};

struct CheckOptions {
  bool quick = false;               // the fastest cases of each family, with fewer strategies
  std::string only;                 // cases whose names start with this; empty: all
  std::vector<std::string> scenes;  // checks these scenes instead of the suite
};

struct ReportOptions {
  std::string out = "assur-report";  // folder
  bool quick = false;
  std::optional<double> budget;  // s; empty: 150 if quick, else 1,500
  double watts = 0;              // power of the processor, if its energy cannot be read; 0: unknown
  std::string peers;             // CSV of bench/peers/peers.sh to show; empty: none
};

// Throws Error (input) if --threads exceeds the processors that this process may use; warns if it exceeds the budget of
// the machine.
void check_threads(const Common& common);

// Throws Error (input) about an option.
[[noreturn]] void refuse(const std::string& option, const std::string& what);

// Throws Error (input) if an output (option, file) is also an input, a tuning database, or another output. "" and "-"
// are not files.
void refuse_overwriting(const Common& common, const std::vector<std::pair<std::string, std::string>>& outputs,
                        const std::vector<std::string>& inputs);

// The same for the tables of a scene, which are known after reading it. To be called before anything is written.
void refuse_overwriting(const std::vector<std::pair<std::string, std::string>>& outputs, const Scene& scene);

// The SCENE of a command. moves: refuses a model of MuJoCo whose joints are not driven. Throws Error like open_scene()
// and import_model().
[[nodiscard]] Scene open(const Common& common, const std::string& scene, const Parameters& set, bool moves);

int import_scene(const Common& common, const ImportOptions& options);
int inspect(const Common& common, const InspectOptions& options);
int run(const Common& common, const RunOptions& options);
int sweep(const Common& common, const SweepOptions& options);
// The samples from the first up to, without, the second. Throws Error (input) for a range that there is not.
[[nodiscard]] std::pair<std::int64_t, std::int64_t> range_of(const SweepOptions& options);
// A CSV with the columns x and y.
[[nodiscard]] std::vector<PlanePoint> curve_in(const std::string& file);
int sweep_linkages(const Common& common, const SweepOptions& options);  // sweep of the sample `linkages`
int compare(const Common& common, const CompareOptions& options);
int plan(const Common& common, const PlanOptions& options);
int backends(const Common& common);
int samples(const Common& common);
int db(const Common& common, const DbOptions& options);
int check(const Common& common, const CheckOptions& options);
int report(const Common& common, const ReportOptions& options);

// The model of this machine: from --db alone, or from all databases. Throws Error (environment) if --db cannot be read.
[[nodiscard]] MachineModel machine_model_of(const Common& common);
// The model of another machine of these databases, and the largest budget of its tuning runs. Throws Error (input) if
// none has a machine whose fingerprint begins like this.
struct OtherMachine {
  MachineModel model;
  ThreadBudget budget;
};
[[nodiscard]] OtherMachine other_machine(const Common& common, const std::string& fingerprint);
int tune(const Common& common, const TuneOptions& options);

}  // namespace assur::command
