#include <iostream>
#include <utility>

#include "check/check_report.hpp"
#include "check/runner.hpp"
#include "commands/commands.hpp"
#include "commands/interrupt.hpp"
#include "measure/step_times.hpp"
#include "output/progress.hpp"

namespace assur::command {
namespace {

// Scenes of the user have no expected verdict; all strategies have to agree.
std::vector<check::Case> cases_of_scenes(const Common& common, const CheckOptions& options) {
  std::vector<check::Case> cases;
  for (const std::string& text : options.scenes) {
    check::Case c;
    c.family = "scenes";
    c.name = c.text = text;
    c.about = "all strategies agree and reach the required accuracy";
    c.set = common.set;
    c.tables = common.tables;
    (void)scene_of(c);  // an invalid scene is bad input, not a failed case
    cases.push_back(std::move(c));
  }
  return cases;
}

std::vector<check::Case> cases_of(const Common& common, const CheckOptions& options) {
  if (!options.scenes.empty()) return cases_of_scenes(common, options);
  std::vector<check::Case> cases = check::all_cases();
  if (!options.only.empty()) {
    std::erase_if(cases, [&](const check::Case& c) { return !c.name.starts_with(options.only); });
    if (cases.empty()) refuse("--case", "no case has a name that starts with \"" + options.only + "\"");
  } else if (options.quick) {
    std::erase_if(cases, [](const check::Case& c) { return !c.quick; });
  }
  return cases;
}

void print(const Common& common, const output::CheckSummary& summary) {
  if (common.json) {
    output::print(std::cout, to_json(summary));
    output::Page details(std::cerr);
    print_failures(details, summary);
  } else {
    output::Page page(std::cout);
    output::print(page, summary);
    print_failures(page, summary);
  }
}

}  // namespace

int check(const Common& common, const CheckOptions& options) {
  const std::vector<check::Case> cases = cases_of(common, options);
  using output::Progress;
  Progress progress(common.quiet, "case");
  const Interrupt interrupt;
  const double begin = measure::StepTimes::steady();
  const auto elapsed = [begin] { return measure::StepTimes::steady() - begin; };
  const auto of = static_cast<std::int64_t>(cases.size());

  output::CheckSummary summary;
  check::RunnerOptions how;
  how.quick = options.quick;
  how.stop = [&] {
    progress.show(elapsed(), static_cast<std::int64_t>(summary.results.size()), of);
    return Interrupt::requested();
  };
  for (const check::Case& c : cases) {
    check::Result result = check::run(c, how);
    summary.interrupted = result.interrupted;
    if (summary.interrupted) break;
    summary.results.push_back(std::move(result));
  }
  progress.clear();
  summary.seconds = elapsed();
  print(common, summary);
  if (summary.interrupted) return kInterrupted;
  return summary.failed() == 0 ? kDone : kNumerical;
}

}  // namespace assur::command
