#include "commands/command_line.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "assur/version.hpp"
#include "commands/option_values.hpp"
#include "sweep/sweep.hpp"

namespace assur::options {
namespace {

using namespace command;

// The options that follow are declared in the order of the help.

template <class T>
CLI::Option* add(CLI::App& app, const std::string& name, T& value, const std::string& what, const std::string& type,
                 const CLI::Validator& check = {}) {
  return app.add_option(name, value, what)->check(check)->type_name(type);
}

CLI::Option* add_file(CLI::App& app, const std::string& name, std::string& file, const std::string& what,
                      const std::string& type = "FILE", const std::string& expected = "expects a file name") {
  return add(app, name, file, what, type,
             CLI::Validator([expected](std::string& text) { return text.empty() ? expected : ""; }, ""));
}

using Take = std::function<void(const std::string& text)>;

// An option whose text is read by `take`.
CLI::Option* add_text(CLI::App& app, const std::string& name, const Take& take, const std::string& what,
                      const std::string& type, const CLI::Validator& check = {}) {
  return app.add_option_function<std::string>(name, take, what)->check(check)->type_name(type);
}

// The same for an option that may be repeated.
void add_texts(CLI::App& app, const std::string& name, const Take& take, const std::string& what,
               const std::string& type) {
  const auto take_all = [take](const std::vector<std::string>& texts) {
    std::for_each(texts.begin(), texts.end(), take);
  };
  app.add_option_function<std::vector<std::string>>(name, take_all, what)->allow_extra_args(false)->type_name(type);
}

void add_names(CLI::App& app, const std::string& name, std::vector<std::string>& names, const std::string& what) {
  add_texts(
      app, name, [&names, name](const std::string& text) { take_names(names, text, name); }, what, "A,B");
}

// One of some names, each with its value.
template <class T, class Value>
CLI::Option* add_choice(CLI::App& app, const std::string& name, T& value,
                        const std::vector<std::pair<std::string, Value>>& choices, const std::string& what) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  const auto take = [&value, choices](const std::string& text) {
    value = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.first == text; })->second;
  };
  return add_text(app, name, take, what, "NAME", one_of(names));
}

void add_common(CLI::App& app, Common& common) {
  app.add_flag("--json", common.json, "Print one JSON object on standard output");
  app.add_flag("--quiet", common.quiet, "Print results and errors only");
  add(app, "--threads", common.threads, "Largest number of threads", "N", whole_number(1));
  add_file(app, "--db", common.db, "Use only this tuning database");
  app.set_help_flag("-h,--help", "Show this help");
  app.set_version_flag("--version", "assur " ASSUR_VERSION, "Show the version");
}

// Adds the options of all commands; these are the last ones of a command. `check` runs when everything is parsed.
template <class Options>
void finish(
    CLI::App& app, Invocation& call, int (*command)(const Common&, const Options&), const Options& options,
    const std::function<void()>& check = [] {}) {
  add_common(app, call.common);
  app.callback([&call, command, &options, check] {
    check();
    call.chosen = [&call, command, &options] { return command(call.common, options); };
  });
}

// Options of all commands that read a scene.
void add_reading(CLI::App& app, Common& common) {
  add_texts(
      app, "--set", [&common](const std::string& text) { take_parameter(common.set, text); },
      "Set a parameter of the scene; may be repeated", "name=value");
  add(app, "--tables", common.tables, "Also look for tables here; may be repeated", "FOLDER",
      CLI::Validator(CLI::ExistingDirectory).description(""))
      ->allow_extra_args(false);
}

// For options in seconds.
CLI::Validator budget() { return number(0, " > 0 and at most 1000000, which are 11 days", 1e6); }

// Options of models of MuJoCo.
void add_model(CLI::App& app, ModelOptions& model) {
  add(app, "--key", model.key, "MuJoCo model: start at this keyframe", "NAME");
  add_texts(
      app, "--drive", [&model](const std::string& text) { take_drive(model.drive, text); },
      "MuJoCo model: drive a joint, e.g. knee=0,1.5", "joint=LAW");
}

void add_scene(CLI::App& app, Common& common, std::string& scene, std::vector<std::string>& outputs) {
  add(app, "SCENE", scene, "Scene file, MuJoCo model, or sample: stewart, ...", "")->required();
  add_names(app, "--outputs", outputs, "Outputs: C, C.velocity, C.vx, angle, ...; or all");
  add_reading(app, common);
  add_model(app, common.model);
}

void add_import(CLI::App& app, Invocation& call) {
  CLI::App& model = *app.add_subcommand("import", "Convert a MuJoCo model to a scene");
  add(model, "FILE", call.model.file, "The model, a file that ends with .xml", "")->required();
  add_file(model, "--out", call.model.out, "Write the scene", "SCENE");
  add_model(model, call.common.model);
  finish(model, call, command::import_scene, call.model);
}

void add_inspect(CLI::App& app, Invocation& call) {
  CLI::App& inspect = *app.add_subcommand("inspect", "Show the kinematic structure of a scene");
  InspectOptions& o = call.inspect;
  add_scene(inspect, call.common, o.scene, o.outputs);
  const CLI::Option* formulation = add_choice<Formulation, Formulation>(
      inspect, "--formulation", o.formulation,
      {{"global", Formulation::global}, {"groups", Formulation::groups}, {"irreducible", Formulation::irreducible}},
      "Use global, groups (default) or irreducible");
  inspect.add_flag("--modes", o.modes, "Show all assembly modes of each group at the start");
  const auto take_driver = [&o](const std::string& name) {
    o.range = true;
    o.driver = name;
  };
  add_text(inspect, "--range", take_driver, "Show how far a driver can go both ways", "DRIVER")->expected(0, 1);
  add_file(inspect, "--write", o.write, "Write the scene to a file, joints as joints");
  finish(inspect, call, command::inspect, o, [&o, formulation] {
    if (o.modes && (!o.outputs.empty() || formulation->count() > 0 || o.range)) {
      throw CLI::ValidationError("--modes", "shows all groups; leave out --outputs, --formulation and --range");
    }
  });
}

template <class ModeOption>  // Mode or std::optional<Mode>
void add_mode(CLI::App& app, ModeOption& mode) {
  add_choice<ModeOption, Mode>(app, "--mode", mode, {{"latency", Mode::latency}, {"throughput", Mode::throughput}},
                               "latency (default), or throughput: many steps at once");
}

void add_accuracy(CLI::App& app, double& value) {
  add(app, "--accuracy", value, "Error allowed in the outputs; 0: smallest possible", "X", accuracy());
}

void add_run(CLI::App& app, Invocation& call) {
  CLI::App& run = *app.add_subcommand("run", "Compute the motion of a scene");
  RunOptions& o = call.run;
  add_scene(run, call.common, o.scene, o.outputs);
  add(run, "--start", o.start, "First time, s", "T", number(-HUGE_VAL, ""));
  add(run, "--dt", o.dt, "Time step, s", "S", number(0, " > 0"));
  add(run, "--steps", o.steps, "Number of steps", "N", whole_number(0));
  add_texts(
      run, "--start-mode", [&o](const std::string& text) { take_mode(o.start_modes.modes, text); },
      "Start in this mode of a group (see inspect --modes)", "[GROUP=]N");
  add_texts(
      run, "--guess", [&o](const std::string& text) { take_guess(o.start_modes.guesses, text); },
      "Start in the mode nearest to this place of a point", "C=X,Y");
  add(run, "--strategy", o.strategy, "Solution strategy: auto (default), groups/klu, ...", "TEXT");
  add_names(run, "--without", o.without, "Backends that auto leaves out: lanes, klu, ...");
  run.add_flag("--no-machine-code", o.no_machine_code, "Steps without machine code, with the same bits");
  add_mode(run, o.mode);
  add_accuracy(run, o.accuracy);
  add_file(run, "--ensemble", o.ensemble, "Run many variants: CSV of parameters, one row each");
  add(run, "--iterations", o.iterations, "Fixed number of Newton iterations (except first level)", "N",
      whole_number(1));
  add_file(run, "--csv", o.motion.csv, "Write the motion; - for standard output");
  add_file(run, "--npy", o.motion.npy, "Write the motion as a NumPy array with named columns", "F.npy");
  add_file(run, "--hdf5", o.motion.hdf5, "Write the motion as HDF5, a data set for each column", "F.h5");
  const CLI::Option* every = add(run, "--every", o.motion_how.every,
                                 "For --npy, --hdf5: every N-th row, from the first", "N", whole_number(1));
  const CLI::Option* single = run.add_flag("--single", o.motion_how.single, "For --npy, --hdf5: in single precision");
  add_file(run, "--errors", o.errors, "Write the errors of each group at each step");
  add_file(run, "--animate", o.animate, "Write a page that animates the mechanism", "F.html");
  add_file(run, "--picture", o.picture, "Draw the mechanism in motion", "F.svg");
  add_file(run, "--plot", o.plot, "Plot the outputs over time", "F.svg");
  run.add_flag("--reference", o.reference, "Compare with a solution in quadruple precision");
  run.add_flag("--certify", o.certify, "Prove bounds for the position errors");
  run.add_flag("--pin", o.pin, "Bind each thread to a core, where it busy-waits");
  finish(run, call, command::run, o, [&call, &o, every, single] {
    for (const CLI::Option* option : {every, single}) {
      if (option->count() > 0 && o.motion.npy.empty() && o.motion.hdf5.empty()) {
        throw CLI::ValidationError(option->get_name(), "chooses rows of --npy or --hdf5; give one of them");
      }
    }
    if (call.common.json && o.motion.csv == "-") {
      throw CLI::ValidationError("--csv", "cannot share standard output with --json; give a file");
    }
  });
}

void take_figures(std::vector<std::string>& figures, const std::string& text) {
  figures.clear();
  take_names(figures, text, "--reduce");
  const std::vector<std::string>& known = sweep::figure_names();
  for (const std::string& name : figures) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    throw CLI::ValidationError("--reduce",
                               "knows min, max, min_time, max_time, mean, last and range, not \"" + name + "\"");
  }
}

void add_sweep(CLI::App& app, Invocation& call) {
  CLI::App& sweep = *app.add_subcommand("sweep", "Compute figures of many designs of a scene");
  SweepOptions& o = call.sweep;
  add_scene(sweep, call.common, o.scene, o.outputs);
  add_texts(
      sweep, "--vary", [&o](const std::string& text) { take_ranges(o.vary, text); },
      "Parameters and ranges (not for the sample linkages)", "a=LOW:HIGH,...");
  add(sweep, "--samples", o.samples, "Number of samples", "N", number(0, " > 0 and at most 1e15", 1e15))->required();
  using sweep::Sampler;
  add_choice<Sampler, Sampler>(sweep, "--sampler", o.sampler,
                               {{"grid", Sampler::grid}, {"random", Sampler::random}, {"sobol", Sampler::sobol}},
                               "Use grid, random (default) or sobol");
  add(sweep, "--seed", o.seed, "Another seed gives other samples (default: 0)", "S");
  add_text(
      sweep, "--range", [&o](const std::string& text) { o.range = sample_range(text); },
      "Only samples from I up to, without, J", "I:J");
  add_text(
      sweep, "--reduce", [&o](const std::string& text) { take_figures(o.reduce, text); },
      "Figures of each output (default: min,max)", "LIST");
  add(sweep, "--best", o.best, "List K samples with the smallest first figure", "K", whole_number(1));
  add(sweep, "--strategy", o.strategy, "Solution strategy: auto (default), groups/lanes:8, ...", "TEXT");
  add(sweep, "--target", o.target, "CSV with columns x,y of a curve to compare paths with", "FILE");
  const CLI::Option* trace =
      add(sweep, "--trace", o.trace, "The point whose path is compared (of linkages the last)", "POINT");
  const CLI::Option* compare =
      add(sweep, "--compare", o.compare, "The distance: nearest (default), timed, fitted or shape", "NAME",
          one_of(sweep::distance_names()));
  add_file(sweep, "--out", o.out, "Write a CSV (linkages: .h5), or continue an earlier one")->required();
  add_file(sweep, "--html", o.html, "Write a page: figures over parameters, best in motion");
  finish(sweep, call, command::sweep, o, [&o, trace, compare] {
    const bool is_of_linkages = o.scene == "linkages" || o.scene.starts_with("linkages:");
    for (const CLI::Option* option : {trace, compare}) {
      if (option->count() == 0 || !is_of_linkages) continue;
      throw CLI::ValidationError(option->get_name(),
                                 "linkages are compared by the path of their last joint and its shape");
    }
  });
}

void add_compare(CLI::App& app, Invocation& call) {
  CLI::App& compare = *app.add_subcommand("compare", "Compare true errors and run times of strategies");
  CompareOptions& o = call.compare;
  add_scene(compare, call.common, o.scene, o.outputs);
  add(compare, "--steps", o.steps, "Number of steps (default: at most 1,000)", "N", whole_number(1));
  add_text(
      compare, "--accuracy", [&o](const std::string& text) { take_accuracies(o.accuracies, text); },
      "Accuracies for auto: 1e-4,1e-6,1e-8,1e-10,1e-12", "LIST");
  add_text(
      compare, "--strategies", [&o](const std::string& text) { take_names(o.strategies, text, "--strategies"); },
      "Only auto and LIST, as groups/klu,irreducible/lanes", "LIST");
  add_file(compare, "--html", o.html, "Write a page with the diagram");
  finish(compare, call, command::compare, o);
}

void add_plan(CLI::App& app, Invocation& call) {
  CLI::App& plan = *app.add_subcommand("plan", "Show which strategy auto chooses, and why");
  PlanOptions& o = call.plan;
  add_scene(plan, call.common, o.scene, o.outputs);
  add(plan, "--strategy", o.strategy, "Show the expected times of this strategy instead", "TEXT");
  add_names(plan, "--without", o.without, "Backends to leave out: lanes, klu, ...");
  add_mode(plan, o.mode);
  add_accuracy(plan, o.accuracy);
  add_file(plan, "--save", o.save, "Write the plan for assur::load_plan()");
  add(plan, "--machine", o.machine, "Plan for this machine: (start of) its fingerprint", "TEXT");
  finish(plan, call, command::plan, o);
}

// A command without options of its own.
void add_list(CLI::App& app, Invocation& call, const char* name, int (*command)(const Common&), const char* what) {
  CLI::App& list = *app.add_subcommand(name, what);
  add_common(list, call.common);
  list.callback([&call, command] { call.chosen = [&call, command] { return command(call.common); }; });
}

// `options`: the question's options, from --run, --machine, --library, --kernel, --all and FILE.
void add_question(CLI::App& db, Invocation& call, const char* name, const char* help,
                  const std::set<std::string>& options) {
  CLI::App& question = *db.add_subcommand(name, help);
  DbOptions& o = call.db;
  const auto takes = [&](const char* option) { return options.count(option) > 0; };
  if (takes("FILE")) add(question, "FILE", o.file, "A tuning database", "")->required();
  if (takes("--run")) {
    add(question, "--run", o.run, "Only the tuning run with this number (see info)", "N", whole_number(1));
  }
  if (takes("--machine")) {
    add(question, "--machine", o.machine, "Only this machine: its fingerprint or start of it", "TEXT");
  }
  if (takes("--csv")) {
    add(question, "--strategy", o.strategy, "Only strategies that contain this text", "TEXT");
    add(question, "-n", o.n, "Only this number of unknowns", "N", whole_number(0));
    add_file(question, "--csv", o.csv, "Write the samples with all their figures");
  }
  if (takes("--library")) {
    add(question, "--library", o.library, "Only samples of this solver library, or of assur", "NAME");
  }
  if (takes("--kernel")) add(question, "--kernel", o.kernel, "Only this kernel: factor, solve, ...", "NAME");
  if (takes("--all")) question.add_flag("--all", o.all, "All samples");
  finish(question, call, command::db, o, [&o, name] { o.question = name; });
}

void add_db(CLI::App& app, Invocation& call) {
  CLI::App& db = *app.add_subcommand("db", "Query and maintain the tuning database");
  db.require_subcommand(1);
  add_question(db, call, "info", "List databases, tuning runs, and samples in use", {});
  add_question(db, call, "samples", "List the samples", {"--run", "--machine", "--library", "--kernel", "--csv"});
  add_question(db, call, "best", "Show the fastest strategy for each shape", {"--machine", "--kernel"});
  add_question(db, call, "crossovers", "Show the sizes at which the fastest strategy changes",
               {"--machine", "--kernel"});
  add_question(db, call, "models", "List the models fitted to the samples", {});
  add_question(db, call, "export", "Copy samples to a new file", {"FILE", "--run", "--machine", "--library"});
  add_question(db, call, "import", "Add the samples of another file", {"FILE"});
  add_question(db, call, "check", "Find damage, and put a damaged database aside", {});
  add_question(db, call, "forget", "Remove samples", {"--run", "--machine", "--library", "--all"});
  add_common(db, call.common);
}

void add_tune(CLI::App& app, Invocation& call) {
  CLI::App& tune = *app.add_subcommand("tune", "Measure this machine, as the basis of all plans");
  TuneOptions& o = call.tune;
  const std::vector<std::string> profiles = {"quick", "standard", "patient"};
  add(tune, "--profile", o.profile, "quick (default, a minute), standard or patient", "NAME", one_of(profiles));
  add(tune, "--budget", o.budget, "Time budget, s", "SECONDS", budget());
  add(tune, "--scene", o.scenes, "Measure only for this scene; may be repeated", "SCENE")->allow_extra_args(false);
  add(tune, "--csv", o.csv, "Also write the samples as CSV", "FILE");
  add_reading(tune, call.common);
  tune.add_option("--trial", o.trial)->group("");  // hidden: for the child process of a trial
  finish(tune, call, command::tune, o);
}

void add_check(CLI::App& app, Invocation& call) {
  CLI::App& check = *app.add_subcommand("check", "Run the stability suite: stiff and extreme cases");
  CheckOptions& o = call.check;
  add(check, "SCENE", o.scenes, "Check these scenes instead, with all strategies", "");
  check.add_flag("--quick", o.quick, "Some cases, fewer strategies: less than a minute");
  add(check, "--case", o.only, "Only cases whose names start with NAME", "NAME");
  add_reading(check, call.common);
  finish(check, call, command::check, o);
}

void add_report(CLI::App& app, Invocation& call) {
  CLI::App& report = *app.add_subcommand("report", "Write the benchmark report: a page, CSV and JSON");
  ReportOptions& o = call.report;
  add_file(report, "--out", o.out, "Output folder (default: assur-report)", "DIR", "expects a folder");
  report.add_flag("--quick", o.quick, "Take at most three minutes instead of thirty");
  add(report, "--budget", o.budget, "Approximate time budget, s", "SECONDS", budget());
  add(report, "--watts", o.watts, "Processor power (TDP), if energy cannot be read", "W", number(0, " > 0"));
  add(report, "--peers", o.peers, "Show other libraries: CSV from bench/peers/peers.sh", "FILE",
      CLI::Validator(CLI::ExistingFile).description(""));
  finish(report, call, command::report, o);
}

}  // namespace

void add_commands(CLI::App& app, Invocation& call) {
  app.require_subcommand(1);
  add_run(app, call);
  add_inspect(app, call);
  add_import(app, call);
  add_list(app, call, "samples", command::samples, "List the mechanisms that can be named instead of a file");
  add_plan(app, call);
  add_sweep(app, call);
  add_compare(app, call);
  add_list(app, call, "backends", command::backends, "List the linear solvers, and why some cannot run");
  add_db(app, call);
  add_tune(app, call);
  add_check(app, call);
  add_report(app, call);
  add_common(app, call.common);
}

}  // namespace assur::options
