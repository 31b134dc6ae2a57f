// Runs of a simulator: over a grid or given times, in chunks, with rows for a sink.
#include <algorithm>
#include <optional>
#include <utility>

#include "index.hpp"
#include "parallel/thread_state.hpp"
#include "runs/chunks.hpp"
#include "runs/memory.hpp"
#include "runs/row_consumers.hpp"
#include "simulation/run_arguments.hpp"
#include "simulation/simulator_access.hpp"
#include "simulation/simulator_impl.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostRowsInBlock = 1024;  // of stream()

// On the long way to the starts of chunks, the step length that works hardly changes. Measured on stewart and four_bar
// with patience from 2 to 16 and growth from 1.25 to 2: these need few attempts, and one in seven is rejected.
constexpr Stride kLongWay{.patience = 4, .growth = 1.5};

}  // namespace

Trajectory Simulator::run(const Observer& observer) {
  const TimeGrid& grid = impl_->prepared.time;
  // The grid, and the times and values of the trajectory.
  check_memory(static_cast<std::size_t>(grid.steps()) + 1, columns().size() + 2);
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(grid.steps()) + 1);
  for (std::int64_t k = 0; k <= grid.steps(); ++k) times.push_back(grid.time(k));
  return run(times, observer);
}

Trajectory Simulator::run(std::span<const double> times, const Observer& observer) {
  check_times(times);
  Trajectory out;
  out.columns_ = impl_->columns;
  check_memory(times.size(), out.columns_.size() + 1);
  reset();
  if (impl_->prepared.plan.run.chunks > 1 && run_in_chunks(times, observer, out)) return out;
  out.values_.reserve(times.size() * out.columns_.size());
  out.times_.reserve(times.size());
  PagesAhead pages(out.values_);
  pages.reach(out.columns_.size());
  each_row(
      times.size(), [&](std::size_t k) { return times[k]; }, observer,
      [&](double t) {
        out.times_.push_back(t);
        pages.reach(out.values_.size() + impl_->row.size());
        out.values_.insert(out.values_.end(), impl_->row.begin(), impl_->row.end());
      });
  impl_->report.counters.stored_values = static_cast<std::int64_t>(out.values_.size());
  return out;
}

// Steps to the times, and calls take(t) after each step that arrived. Returns their number.
template <class TimeOf, class Take>
std::size_t Simulator::each_row(std::size_t count, const TimeOf& time_of, const Observer& observer, const Take& take) {
  std::optional<Pinned> here;  // once, not at every step
  if (!impl_->settings.pin_to.empty() && impl_->motion.levels().threads() > 1) here.emplace(impl_->settings.pin_to[0]);
  for (std::size_t done = 0; done < count;) {
    const double t = time_of(done);
    if (!SimulatorAccess::step_of_run(*this, t).arrived()) return done;
    take(t);
    ++done;
    if (observer && observer(static_cast<std::int64_t>(done), static_cast<std::int64_t>(count)) && done < count) {
      impl_->report.status = {Code::interrupted, {}, t};
      return done;
    }
  }
  return count;
}

template <class TimeOf>
std::size_t Simulator::stream(const RowSelection& selection, const RowSink& sink, std::size_t count,
                              const TimeOf& time_of, const Observer& observer) {
  const std::vector<std::size_t> columns = selected(selection, sink, impl_->columns);
  RowSelection in_blocks = selection;
  in_blocks.block = std::min(selection.block, kMostRowsInBlock);
  RowStream rows(0, columns, in_blocks, sink);
  reset();
  const std::size_t reached = each_row(count, time_of, observer, [&](double t) { rows.add_row(t, impl_->row.data()); });
  rows.finish();
  return reached;
}

std::size_t Simulator::stream(const RowSelection& selection, const RowSink& sink, const Observer& observer) {
  const TimeGrid grid = impl_->prepared.time;
  const auto time_of = [&](std::size_t k) { return grid.time(static_cast<std::int64_t>(k)); };
  return stream(selection, sink, static_cast<std::size_t>(grid.steps()) + 1, time_of, observer);
}

std::size_t Simulator::stream(const RowSelection& selection, const RowSink& sink, std::span<const double> times,
                              const Observer& observer) {
  check_times(times);
  return stream(
      selection, sink, times.size(), [&](std::size_t k) { return times[k]; }, observer);
}

// False if chunks are not possible. The reason is reported, and nothing else changes.
bool Simulator::run_in_chunks(std::span<const double> times, const Observer& observer, Trajectory& out) {
  if (times.empty()) return false;
  const auto refuse = [&](const std::string& why) {
    reset();
    impl_->report.fallbacks.push_back("no chunks: " + why);
    return false;
  };
  if (const std::string why = no_chunks(*impl_->prepared.structure, impl_->settings, times); !why.empty()) {
    return refuse(why);
  }
  const ChunkGrid grid = chunk_grid(times.size(), idx(impl_->prepared.plan.run.chunks));
  const double first_time = impl_->motion.time();
  Stride stride = kLongWay;
  // Chunks need the equations with which the run began. If others were chosen, chunks are refused, and the simulator
  // with these equations replaces this one, because reset() needs it.
  const auto begins_anew = [&](std::unique_ptr<Impl> with_others) {
    if (!with_others) return false;
    Impl::begin_anew(impl_, std::move(with_others));
    return true;
  };
  const auto reach = [&](double t) {
    impl_->motion.count_rejected_from(0);
    if (impl_->step_to(t, true, stride).ok()) return !begins_anew(impl_->reselected_if_poor());
    return impl_->motion.wants_reselection() && !begins_anew(impl_->reselected()) &&
           impl_->step_to(t, false, stride).ok();
  };
  std::vector<Variant> starts;
  for (const std::size_t row : grid.first) {
    if (!reach(times[row])) {
      return refuse("start postures were found only up to t = " + std::to_string(impl_->motion.time()) + " s");
    }
    if (impl_->motion.on_change_point()) {
      return refuse("one of them would begin on a change point, at t = " + std::to_string(times[row]) + " s");
    }
    starts.push_back(
        {impl_->structure.system, impl_->motion.posture(), impl_->motion.time(), impl_->prepared.reselect});
  }
  Counters counters = impl_->report.counters;
  counters.steps = 0;  // steps between the starts do not belong to the grid
  ChunkedRun run = assur::run_in_chunks(impl_->prepared, impl_->settings, times, grid, std::move(starts), observer);
  if (run.rows == 0) return refuse("the first chunk could not be started");
  try {
    impl_->start(run.reached, run.posture);
  } catch (const Error& e) {
    if (e.kind() != Error::Kind::numerical) throw;
    return refuse("the chunks ended in a posture from which no run can start, at t = " + std::to_string(run.reached) +
                  " s");
  }
  out.values_ = std::move(run.values);
  out.times_.assign(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(run.rows));

  impl_->stands_at(run.outputs);
  impl_->earlier_effort = run.totals.effort;
  Report& report = impl_->report;
  report = {};
  impl_->events.clear();
  report.counters = counters;
  report.counters += run.totals.counters;
  report.counters.steps = static_cast<std::int64_t>(run.rows) - (times[0] == first_time ? 1 : 0);
  report.counters.stored_values = static_cast<std::int64_t>(out.values_.size());
  report.error = impl_->earlier_error = run.totals.error;
  report.status = run.status;
  report.reached = run.reached;
  for (Event& event : run.events) impl_->events.add(Noticed::all_of(std::move(event)));
  report.fallbacks = std::move(run.fallbacks);
  return true;
}

}  // namespace assur
