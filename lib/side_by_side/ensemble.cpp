#include "assur/ensemble.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <optional>
#include <utility>

#include "numbers.hpp"
#include "scene/outputs.hpp"
#include "side_by_side/memory.hpp"
#include "side_by_side/run_arguments.hpp"
#include "side_by_side/tiles.hpp"

namespace assur {

struct Ensemble::Impl {
  Impl(std::size_t count, const std::function<Prepared(std::size_t)>& member, StepLimits step_limits)
      : limits(step_limits), cannot(count) {
    check_limits(limits);
    if (limits.seconds > 0) {
      throw Error(Error::Kind::input,
                  "StepLimits::seconds limits single steps, which an ensemble does not support; set it to 0");
    }
    std::exception_ptr first_error;
    for (std::size_t i = 0; i < count; ++i) {
      try {
        take(i, member(i));
      } catch (const Error& e) {
        if (e.kind() == Error::Kind::environment) throw;
        if (!first_error) first_error = std::current_exception();
        cannot[i] = e.what();
      }
    }
    if (!prepared && first_error) std::rethrow_exception(first_error);
    if (!prepared) throw Error(Error::Kind::input, "an ensemble needs at least one member");
    tiles.emplace(*prepared, limits, in_lanes.size());
  }

  void take(std::size_t i, Prepared p) {
    p.plan.run.chunks = 1;
    if (!prepared) {
      prepared = p;
      columns = column_names(*p.structure->system);
    } else if (column_names(*p.structure->system) != columns) {
      cannot[i] = "its outputs differ from those of the first member";
      return;
    }
    if (!same_structure(*prepared->structure, *p.structure) || p.time.start != prepared->time.start) {
      others.emplace(i, std::move(p));
      return;
    }
    in_lanes.push_back(i);
    variants.push_back({p.structure->system, p.structure->start, p.time.start, p.reselect});
  }

  EnsembleTrajectory start(std::span<const double> times) {
    EnsembleTrajectory out;
    out.columns_ = columns;
    out.times_.assign(times.begin(), times.end());
    out.rows_.assign(cannot.size(), 0);
    check_memory(cannot.size() * times.size(), out.columns_.size());
    out.values_.reset(new double[cannot.size() * times.size() * out.columns_.size()]);
    report = {};
    totals = {};
    tiles->clear();
    outcomes.assign(cannot.size(), {});
    for (std::size_t i = 0; i < cannot.size(); ++i) {
      outcomes[i].cannot = cannot[i];
      outcomes[i].reached = times[0];
      if (!cannot[i].empty()) outcomes[i].status.code = Code::not_converged;
    }
    return out;
  }

  // Runs the members that share the structure, in tiles; a free thread takes the next tile.
  void run_in_lanes(EnsembleTrajectory& out, const Simulator::Observer& observer) {
    const std::size_t rows = out.times_.size();
    std::vector<LaneRun> runs(in_lanes.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      runs[i].variant = variants[i];
      runs[i].times = out.times_;
      runs[i].rows = out.values_.get() + in_lanes[i] * rows * columns.size();
    }
    tiles->run(runs, observer, 0);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      LaneRun& run = runs[i];
      out.rows_[in_lanes[i]] = run.done;
      totals.error.merge(run.error);
      outcomes[in_lanes[i]] = {run.status, run.reached,    std::move(run.cannot),
                               run.alone,  run.alone_from, std::move(run.events)};
      note(in_lanes[i], run.fallbacks);
    }
    totals.merge(tiles->totals());
  }

  void run_other(std::size_t i, EnsembleTrajectory& out, const Simulator::Observer& observer) {
    Prepared p = others.at(i);
    p.plan.run.threads = 1;
    Outcome& outcome = outcomes[i];
    outcome.alone = true;
    outcome.alone_from = outcome.reached = out.times_[0];
    std::optional<Simulator> simulator;
    try {
      simulator.emplace(std::move(p), limits);
    } catch (const Error& e) {
      if (e.kind() != Error::Kind::numerical) throw;
      outcome.cannot = e.what();
      outcome.status.code = Code::singular;
      return;
    }
    const Trajectory t = simulator->run(out.times_, observer);
    std::copy(t.values().begin(), t.values().end(), out.values_.get() + i * out.times_.size() * columns.size());
    const Report& its = simulator->report();
    out.rows_[i] = t.rows();
    outcome.status = its.status;
    outcome.reached = its.reached;
    outcome.events = its.events;
    note(i, its.fallbacks);
    totals.merge({its.counters, its.error, its.effort});
  }

  void note(std::size_t member, const std::vector<std::string>& fallbacks) {
    for (const std::string& f : fallbacks)
      report.fallbacks.push_back("member " + std::to_string(member + 1) + ": " + f);
  }

  // Fills the rows that a member did not reach.
  static void fill_missing_rows(EnsembleTrajectory& out) {
    const std::size_t rows = out.times_.size(), columns = out.columns_.size();
    for (std::size_t i = 0; i < out.members(); ++i) {
      std::fill_n(out.values_.get() + (i * rows + out.rows_[i]) * columns, (rows - out.rows_[i]) * columns, kNan);
    }
  }

  void summarize(const EnsembleTrajectory& out) {
    report.counters = totals.counters;
    report.counters.stored_values = 0;
    report.error = totals.error;
    report.effort = totals.effort;
    report.reached = out.times_.back();
    std::size_t alone = 0;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      const Outcome& o = outcomes[i];
      report.counters.stored_values += static_cast<std::int64_t>(out.rows_[i] * columns.size());
      report.reached = std::min(report.reached, o.reached);
      alone += o.alone ? 1 : 0;
      // A failed member outranks an inaccurate one.
      if ((report.status.ok() && !o.status.ok()) || (report.status.arrived() && !o.status.arrived())) {
        report.status = o.status;
        report.status.where = Place::member(static_cast<std::int32_t>(i));
      }
    }
    if (alone > 0) {
      report.fallbacks.push_back(std::to_string(alone) + " of " + std::to_string(outcomes.size()) +
                                 " members continued alone, because they could not be solved in lockstep with others");
    }
  }

  StepLimits limits;
  std::vector<std::string> cannot;   // reason why the member cannot be started; empty: it can
  std::optional<Prepared> prepared;  // that of the first member that can be started
  std::vector<std::string> columns;  // of all members
  std::vector<std::size_t> in_lanes;
  std::vector<Variant> variants;  // variants of the members in lanes
  std::map<std::size_t, Prepared> others;
  std::optional<Tiles> tiles;
  Totals totals;
  Report report;
  std::vector<Outcome> outcomes;
};

Ensemble::Ensemble(std::size_t members, const std::function<Prepared(std::size_t)>& member, StepLimits limits)
    : impl_(std::make_unique<Impl>(members, member, limits)) {}
Ensemble::Ensemble(Ensemble&&) noexcept = default;
Ensemble& Ensemble::operator=(Ensemble&&) noexcept = default;
Ensemble::~Ensemble() = default;

EnsembleTrajectory Ensemble::run(const Simulator::Observer& observer) {
  const TimeGrid& grid = impl_->prepared->time;
  check_memory(static_cast<std::size_t>(grid.steps()) + 1, 2);  // memory of the times; run() checks that of the values
  std::vector<double> times;
  for (std::int64_t k = 0; k <= grid.steps(); ++k) times.push_back(grid.time(k));
  return run(times, observer);
}

EnsembleTrajectory Ensemble::run(std::span<const double> times, const Simulator::Observer& observer) {
  if (times.empty() || times[0] != impl_->prepared->time.start) {
    throw Error(Error::Kind::input, "the times of an ensemble must begin with time.start of its scene");
  }
  check_times(times);
  EnsembleTrajectory out = impl_->start(times);
  const auto rows = [&](std::size_t members) { return static_cast<std::int64_t>(members * times.size()); };
  const std::int64_t of = rows(impl_->in_lanes.size() + impl_->others.size());
  bool stopped = false;
  std::int64_t before = 0;
  Simulator::Observer of_all;
  if (observer) {
    of_all = [&](std::int64_t done, std::int64_t) {
      stopped = !observer(before + done, of);
      return !stopped;
    };
  }
  impl_->run_in_lanes(out, of_all);
  before = rows(impl_->in_lanes.size());
  for (const auto& [i, prepared] : impl_->others) {
    if (stopped) {
      impl_->outcomes[i].status = {Code::interrupted, {}, times[0]};
      continue;
    }
    impl_->run_other(i, out, of_all);
    before += rows(1);
  }
  Impl::fill_missing_rows(out);
  impl_->summarize(out);
  return out;
}

std::size_t Ensemble::members() const { return impl_->cannot.size(); }
const Prepared& Ensemble::prepared() const { return *impl_->prepared; }
const Report& Ensemble::report() const { return impl_->report; }
const std::vector<Ensemble::Outcome>& Ensemble::outcomes() const { return impl_->outcomes; }

}  // namespace assur
