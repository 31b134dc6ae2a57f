#include "side_by_side/run_in_parts.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>

#include "assur/report.hpp"
#include "index.hpp"
#include "parallel/team.hpp"
#include "side_by_side/memory.hpp"
#include "side_by_side/parts.hpp"
#include "simulation/run_arguments.hpp"

namespace assur {
namespace {

// A step reads and writes about 400 bytes for each unknown, so that a part fills half of an L2 cache of 1 MB. Measured
// with stewart:platforms=N and the ends of the handles, groups/lanes:8, AMD EPYC (L2 1 MB, L3 32 MB), by parts over
// step by step: N = 64: 1.12, 512: 1.03, 4096: 0.43.
constexpr std::size_t kUnknownsOfPart = 1200, kWorthParts = 32 * kUnknownsOfPart;

bool is_worthwhile(const Prepared& prepared, const StepLimits& limits, std::size_t rows) {
  const Plan& plan = prepared.plan;
  if (rows < 2 || !can_take(Path::parts, needs_of(limits)) || limits.stop || plan.run.chunks > 1 || plan.accuracy > 0)
    return false;
  std::size_t unknowns = 0;
  for (const Group& g : prepared.structure->groups) unknowns += g.unknowns.size();
  return unknowns >= kWorthParts;
}

// Writes the columns of a part into each row of the whole. Returns the reason why a step was not an ordinary one.
std::string run_one(Simulator& part, std::span<const Part::Columns> own, std::span<const double> times,
                    std::size_t columns, double* values) {
  for (const double t : times) {
    if (const Status s = step_of_run(part, t); !s.ok()) {
      return "the step to t = " + std::to_string(t) + " s ended as " + std::string(name(s.code));
    }
    for (const auto& c : own) std::copy_n(part.outputs().data() + c.from, c.count, values + c.to);
    values += columns;
  }
  const Report& report = part.report();
  if (report.counters.rejected + report.counters.substeps > 0) return "a step had to be divided";
  if (!report.events.empty()) return "there was an event at t = " + std::to_string(report.events.front().time) + " s";
  return "";
}

}  // namespace

std::optional<RunInParts> run_in_parts(const Prepared& prepared, const StepLimits& limits,
                                       std::span<const double> times, std::size_t columns) {
  if (!is_worthwhile(prepared, limits, times.size())) return {};
  Parts parts(prepared, kUnknownsOfPart);
  if (parts.count() == 0) return {};
  RunInParts run;
  run.values.reserve(times.size() * columns);
  PagesAhead(run.values).reach(run.values.capacity());
  run.values.resize(times.size() * columns);
  run.posture = prepared.structure->start;
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> refused = false;
  std::mutex one_at_a_time;  // cuts parts and adds up
  Team team(prepared.plan.run.threads, limits.pin_to);
  team.run([&](int) {
    for (std::size_t p; !refused && (p = next++) < parts.count();) {
      Part part = [&] {
        const std::scoped_lock lock(one_at_a_time);
        return parts.cut(p);
      }();
      Simulator alone(std::move(part.prepared), limits);
      std::string why = run_one(alone, part.columns, times, columns, run.values.data());
      const std::scoped_lock lock(one_at_a_time);
      if (!why.empty()) {
        run.refused = std::move(why);
        refused = true;
        return;
      }
      const Report& report = alone.report();
      run.totals.merge({report.counters, report.error, report.effort});
      const std::vector<double> reached = posture_of(alone);
      for (std::size_t c = 0; c < reached.size(); ++c) run.posture[idx(part.coordinates[c])] = reached[c];
    }
  });
  return run;
}

}  // namespace assur
