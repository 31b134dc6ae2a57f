// assur run SCENE --animate FILE --picture FILE
#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "assur/machine.hpp"
#include "commands/interrupt.hpp"
#include "commands/run_parts.hpp"
#include "commands/start_modes.hpp"
#include "db/libraries.hpp"
#include "output/format.hpp"
#include "output/replace_file.hpp"
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
  const TimeGrid& grid = prepared.time();
  const std::string steps = output::counted(grid.steps(), "step") + " of " + output::number(grid.step) + " s from ";
  return {(grid.steps() > 0 ? steps : "One posture at ") + "t = " + output::number(grid.start) + " s; strategy " +
          options.strategy + "; assur " + std::string(db::assur_version()) + "."};
}

}  // namespace

bool write_animation(const Prepared& prepared, const Report& report, PrepareOptions how,
                     const std::vector<ModeChoice>& modes, const RunOptions& options, std::ostream* page,
                     std::ostream* picture, output::Progress& progress) {
  const Prepared shown = prepare(pictures::with_all_places(*prepared.scene()), step_by_step(std::move(how)), modes);
  Simulator simulator(shown, settings_of(options));
  std::vector<double> times;
  for (std::int64_t k = 0; k <= prepared.time().steps(); ++k) times.push_back(prepared.time().time(k));

  const Interrupt interrupt;
  const double begin = measure::StepTimes::steady();
  const bool was_interrupted = report.status.code == Code::interrupted;
  const pictures::Animation animation = pictures::animation_of(prepared, simulator, times, [&](std::int64_t k) {
    progress.show(measure::StepTimes::steady() - begin, k - 1, prepared.time().steps());
    const double t = times[static_cast<std::size_t>(k)];
    return !Interrupt::requested() && !(was_interrupted && t > report.reached);
  });
  progress.clear();
  if (page != nullptr) *page << animation.page(about(prepared, options));
  if (picture != nullptr) *picture << animation.picture();
  return !Interrupt::requested();
}

std::string moving_picture_of(const Prepared& prepared, const PrepareOptions& how, const RunOptions& options) {
  std::ostringstream picture;
  output::Progress none(true);
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
  if (structure.cannot_assemble().empty()) return;
  output::Replacement page("--animate", file);
  page.stream() << pictures::Animation(scene, structure).page({"assur " + std::string(db::assur_version()) + "."});
  page.put();
}

}  // namespace assur::command
