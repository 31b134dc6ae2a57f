#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <optional>
#include <utility>

#include "assur/machine.hpp"
#include "commands/commands.hpp"
#include "commands/db_parts.hpp"
#include "commands/interrupt.hpp"
#include "commands/print_result.hpp"
#include "db/database_files.hpp"
#include "measure/noise.hpp"
#include "measure/pace.hpp"
#include "measure/step_times.hpp"
#include "median.hpp"
#include "numbers.hpp"
#include "output/format.hpp"
#include "output/notes.hpp"
#include "output/progress.hpp"
#include "output/replace_file.hpp"
#include "tuning/archive.hpp"
#include "tuning/campaign.hpp"
#include "tuning/held_out.hpp"
#include "tuning/probe.hpp"
#include "tuning/profile.hpp"
#include "tuning/proof.hpp"
#include "tuning/refinement.hpp"
#include "tuning/sample_csv.hpp"
#include "tuning/tuning_report.hpp"

namespace assur::command {
namespace {

constexpr double kTrial = 5;         // s, time limit for the trial of a solver, which normally takes milliseconds
constexpr double kLook = 0.01;       // share of the run time for observing the usual pace of the machine
constexpr double kMostLook = 1;      // s, upper limit of that time
constexpr double kProofShare = 0.1;  // share of the run time for whole steps of unlike mechanisms
constexpr int kRoundsOfSpread = 5;   // fewest rounds for a meaningful spread

// With --csv the run may do without a database.
std::optional<std::filesystem::path> database_of(const Common& common, const TuneOptions& options) {
  if (!options.csv.empty() && common.db.empty()) return db::own_database();
  return own_database_of(common);
}

// The command line that tries one strategy in a child process.
std::vector<std::string> trial_of(const Strategy& strategy) {
  return {"/proc/self/exe", "tune", "--trial", to_string(strategy)};
}

std::vector<tuning::Cell> cells_of(const Common& common, const TuneOptions& options, const tuning::Extent& extent) {
  if (options.scenes.empty()) return tuning::general_cells(extent);
  std::vector<tuning::Cell> cells;
  for (const std::string& text : options.scenes) {
    const Scene scene = open_scene(text, common.set, common.tables);
    refuse_overwriting({{"--csv", options.csv}}, scene);
    std::vector<tuning::Cell> more = tuning::scene_cells(text, scene);
    std::move(more.begin(), more.end(), std::back_inserter(cells));
  }
  return cells;
}

std::string name_of(const tuning::Profile& profile, const TuneOptions& options) {
  std::string name = profile.name;
  for (const std::string& scene : options.scenes) name += (&scene == &options.scenes.front() ? ": " : ", ") + scene;
  return name;
}

double scatter_of(const std::vector<tuning::CellResult>& cells) {
  std::vector<double> scatter;
  for (const tuning::CellResult& cell : cells) {
    for (const tuning::Result& r : cell.results) {
      if (r.rounds >= kRoundsOfSpread) scatter.push_back(r.sample.spread / r.sample.seconds);
    }
  }
  return scatter.empty() ? 0 : median(std::move(scatter));
}

measure::NoiseAssessment assessment_of(const tuning::Campaign& campaign, const measure::NoiseWatch& watch) {
  measure::Noise noise = watch.noise();
  const measure::RaceFigures& race = campaign.figures().race;
  noise.disturbed = static_cast<double>(race.disturbed) / static_cast<double>(std::max<std::int64_t>(race.blocks, 1));
  noise.uneven = static_cast<double>(race.uneven) / static_cast<double>(std::max<std::int64_t>(race.shared, 1));
  noise.scatter = scatter_of(campaign.results());
  noise.drift = campaign.figures().drift();
  return measure::assess(noise);
}

db::Grade grade_of(measure::Quiet quiet) {
  switch (quiet) {
    case measure::Quiet::yes:
      return db::Grade::good;
    case measure::Quiet::some_noise:
      return db::Grade::fair;
    case measure::Quiet::noisy:
      break;
  }
  return db::Grade::noisy;
}

void write_csv(output::Replacement& out, const std::vector<tuning::CellResult>& cells) {
  std::vector<Sample> samples;
  for (const tuning::CellResult& cell : cells) {
    for (const tuning::Result& r : cell.results) samples.insert(samples.end(), r.passes.begin(), r.passes.end());
  }
  tuning::write_csv(out.stream(), samples);
  out.put();
}

}  // namespace

int tune(const Common& common, const TuneOptions& options) {
  if (!options.trial.empty()) {
    tuning::probe(parse_strategy(options.trial), assur::backends());
    return kDone;
  }
  const double begin = measure::StepTimes::steady();
  refuse_overwriting(common, {{"--csv", options.csv}}, options.scenes);
  const tuning::Profile profile = tuning::profile(options.profile, options.budget);
  std::vector<tuning::Cell> cells = cells_of(common, options, profile.extent);
  output::Replacement csv("--csv", options.csv);
  tuning::Archive archive(database_of(common, options), name_of(profile, options));
  for (const std::string& message : archive.messages()) std::cerr << message << '\n';
  if (!common.quiet) {
    for (const std::string& reason : output::slowed(assur::backends())) std::cerr << reason << '\n';
  }

  tuning::CampaignOptions how;
  how.field.table = assur::backends();
  how.field.budget = common.threads > 0 ? ThreadBudget{common.threads} : this_machine().budget();
  const measure::NoiseWatch watch(how.field.budget.threads);
  const tuning::Probes probes(how.field.table, how.field.budget, trial_of, kTrial);
  how.field.why_not = [&](const Strategy& s) { return probes.why_not(s); };
  measure::MachinePace pace(how.field.budget.threads, std::min(kLook * profile.seconds, kMostLook),
                            archive.usual_pace());
  how.seconds = profile.seconds - (measure::StepTimes::steady() - begin);
  how.most_for_cell = profile.most_for_cell;
  how.earlier = archive.earlier();
  how.store = [&](const tuning::CellResult& cell) { archive.add(cell, pace.usual()); };
  // A run for scenes ends with its cells; other runs use the whole budget.
  using output::Progress;
  const bool by_cells = !options.scenes.empty();
  Progress progress(common.quiet, by_cells ? "cell" : "second");
  std::int64_t begun = 0;
  how.progress = [&](double seconds, const tuning::Cell&) {
    if (by_cells) {
      progress.show(seconds, begun++, static_cast<std::int64_t>(cells.size()));
    } else {
      progress.show(seconds, std::lround(seconds), std::lround(profile.seconds));
    }
  };
  const Interrupt interrupt;
  measure::Instruments instruments;
  instruments.stop = [] { return Interrupt::requested(); };
  pace.attach(instruments);

  tuning::Campaign campaign(how, instruments);
  campaign.run(cells, by_cells ? 0 : kProofShare * profile.seconds);
  std::vector<tuning::Proof> proofs;
  if (!by_cells) {
    proofs = tuning::prove(campaign, how.field);
    tuning::refine(campaign, profile.until_settled);
  }
  progress.clear();

  const measure::NoiseAssessment noise = assessment_of(campaign, watch);
  output::TuningSummary summary;
  summary.run = archive.run();
  summary.database = archive.file();
  summary.profile = name_of(profile, options);
  summary.grade = name(grade_of(noise.quiet));
  summary.reason = noise.reason;
  summary.figures = campaign.figures();
  summary.regret = tuning::regret(tuning::model_of(campaign.results()), campaign.results());
  summary.proofs = std::move(proofs);
  summary.failed = probes.failed();
  summary.cells = campaign.results();
  summary.seconds = measure::StepTimes::steady() - begin;
  const bool nothing = summary.figures.measured == 0;  // then the next run continues this one
  if (!summary.figures.interrupted && !nothing) {
    archive.finish({grade_of(noise.quiet), summary.seconds, summary.figures.coverage(), noise.reason},
                   to_json(summary).dump());
  }
  if (csv) write_csv(csv, campaign.results());
  print_result(common, summary);
  if (summary.figures.interrupted) return kInterrupted;
  if (!nothing) return kDone;
  std::cerr << "error: nothing was measured in " << output::duration(profile.seconds)
            << ": the machine is busy or slow; increase --budget\n";
  return kEnvironment;
}

}  // namespace assur::command
