// assur run SCENE --animate FILE --picture FILE
#include <algorithm>
#include <iostream>
#include <optional>
#include <sstream>
#include <utility>

#include "assur/machine.hpp"
#include "commands/interrupt.hpp"
#include "commands/run_parts.hpp"
#include "commands/start_modes.hpp"
#include "db/libraries.hpp"
#include "output/format.hpp"
#include "output/replace_file.hpp"
#include "output/status_text.hpp"
#include "pictures/animation.hpp"

namespace assur::command {
namespace {

// The animation needs single steps, so chunks are not used.
PrepareOptions step_by_step(PrepareOptions how) {
  how.mode = Mode::latency;
  if (how.strategy == "auto") return how;
  Strategy strategy = parse_strategy(how.strategy);
  strategy.run.chunks = 1;
  how.strategy = to_string(strategy);
  return how;
}

std::vector<std::string> about(const Prepared& prepared, const RunOptions& options) {
  const TimeGrid& grid = prepared.time;
  const std::string steps = output::counted(grid.steps(), "step") + " of " + output::number(grid.step) + " s from ";
  return {(grid.steps() > 0 ? steps : "One posture at ") + "t = " + output::number(grid.start) + " s; strategy " +
          options.strategy + "; assur " + std::string(db::assur_version()) + "."};
}

}  // namespace

bool write_animation(const Prepared& prepared, const Report& report, PrepareOptions how,
                     const std::vector<ModeChoice>& modes, const RunOptions& options, std::ostream* page,
                     std::ostream* picture, output::Progress& progress) {
  const Prepared shown = prepare(pictures::with_all_places(*prepared.scene), step_by_step(std::move(how)), modes);
  Simulator simulator(shown, limits_of(options));
  const std::int64_t steps = prepared.time.steps();
  pictures::Animation animation(prepared, shown, steps);
  animation.take(0, simulator);

  const Interrupt interrupt;
  const double begin = measure::StepTimes::steady();
  const bool was_interrupted = report.status.code == Code::interrupted;
  std::string why;
  for (std::int64_t k = 1; k <= steps && why.empty(); ++k) {
    const double t = prepared.time.time(k);
    if (Interrupt::requested() || (was_interrupted && t > report.reached)) {
      why = output::explained(Code::interrupted);
      break;
    }
    const Status status = simulator.step(t);
    if (status.arrived()) {
      animation.take(k, simulator);
      progress.show(measure::StepTimes::steady() - begin, k, steps);
    } else {
      why = output::why_stopped(status, simulator.report().events, simulator.report().reached);
    }
  }
  progress.clear();
  if (!why.empty()) animation.end(simulator, why);
  if (page != nullptr) *page << animation.page(about(prepared, options));
  if (picture != nullptr) *picture << animation.picture();
  return !Interrupt::requested();
}

std::string moving_picture_of(const Prepared& prepared, const PrepareOptions& how, const RunOptions& options) {
  std::ostringstream picture;
  output::Progress none(std::cerr, output::Progress::Style::none, "step");
  try {
    (void)write_animation(prepared, {}, how, {}, options, nullptr, &picture, none);
  } catch (const Error& e) {
    if (e.kind() == Error::Kind::environment) throw;
    return {};
  }
  return picture.str();
}

void write_refused(const Scene& scene, const PrepareOptions& how, const std::string& file) {
  StructureOptions asked;
  asked.controlled = how.controlled;
  const Structure structure = analyze(scene, asked);
  if (structure.cannot_assemble.empty()) return;
  output::Replacement page("--animate", file);
  page.stream() << pictures::Animation(scene, structure).page({"assur " + std::string(db::assur_version()) + "."});
  page.put();
}

}  // namespace assur::command
