#include "assur/ensemble.hpp"

#include <algorithm>
#include <exception>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "simulation/memory.hpp"
#include "simulation/tiles.hpp"

namespace assur {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

struct Ensemble::Impl {
  Impl(std::size_t count, const std::function<Prepared(std::size_t)>& member, StepLimits step_limits)
      : limits(step_limits), cannot(count) {
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
    p.plan.chunks = 1;
    if (!prepared) prepared = p;
    if (!same_structure(*prepared->structure, *p.structure) || p.scene->time().start != prepared->scene->time().start) {
      others.emplace(i, std::move(p));
      return;
    }
    in_lanes.push_back(i);
    variants.push_back({p.structure->system, p.structure->start, p.scene->time().start, p.reselect});
  }

  EnsembleTrajectory start(std::span<const double> times) {
    EnsembleTrajectory out;
    out.columns_ = tiles->first().columns();
    out.times_.assign(times.begin(), times.end());
    out.rows_.assign(cannot.size(), 0);
    check_memory(cannot.size() * times.size(), out.columns_.size());
    out.values_.assign(cannot.size() * times.size() * out.columns_.size(), kNan);
    report = {};
    outcomes.assign(cannot.size(), {});
    for (std::size_t i = 0; i < cannot.size(); ++i) {
      outcomes[i].cannot = cannot[i];
      if (!cannot[i].empty()) outcomes[i].status.code = Code::not_converged;
    }
    return out;
  }

  // Members that share the structure, tile after tile; whoever is free takes the next one.
  void run_in_lanes(EnsembleTrajectory& out, const Simulator::Observer& observer) {
    const std::size_t rows = out.times_.size(), columns = out.columns_.size();
    std::vector<LaneRun> runs(in_lanes.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      runs[i].variant = variants[i];
      runs[i].times = out.times_;
      runs[i].rows = out.values_.data() + in_lanes[i] * rows * columns;
    }
    tiles->run(runs, observer, static_cast<std::int64_t>(rows * in_lanes.size()));
    for (std::size_t i = 0; i < runs.size(); ++i) {
      Outcome& outcome = outcomes[in_lanes[i]];
      out.rows_[in_lanes[i]] = runs[i].done;
      outcome.status = runs[i].status;
      outcome.alone = runs[i].alone;
      outcome.alone_from = runs[i].alone_from;
      outcome.events = std::move(runs[i].events);
    }
  }

  void run_other(std::size_t i, EnsembleTrajectory& out, const Simulator::Observer& observer) {
    Prepared p = others.at(i);
    p.plan.threads = 1;
    Outcome& outcome = outcomes[i];
    outcome.alone = true;
    outcome.alone_from = out.times_[0];
    Simulator simulator(std::move(p), limits);
    if (simulator.columns() != out.columns_) {
      outcome.cannot = "its outputs are others than those of the first member";
      outcome.status.code = Code::interrupted;
      return;
    }
    const Trajectory t = simulator.run(out.times_, observer);
    std::copy(t.values().begin(), t.values().end(),
              out.values_.begin() + static_cast<std::ptrdiff_t>(i * out.times_.size() * out.columns_.size()));
    out.rows_[i] = t.rows();
    outcome.status = simulator.report().status;
    outcome.events = simulator.report().events;
    totals.merge({simulator.report().counters, simulator.report().error, simulator.report().effort});
  }

  void summarize(const EnsembleTrajectory& out) {
    totals.merge(tiles->totals());
    report.counters = totals.counters;
    report.counters.stored_values = 0;
    report.error = totals.error;
    report.effort = totals.effort;
    report.reached = out.times_.back();
    std::size_t alone = 0;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      Outcome& o = outcomes[i];
      o.reached = out.rows_[i] > 0 ? out.times_[out.rows_[i] - 1] : out.times_[0];
      report.counters.stored_values += static_cast<std::int64_t>(out.rows_[i] * out.columns_.size());
      report.reached = std::min(report.reached, o.reached);
      alone += o.alone ? 1 : 0;
      if (report.status.ok() && !o.status.ok()) {
        report.status = o.status;
        report.status.where = static_cast<std::int32_t>(i);
      }
    }
    if (alone > 0) {
      report.fallbacks.push_back(std::to_string(alone) + " of " + std::to_string(outcomes.size()) +
                                 " members went on alone, where they could not keep step with others");
    }
  }

  StepLimits limits;
  std::vector<std::string> cannot;   // members: why one cannot be started; empty: it can
  std::optional<Prepared> prepared;  // of the first that can
  std::vector<std::size_t> in_lanes;
  std::vector<Variant> variants;  // of those in lanes
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
  const TimeGrid& grid = impl_->prepared->scene->time();
  std::vector<double> times;
  for (std::int64_t k = 0; k <= grid.steps(); ++k) times.push_back(grid.time(k));
  return run(times, observer);
}

EnsembleTrajectory Ensemble::run(std::span<const double> times, const Simulator::Observer& observer) {
  if (times.empty() || times[0] != impl_->prepared->scene->time().start) {
    throw Error(Error::Kind::input, "the times of an ensemble begin with the start of its scene");
  }
  EnsembleTrajectory out = impl_->start(times);
  impl_->totals = {};
  impl_->tiles->clear();
  impl_->run_in_lanes(out, observer);
  for (const auto& [i, prepared] : impl_->others) impl_->run_other(i, out, {});
  impl_->summarize(out);
  return out;
}

std::size_t Ensemble::members() const { return impl_->cannot.size(); }
const Prepared& Ensemble::prepared() const { return *impl_->prepared; }
const Report& Ensemble::report() const { return impl_->report; }
const std::vector<Ensemble::Outcome>& Ensemble::outcomes() const { return impl_->outcomes; }

}  // namespace assur
