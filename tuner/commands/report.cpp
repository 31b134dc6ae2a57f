// assur report
#include "report/report.hpp"

#include <cmath>
#include <filesystem>
#include <iostream>

#include "assur/machine.hpp"
#include "commands/commands.hpp"
#include "commands/db_parts.hpp"
#include "commands/interrupt.hpp"
#include "measure/step_times.hpp"
#include "output/json.hpp"
#include "output/progress.hpp"

namespace assur::command {
namespace {

constexpr double kQuick = 150, kFull = 1500;  // s; ends within 3 and 30 minutes on two shared cores

}  // namespace

int report(const Common& common, const ReportOptions& options) {
  for (const char* name : {"index.html", "report.csv", "report.json"}) {
    refuse_overwriting(common, {{"--out", (std::filesystem::path(options.out) / name).string()}}, {options.peers});
  }
  const report::Knowledge knowledge = report::knowledge(machine_model_of(common), databases_of(common));
  if (!common.quiet) {
    for (const std::string& message : knowledge.known.messages) std::cerr << "note: " << message << '\n';
  }
  using output::Progress;
  Progress progress(common.quiet, "second");
  const double begin = measure::StepTimes::steady();
  const Interrupt interrupt;
  report::Conditions whole;
  whole.seconds = options.budget.value_or(options.quick ? kQuick : kFull);
  whole.quick = options.quick;
  whole.threads = common.threads > 0 ? common.threads : this_machine().budget().threads;
  // All measurements call this often, so it also moves the progress bar.
  whole.interrupted = [&] {
    const double seconds = measure::StepTimes::steady() - begin;
    progress.show(seconds, std::lround(std::min(seconds, whole.seconds)), std::lround(whole.seconds));
    return Interrupt::requested();
  };
  const report::Outcome outcome =
      make_report(options.out, report::contents(knowledge, {options.peers, options.watts}), knowledge, whole);
  progress.clear();

  if (common.json) {
    output::Json files = output::Json::array();
    for (const auto& file : outcome.files) files.push_back(file.string());
    output::Json parts = output::Json::array();
    for (const auto& part : outcome.parts) parts.push_back({{"title", part.title}, {"seconds", part.seconds}});
    output::print(std::cout, {{"files", std::move(files)},
                              {"seconds", measure::StepTimes::steady() - begin},
                              {"parts", std::move(parts)},
                              {"interrupted", outcome.interrupted},
                              {"failures", outcome.failures}});
  } else {
    for (const auto& file : outcome.files) std::cout << file.string() << '\n';
    if (outcome.interrupted) std::cerr << "interrupted: the report holds what was measured until then\n";
    for (const std::string& failure : outcome.failures) std::cerr << "error: " << failure << '\n';
  }
  if (outcome.interrupted) return kInterrupted;
  return outcome.failures.empty() ? kDone : kNumerical;
}

}  // namespace assur::command
