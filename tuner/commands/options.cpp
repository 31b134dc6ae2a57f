#include "commands/options.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "assur/version.hpp"
#include "commands/option_values.hpp"
#include "sweep/sweep.hpp"

namespace assur::options {
namespace {

using namespace command;

void add_common(CLI::App& app, Common& common) {
  app.add_flag("--json", common.json, "Print one JSON object on standard output");
  app.add_flag("--quiet", common.quiet, "Print results and errors only");
  app.add_option("--threads", common.threads, "Largest number of threads")->check(whole_number(1))->type_name("N");
  app.add_option_function<std::string>(
         "--db",
         [&common](const std::string& file) {
           if (file.empty()) throw CLI::ValidationError("--db", "expects a file name");
           common.db = file;
         },
         "Use only this tuning database")
      ->type_name("FILE");
  app.set_help_flag("-h,--help", "Show this help");
  app.set_version_flag("--version", "assur " ASSUR_VERSION, "Show the version");
}

// Options of all commands that read a scene.
void add_reading(CLI::App& app, Common& common) {
  app.add_option_function<std::vector<std::string>>(
         "--set",
         [&common](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) take_parameter(common.set, text);
         },
         "Set a parameter of the scene; may be repeated")
      ->allow_extra_args(false)
      ->type_name("name=value");
  app.add_option("--tables", common.tables, "Also look for tables here; may be repeated")
      ->allow_extra_args(false)
      ->check(CLI::Validator(CLI::ExistingDirectory).description(""))
      ->type_name("FOLDER");
}

// For options in seconds.
CLI::Validator budget() { return number(0, " > 0 and at most 1000000, which are 11 days", 1e6); }

void add_names(CLI::App& app, const std::string& option, std::vector<std::string>& names, const std::string& what) {
  app.add_option_function<std::vector<std::string>>(
         option,
         [&names, option](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) take_names(names, text, option);
         },
         what)
      ->allow_extra_args(false)
      ->type_name("A,B");
}

// Options of models of MuJoCo.
void add_model(CLI::App& app, ModelOptions& model) {
  app.add_option("--key", model.key, "MuJoCo model: start at this keyframe")->type_name("NAME");
  app.add_option_function<std::vector<std::string>>(
         "--drive",
         [&model](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) take_drive(model.drive, text);
         },
         "MuJoCo model: drive a joint, e.g. knee=0,1.5")
      ->allow_extra_args(false)
      ->type_name("joint=LAW");
}

void add_scene(CLI::App& app, Common& common, std::string& scene, std::vector<std::string>& outputs) {
  app.add_option("SCENE", scene, "Scene file, MuJoCo model, or sample: stewart, ...")->required()->type_name("");
  add_names(app, "--outputs", outputs, "Outputs: C, C.velocity, C.vx, angle, ...; or all");
  add_reading(app, common);
  add_model(app, common.model);
}

void add_import(CLI::App& app, Invocation& call) {
  CLI::App& model = *app.add_subcommand("import", "Convert a MuJoCo model to a scene");
  model.add_option("FILE", call.model.file, "The model, a file that ends with .xml")->required()->type_name("");
  CLI::Option* out = model.add_option("--out", call.model.out, "Write the scene")->type_name("SCENE");
  add_model(model, call.common.model);
  add_common(model, call.common);
  model.callback([&call, out] {
    if (out->count() > 0 && call.model.out.empty()) throw CLI::ValidationError("--out", "expects a file name");
    call.chosen = [&call] { return command::import_scene(call.common, call.model); };
  });
}

void add_inspect(CLI::App& app, Invocation& call) {
  CLI::App& inspect = *app.add_subcommand("inspect", "Show the kinematic structure of a scene");
  add_scene(inspect, call.common, call.inspect.scene, call.inspect.outputs);
  static const std::map<std::string, Formulation> kFormulations = {
      {"global", Formulation::global}, {"groups", Formulation::groups}, {"irreducible", Formulation::irreducible}};
  CLI::Option* formulation =
      inspect
          .add_option_function<std::string>(
              "--formulation", [&call](const std::string& text) { call.inspect.formulation = kFormulations.at(text); },
              "Use global, groups (default) or irreducible")
          ->check(one_of({"global", "groups", "irreducible"}))
          ->type_name("NAME");
  inspect.add_flag("--modes", call.inspect.modes, "Show all assembly modes of each group at the start");
  inspect
      .add_option_function<std::string>(
          "--range",
          [&call](const std::string& name) {
            call.inspect.range = true;
            call.inspect.driver = name;
          },
          "Show how far a driver can go both ways")
      ->expected(0, 1)
      ->type_name("DRIVER");
  CLI::Option* write = inspect.add_option("--write", call.inspect.write, "Write the scene to a file, joints as joints")
                           ->type_name("FILE");
  add_common(inspect, call.common);
  inspect.callback([&call, formulation, write] {
    if (write->count() > 0 && call.inspect.write.empty()) throw CLI::ValidationError("--write", "expects a file name");
    if (call.inspect.modes && (!call.inspect.outputs.empty() || formulation->count() > 0 || call.inspect.range)) {
      throw CLI::ValidationError("--modes", "shows all groups; leave out --outputs, --formulation and --range");
    }
    call.chosen = [&call] { return command::inspect(call.common, call.inspect); };
  });
}

template <class ModeOption>  // Mode or std::optional<Mode>
void add_mode(CLI::App& app, ModeOption& mode) {
  app.add_option_function<std::string>(
         "--mode", [&mode](const std::string& text) { mode = text == "latency" ? Mode::latency : Mode::throughput; },
         "latency (default), or throughput: many steps at once")
      ->check(one_of({"latency", "throughput"}))
      ->type_name("NAME");
}

void add_accuracy(CLI::App& app, double& value) {
  app.add_option("--accuracy", value, "Error allowed in the outputs; 0: smallest possible")
      ->check(accuracy())
      ->type_name("X");
}

void add_run(CLI::App& app, Invocation& call) {
  CLI::App& run = *app.add_subcommand("run", "Compute the motion of a scene");
  RunOptions& o = call.run;
  add_scene(run, call.common, o.scene, o.outputs);
  run.add_option("--start", o.start, "First time, s")->check(number(-HUGE_VAL, ""))->type_name("T");
  run.add_option("--dt", o.dt, "Time step, s")->check(number(0, " > 0"))->type_name("S");
  run.add_option("--steps", o.steps, "Number of steps")->check(whole_number(0))->type_name("N");
  run.add_option_function<std::vector<std::string>>(
         "--start-mode",
         [&o](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) take_mode(o.start_modes.modes, text);
         },
         "Start in this mode of a group (see inspect --modes)")
      ->allow_extra_args(false)
      ->type_name("[GROUP=]N");
  run.add_option_function<std::vector<std::string>>(
         "--guess",
         [&o](const std::vector<std::string>& texts) {
           for (const std::string& text : texts) take_guess(o.start_modes.guesses, text);
         },
         "Start in the mode nearest to this place of a point")
      ->allow_extra_args(false)
      ->type_name("C=X,Y");
  run.add_option("--strategy", o.strategy, "Solution strategy: auto (default), groups/klu, ...")->type_name("TEXT");
  add_names(run, "--without", o.without, "Backends that auto leaves out: lanes, klu, ...");
  run.add_flag("--no-machine-code", o.no_machine_code, "Steps without machine code, with the same bits");
  add_mode(run, o.mode);
  add_accuracy(run, o.accuracy);
  CLI::Option* ensemble =
      run.add_option("--ensemble", o.ensemble, "Run many variants: CSV of parameters, one row each")->type_name("FILE");
  run.add_option("--iterations", o.iterations, "Fixed number of Newton iterations (except first level)")
      ->check(whole_number(1))
      ->type_name("N");
  CLI::Option* csv =
      run.add_option("--csv", o.motion.csv, "Write the motion; - for standard output")->type_name("FILE");
  CLI::Option* npy = run.add_option("--npy", o.motion.npy, "Write the motion as a NumPy array with named columns");
  npy->type_name("F.npy");
  CLI::Option* hdf5 = run.add_option("--hdf5", o.motion.hdf5, "Write the motion as HDF5, a data set for each column");
  hdf5->type_name("F.h5");
  CLI::Option* every =
      run.add_option("--every", o.motion_how.every, "For --npy, --hdf5: every N-th row, from the first");
  every->check(whole_number(1))->type_name("N");
  CLI::Option* single = run.add_flag("--single", o.motion_how.single, "For --npy, --hdf5: in single precision");
  CLI::Option* errors =
      run.add_option("--errors", o.errors, "Write the errors of each group at each step")->type_name("FILE");
  CLI::Option* animate =
      run.add_option("--animate", o.animate, "Write a page that animates the mechanism")->type_name("F.html");
  CLI::Option* picture = run.add_option("--picture", o.picture, "Draw the mechanism in motion")->type_name("F.svg");
  CLI::Option* plot = run.add_option("--plot", o.plot, "Plot the outputs over time")->type_name("F.svg");
  run.add_flag("--reference", o.reference, "Compare with a solution in quadruple precision");
  run.add_flag("--certify", o.certify, "Prove bounds for the position errors");
  run.add_flag("--pin", o.pin, "Bind each thread to a core, where it busy-waits");
  add_common(run, call.common);
  run.callback([&call, files = std::vector<CLI::Option*>{ensemble, csv, npy, hdf5, errors, animate, picture, plot},
                rows = std::vector<CLI::Option*>{every, single}] {
    for (const CLI::Option* file : files) {
      if (file->count() > 0 && file->results().back().empty()) {
        throw CLI::ValidationError(file->get_name(), "expects a file name");
      }
    }
    for (const CLI::Option* option : rows) {
      if (option->count() > 0 && call.run.motion.npy.empty() && call.run.motion.hdf5.empty()) {
        throw CLI::ValidationError(option->get_name(), "chooses rows of --npy or --hdf5; give one of them");
      }
    }
    if (call.common.json && call.run.motion.csv == "-") {
      throw CLI::ValidationError("--csv", "cannot share standard output with --json; give a file");
    }
    call.chosen = [&call] { return command::run(call.common, call.run); };
  });
}

void add_sweep(CLI::App& app, Invocation& call) {
  CLI::App& sweep = *app.add_subcommand("sweep", "Compute figures of many designs of a scene");
  SweepOptions& o = call.sweep;
  add_scene(sweep, call.common, o.scene, o.outputs);
  sweep
      .add_option_function<std::vector<std::string>>(
          "--vary",
          [&o](const std::vector<std::string>& texts) {
            for (const std::string& text : texts) take_ranges(o.vary, text);
          },
          "Parameters and their ranges (not for the sample linkages)")
      ->allow_extra_args(false)
      ->type_name("a=LOW:HIGH,...");
  sweep.add_option("--samples", o.samples, "Number of samples")
      ->required()
      ->check(number(0, " > 0 and at most 1e15", 1e15))
      ->type_name("N");
  static const std::map<std::string, sweep::Sampler> kSamplers = {
      {"grid", sweep::Sampler::grid}, {"random", sweep::Sampler::random}, {"sobol", sweep::Sampler::sobol}};
  sweep
      .add_option_function<std::string>(
          "--sampler", [&o](const std::string& text) { o.sampler = kSamplers.at(text); },
          "Use grid, random (default) or sobol")
      ->check(one_of({"grid", "random", "sobol"}))
      ->type_name("NAME");
  sweep.add_option("--seed", o.seed, "Another seed gives other samples (default: 0)")->type_name("S");
  sweep
      .add_option_function<std::string>(
          "--range", [&o](const std::string& text) { o.range = sample_range(text); },
          "Only samples from I up to, without, J")
      ->type_name("I:J");
  sweep
      .add_option_function<std::string>(
          "--reduce",
          [&o](const std::string& text) {
            o.reduce.clear();
            take_names(o.reduce, text, "--reduce");
            for (const std::string& name : o.reduce) {
              const std::vector<std::string>& known = sweep::figure_names();
              if (std::find(known.begin(), known.end(), name) == known.end()) {
                throw CLI::ValidationError(
                    "--reduce", "knows min, max, min_time, max_time, mean, last and range, not \"" + name + "\"");
              }
            }
          },
          "Figures of each output (default: min,max)")
      ->type_name("LIST");
  sweep.add_option("--best", o.best, "List K samples with the smallest first figure")
      ->check(whole_number(1))
      ->type_name("K");
  sweep.add_option("--strategy", o.strategy, "Solution strategy: auto (default), groups/lanes:8, ...")
      ->type_name("TEXT");
  sweep.add_option("--target", o.target, "A CSV with the columns x,y of a curve to compare paths with")
      ->type_name("FILE");
  CLI::Option* trace = sweep.add_option("--trace", o.trace, "The point whose path is compared (of linkages the last)");
  trace->type_name("POINT");
  CLI::Option* compare =
      sweep.add_option("--compare", o.compare, "The distance: nearest (default), timed, fitted or shape");
  compare->check(one_of(sweep::distance_names()))->type_name("NAME");
  CLI::Option* out =
      sweep.add_option("--out", o.out, "Write a CSV (of linkages: an .h5 file); an earlier one is continued")
          ->required();
  out->type_name("FILE");
  CLI::Option* html =
      sweep.add_option("--html", o.html, "Write a page: figures over parameters, and the best in motion");
  html->type_name("FILE");
  add_common(sweep, call.common);
  sweep.callback([&call, out, html, trace, compare] {
    const std::string& scene = call.sweep.scene;
    const bool is_of_linkages = scene == "linkages" || scene.starts_with("linkages:");
    for (const CLI::Option* option : {trace, compare}) {
      if (option->count() == 0 || !is_of_linkages) continue;
      throw CLI::ValidationError(option->get_name(),
                                 "linkages are compared by the path of their last joint and its shape");
    }
    if (out->count() > 0 && call.sweep.out.empty()) throw CLI::ValidationError("--out", "expects a file name");
    if (html->count() > 0 && call.sweep.html.empty()) throw CLI::ValidationError("--html", "expects a file name");
    call.chosen = [&call] { return command::sweep(call.common, call.sweep); };
  });
}

void add_compare(CLI::App& app, Invocation& call) {
  CLI::App& compare = *app.add_subcommand("compare", "Compare true errors and run times of strategies");
  CompareOptions& o = call.compare;
  add_scene(compare, call.common, o.scene, o.outputs);
  compare.add_option("--steps", o.steps, "Number of steps (default: at most 1,000)")
      ->check(whole_number(1))
      ->type_name("N");
  compare
      .add_option_function<std::string>(
          "--accuracy", [&o](const std::string& text) { take_accuracies(o.accuracies, text); },
          "Accuracies for auto: 1e-4,1e-6,1e-8,1e-10,1e-12")
      ->type_name("LIST");
  compare
      .add_option_function<std::string>(
          "--strategies", [&o](const std::string& text) { take_names(o.strategies, text, "--strategies"); },
          "Only auto and LIST, as groups/klu,irreducible/lanes")
      ->type_name("LIST");
  CLI::Option* html = compare.add_option("--html", o.html, "Write a page with the diagram")->type_name("FILE");
  add_common(compare, call.common);
  compare.callback([&call, html] {
    if (html->count() > 0 && call.compare.html.empty()) {
      throw CLI::ValidationError("--html", "expects a file name");
    }
    call.chosen = [&call] { return command::compare(call.common, call.compare); };
  });
}

void add_plan(CLI::App& app, Invocation& call) {
  CLI::App& plan = *app.add_subcommand("plan", "Show which strategy auto chooses, and why");
  add_scene(plan, call.common, call.plan.scene, call.plan.outputs);
  add_names(plan, "--without", call.plan.without, "Backends to leave out: lanes, klu, ...");
  add_mode(plan, call.plan.mode);
  add_accuracy(plan, call.plan.accuracy);
  CLI::Option* save =
      plan.add_option("--save", call.plan.save, "Write the plan for assur::load_plan()")->type_name("FILE");
  add_common(plan, call.common);
  plan.callback([&call, save] {
    if (save->count() > 0 && call.plan.save.empty()) throw CLI::ValidationError("--save", "expects a file name");
    call.chosen = [&call] { return command::plan(call.common, call.plan); };
  });
}

void add_backends(CLI::App& app, Invocation& call) {
  CLI::App& backends = *app.add_subcommand("backends", "List the linear solvers, and why some cannot run");
  add_common(backends, call.common);
  backends.callback([&call] { call.chosen = [&call] { return command::backends(call.common); }; });
}

void add_samples(CLI::App& app, Invocation& call) {
  CLI::App& samples = *app.add_subcommand("samples", "List the mechanisms that can be named instead of a file");
  add_common(samples, call.common);
  samples.callback([&call] { call.chosen = [&call] { return command::samples(call.common); }; });
}

// `options`: the question's options, from --run, --machine, --library, --kernel, --all and FILE.
void add_question(CLI::App& db, Invocation& call, const char* name, const char* help,
                  const std::set<std::string>& options) {
  CLI::App& question = *db.add_subcommand(name, help);
  DbOptions& o = call.db;
  const auto takes = [&](const char* option) { return options.count(option) > 0; };
  if (takes("FILE")) question.add_option("FILE", o.file, "A tuning database")->required()->type_name("");
  if (takes("--run")) {
    question.add_option("--run", o.run, "Only the tuning run with this number (see info)")
        ->check(whole_number(1))
        ->type_name("N");
  }
  if (takes("--machine")) {
    question.add_option("--machine", o.machine, "Only this machine: its fingerprint or start of it")->type_name("TEXT");
  }
  if (takes("--library")) {
    question.add_option("--library", o.library, "Only samples of this solver library, or of assur")->type_name("NAME");
  }
  if (takes("--kernel")) {
    question.add_option("--kernel", o.kernel, "Only this kernel: factor, solve, ...")->type_name("NAME");
  }
  if (takes("--all")) question.add_flag("--all", o.all, "All samples");
  add_common(question, call.common);
  question.callback([&call, name] {
    call.db.question = name;
    call.chosen = [&call] { return command::db(call.common, call.db); };
  });
}

void add_db(CLI::App& app, Invocation& call) {
  CLI::App& db = *app.add_subcommand("db", "Query and maintain the tuning database");
  db.require_subcommand(1);
  add_question(db, call, "info", "List databases, tuning runs, and samples in use", {});
  add_question(db, call, "samples", "List the samples", {"--run", "--machine", "--library", "--kernel"});
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
  tune.add_option("--profile", o.profile, "quick (default, a minute), standard or patient")
      ->check(one_of({"quick", "standard", "patient"}))
      ->type_name("NAME");
  tune.add_option("--budget", o.budget, "Time budget, s")->check(budget())->type_name("SECONDS");
  tune.add_option("--scene", o.scenes, "Measure only for this scene; may be repeated")
      ->allow_extra_args(false)
      ->type_name("SCENE");
  tune.add_option("--csv", o.csv, "Also write the samples as CSV")->type_name("FILE");
  add_reading(tune, call.common);
  tune.add_option("--trial", o.trial)->group("");  // hidden: for the child process of a trial
  add_common(tune, call.common);
  tune.callback([&call] { call.chosen = [&call] { return command::tune(call.common, call.tune); }; });
}

void add_check(CLI::App& app, Invocation& call) {
  CLI::App& check = *app.add_subcommand("check", "Run the stability suite: stiff and extreme cases");
  check.add_option("SCENE", call.check.scenes, "Check these scenes instead, with all strategies")->type_name("");
  check.add_flag("--quick", call.check.quick, "Some cases, fewer strategies: less than a minute");
  check.add_option("--case", call.check.only, "Only cases whose names start with NAME")->type_name("NAME");
  add_reading(check, call.common);
  add_common(check, call.common);
  check.callback([&call] { call.chosen = [&call] { return command::check(call.common, call.check); }; });
}

void add_report(CLI::App& app, Invocation& call) {
  CLI::App& report = *app.add_subcommand("report", "Write the benchmark report: a page, CSV and JSON");
  ReportOptions& o = call.report;
  CLI::Option* out = report.add_option("--out", o.out, "Output folder (default: assur-report)")->type_name("DIR");
  report.add_flag("--quick", o.quick, "Take at most three minutes instead of thirty");
  report.add_option("--budget", o.budget, "Approximate time budget, s")->check(budget())->type_name("SECONDS");
  report.add_option("--watts", o.watts, "Processor power (TDP), if energy cannot be read")
      ->check(number(0, " > 0"))
      ->type_name("W");
  report.add_option("--peers", o.peers, "Show other libraries: CSV from bench/peers/peers.sh")
      ->check(CLI::Validator(CLI::ExistingFile).description(""))
      ->type_name("FILE");
  add_common(report, call.common);
  report.callback([&call, out] {
    if (out->count() > 0 && call.report.out.empty()) throw CLI::ValidationError("--out", "expects a folder");
    call.chosen = [&call] { return command::report(call.common, call.report); };
  });
}

}  // namespace

void add_commands(CLI::App& app, Invocation& call) {
  app.require_subcommand(1);
  add_run(app, call);
  add_inspect(app, call);
  add_import(app, call);
  add_samples(app, call);
  add_plan(app, call);
  add_sweep(app, call);
  add_compare(app, call);
  add_backends(app, call);
  add_db(app, call);
  add_tune(app, call);
  add_check(app, call);
  add_report(app, call);
  add_common(app, call.common);
}

}  // namespace assur::options
