#include <algorithm>
#include <cmath>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/simulator.hpp"
#include "measure/step_times.hpp"
#include "measure/ways.hpp"
#include "median.hpp"
#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "pictures/ticks.hpp"
#include "report/sections.hpp"

namespace assur::report {
namespace {

constexpr const char* kScene = "stewart";
constexpr int kWarm = 1000;  // first steps, not timed, until memory is in the cache and threads are awake
constexpr double kLeastSeconds = 0.3, kMostSeconds = 10;  // s; shorter runs show no tail, longer ones nothing new
constexpr std::int64_t kMostSteps = 2'000'000;            // 16 MB of times
constexpr int kBetweenLooks = 500;                        // readings of the clock between checks of the remaining time
constexpr int kBins = 80;                                 // columns of the picture

struct Timed {
  measure::StepTimes::Blocks blocks;
  measure::StepTimes::Figures figures{};
  double error = 0;
};

// The motion of the sample continues beyond the end of its grid.
Timed time_steps(const Prepared& prepared, const Conditions& conditions) {
  Simulator simulator(prepared);
  std::int64_t k = 0;
  const auto advance = [&] {
    const Status status = simulator.step(prepared.time().time(++k));
    if (!status.arrived()) throw Error(Error::Kind::numerical, std::string(kScene) + ": a step failed");
  };
  for (int i = 0; i < kWarm; ++i) advance();
  measure::StepTimes times(kMostSteps);
  times.tick();
  const double seconds = std::clamp(conditions.seconds, kLeastSeconds, kMostSeconds);
  std::int64_t readings = 0;
  for (std::int64_t i = 0; i < kMostSteps; ++i) {
    advance();
    if (!times.tick() || ++readings % kBetweenLooks != 0) continue;
    if (times.elapsed() > seconds || conditions.interrupted()) break;
    times.resume();  // excludes these checks from the next step
  }
  return {times.blocks(), times.figures(), simulator.report().error.position};
}

// Logarithmic bins from the shortest to the longest time; the last point is the end of the last bar.
pictures::Series bars(const Timed& timed) {
  const auto [least, most] = std::minmax_element(timed.blocks.seconds.begin(), timed.blocks.seconds.end());
  const double low = std::log(std::max(*least, 1e-9)), width = std::max(1e-6, (std::log(*most) - low) / kBins);
  std::vector<std::int64_t> counts(kBins, 0);
  for (const double s : timed.blocks.seconds) {
    ++counts[static_cast<std::size_t>(std::clamp((std::log(std::max(s, 1e-9)) - low) / width, 0.0, kBins - 1.0))];
  }
  pictures::Series out{.name = "",
                       .points = {},
                       .colour = 0,
                       .mark = pictures::Series::Mark::none,
                       .line = pictures::Series::Line::bars};
  const auto all = static_cast<double>(timed.blocks.seconds.size());
  for (int i = 0; i <= kBins; ++i) {
    const double from = std::exp(low + i * width);
    const std::int64_t count = i < kBins ? counts[static_cast<std::size_t>(i)] : 0;
    out.points.push_back({from, 100 * static_cast<double>(count) / all,
                          output::duration(from) + " to " + output::duration(std::exp(low + (i + 1) * width)) + ": " +
                              output::counted(count, timed.blocks.steps > 1 ? "block" : "step")});
  }
  return out;
}

}  // namespace

Section step_histogram(const Knowledge& knowledge, const Conditions& conditions) {
  Section out{"steps", "Times of single steps"};
  const Prepared prepared =
      prepare(sample(kScene), {.budget = ThreadBudget{conditions.threads}, .model = knowledge.known.model});
  const std::string strategy = measure::essence(prepared.plan());
  const Timed timed = time_steps(prepared, conditions);
  if (timed.blocks.seconds.empty()) return out;

  std::vector<double> deviations;
  for (const double s : timed.blocks.seconds) deviations.push_back(std::abs(s - timed.figures.median));
  const double spread = quantile(std::move(deviations), 0.5) / timed.figures.median;
  const auto count = static_cast<int>(timed.blocks.seconds.size());
  const auto add = [&](const char* quantity, double seconds) {
    out.measurements.push_back({kScene, strategy, quantity, "s", seconds,
                                timed.figures.block > 1
                                    ? "measured in blocks of " + std::to_string(timed.figures.block) + " steps"
                                    : "measured, each step by itself",
                                count, spread, timed.error});
  };
  add("seconds per step, p50", timed.figures.median);
  add("seconds per step, p99", timed.figures.p99);
  add("seconds per step, max", timed.figures.max);

  pictures::Plot plot;
  plot.title = std::string(kScene) + ": histogram of the times of steps";
  plot.x = {"time of one step", true, pictures::time_text};
  plot.y = {"share of the steps, %", true, pictures::power_of_ten};
  plot.guides = {{timed.figures.median, "p50"}, {timed.figures.p99, "p99"}, {timed.figures.max, "max"}};
  plot.series = {bars(timed)};
  out.body = paragraph(std::string(kScene) + ", auto (" + strategy + "), " +
                       output::counted(std::int64_t{count} * timed.figures.block, "step") + ": p50 " +
                       output::duration(timed.figures.median) + ", p99 " + output::duration(timed.figures.p99) +
                       ", max " + output::duration(timed.figures.max) + ". The largest position error is " +
                       output::error_figure(timed.error) + ".");
  out.body += pictures::figure(plot);
  out.body += paragraph(
      "Both axes are logarithmic. Times far to the right are steps that the system interrupted; a real-time "
      "system has fewer of them.",
      "faint");
  return out;
}

}  // namespace assur::report
