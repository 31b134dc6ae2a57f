#include "assur/ensemble.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "numbers.hpp"
#include "scene/outputs.hpp"
#include "side_by_side/memory.hpp"
#include "side_by_side/row_summary.hpp"
#include "side_by_side/run_arguments.hpp"
#include "side_by_side/tiles.hpp"
#include "signals/columns.hpp"
#include "structure/same_structure.hpp"

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
    // A structure that only one member has is not worth a tile.
    const auto single =
        std::partition(classes.begin() + 1, classes.end(), [](const Class& c) { return c.members.size() > 1; });
    for (auto c = single; c != classes.end(); ++c) others.emplace(c->members[0], std::move(c->prepared));
    classes.erase(single, classes.end());
    for (Class& c : classes) c.tiles = std::make_unique<Tiles>(c.prepared, limits, c.members.size());
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
    if (p.time.start != prepared->time.start) {
      others.emplace(i, std::move(p));
      return;
    }
    auto c = std::find_if(classes.begin(), classes.end(),
                          [&](const Class& of) { return same_structure(*of.prepared.structure, *p.structure); });
    if (c == classes.end()) c = classes.insert(c, {p, {}, {}, nullptr});
    c->members.push_back(i);
    c->variants.push_back({p.structure->system, p.structure->start, p.time.start, p.reselect});
  }

  // Members of one structure, in tiles.
  struct Class {
    Prepared prepared;
    std::vector<std::size_t> members;
    std::vector<Variant> variants;  // of the members
    std::unique_ptr<Tiles> tiles;
  };

  // Where the rows of the members go.
  struct Results {
    std::span<const double> times;
    std::vector<std::size_t>& rows;     // receives the number of rows of each member
    double* values = nullptr;           // members x times x columns, or
    std::span<RowSummary> summaries{};  // one for each member
  };

  void start(const Results& results) {
    report = {};
    totals = {};
    for (Class& c : classes) c.tiles->clear();
    outcomes.assign(cannot.size(), {});
    results.rows.assign(cannot.size(), 0);
    for (std::size_t i = 0; i < cannot.size(); ++i) {
      outcomes[i].cannot = cannot[i];
      outcomes[i].reached = results.times[0];
      if (!cannot[i].empty()) outcomes[i].status.code = Code::not_converged;
    }
  }

  void run(const Results& results, const Simulator::Observer& observer) {
    start(results);
    const auto rows = [&](std::size_t members) { return static_cast<std::int64_t>(members * results.times.size()); };
    const std::int64_t of = rows(static_cast<std::size_t>(std::count(cannot.begin(), cannot.end(), std::string())));
    bool stopped = false;
    std::int64_t before = 0;
    Simulator::Observer of_all;
    if (observer) {
      of_all = [&](std::int64_t done, std::int64_t) {
        stopped = !observer(before + done, of);
        return !stopped;
      };
    }
    for (Class& c : classes) {
      run_in_lanes(c, results, of_all, stopped);
      before += rows(c.members.size());
    }
    for (const auto& [i, other] : others) {
      if (stopped) {
        outcomes[i].status = {Code::interrupted, {}, results.times[0]};
        continue;
      }
      run_other(i, results, of_all);
      before += rows(1);
    }
    summarize(results);
  }

  // Runs the members of one structure, in tiles; a free thread takes the next tile.
  void run_in_lanes(Class& c, const Results& results, const Simulator::Observer& observer, bool stopped) {
    if (stopped) {
      for (const std::size_t i : c.members) outcomes[i].status = {Code::interrupted, {}, results.times[0]};
      return;
    }
    std::vector<LaneRun> runs(c.members.size());
    for (std::size_t i = 0; i < runs.size(); ++i) {
      runs[i].variant = c.variants[i];
      runs[i].times = results.times;
      if (results.values != nullptr) {
        runs[i].rows = results.values + c.members[i] * results.times.size() * columns.size();
      } else {
        runs[i].summary = &results.summaries[c.members[i]];
      }
    }
    c.tiles->run(runs, observer, 0);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      LaneRun& run = runs[i];
      results.rows[c.members[i]] = run.done;
      totals.error.merge(run.error);
      outcomes[c.members[i]] = {run.status, run.reached,    std::move(run.cannot),
                                run.alone,  run.alone_from, std::move(run.events)};
      note(c.members[i], run.fallbacks);
    }
    totals.merge(c.tiles->totals());
  }

  void run_other(std::size_t i, const Results& results, const Simulator::Observer& observer) {
    Prepared p = others.at(i);
    p.plan.run.threads = 1;
    Outcome& outcome = outcomes[i];
    outcome.alone = true;
    outcome.alone_from = outcome.reached = results.times[0];
    std::optional<Simulator> simulator;
    try {
      simulator.emplace(std::move(p), limits);
    } catch (const Error& e) {
      if (e.kind() != Error::Kind::numerical) throw;
      outcome.cannot = e.what();
      outcome.status.code = Code::singular;
      return;
    }
    const Trajectory t = simulator->run(results.times, observer);
    if (results.values != nullptr) {
      std::copy(t.values().begin(), t.values().end(), results.values + i * results.times.size() * columns.size());
    } else {
      for (std::size_t k = 0; k < t.rows(); ++k) results.summaries[i].take(t.times()[k], t.row(k).data());
    }
    const Report& its = simulator->report();
    results.rows[i] = t.rows();
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

  void summarize(const Results& results) {
    report.counters = totals.counters;
    report.counters.stored_values = 0;
    report.error = totals.error;
    report.effort = totals.effort;
    report.reached = results.times.back();
    std::size_t alone = 0;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      const Outcome& o = outcomes[i];
      if (results.values != nullptr) {
        report.counters.stored_values += static_cast<std::int64_t>(results.rows[i] * columns.size());
      }
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
  std::vector<std::string> cannot;         // reason why the member cannot be started; empty: it can
  std::optional<Prepared> prepared;        // that of the first member that can be started
  std::vector<std::string> columns;        // of all members
  std::vector<Class> classes;              // the first one is that of `prepared`
  std::map<std::size_t, Prepared> others;  // members that run alone
  Totals totals;
  Report report;
  std::vector<Outcome> outcomes;
};

Ensemble::Ensemble(std::size_t members, const std::function<Prepared(std::size_t)>& member, StepLimits limits)
    : impl_(std::make_unique<Impl>(members, member, limits)) {}
Ensemble::Ensemble(Ensemble&&) noexcept = default;
Ensemble& Ensemble::operator=(Ensemble&&) noexcept = default;
Ensemble::~Ensemble() = default;

namespace {

std::vector<double> times_of(const TimeGrid& grid) {
  check_memory(static_cast<std::size_t>(grid.steps()) + 1, 2);  // memory of the times
  std::vector<double> times;
  for (std::int64_t k = 0; k <= grid.steps(); ++k) times.push_back(grid.time(k));
  return times;
}

void check_begin(std::span<const double> times, const Prepared& prepared) {
  if (times.empty() || times[0] != prepared.time.start) {
    throw Error(Error::Kind::input, "the times of an ensemble must begin with time.start of its scene");
  }
  check_times(times);
}

}  // namespace

EnsembleTrajectory Ensemble::run(const Simulator::Observer& observer) {
  return run(times_of(impl_->prepared->time), observer);
}

EnsembleTrajectory Ensemble::run(std::span<const double> times, const Simulator::Observer& observer) {
  check_begin(times, *impl_->prepared);
  EnsembleTrajectory out;
  out.columns_ = impl_->columns;
  out.times_.assign(times.begin(), times.end());
  check_memory(members() * times.size(), out.columns_.size());
  out.values_.reset(new double[members() * times.size() * out.columns_.size()]);
  impl_->run({out.times_, out.rows_, out.values_.get(), {}}, observer);
  Impl::fill_missing_rows(out);
  return out;
}

EnsembleSummary Ensemble::summarize(const std::vector<std::string>& columns, const Simulator::Observer& observer) {
  return summarize(columns, times_of(impl_->prepared->time), observer);
}

EnsembleSummary Ensemble::summarize(const std::vector<std::string>& columns, std::span<const double> times,
                                    const Simulator::Observer& observer) {
  check_begin(times, *impl_->prepared);
  std::vector<std::size_t> indices;
  for (const std::string& column : columns) indices.push_back(column_index(impl_->columns, column));
  EnsembleSummary out;
  out.columns_ = columns;
  check_memory(members() * columns.size(), sizeof(ColumnSummary) / sizeof(double));
  out.values_.resize(members() * columns.size());
  std::vector<RowSummary> summaries;
  for (std::size_t i = 0; i < members(); ++i) {
    summaries.emplace_back(indices, std::span(out.values_).subspan(i * columns.size(), columns.size()));
  }
  impl_->run({times, out.rows_, nullptr, summaries}, observer);
  for (RowSummary& summary : summaries) summary.finish();
  return out;
}

std::size_t Ensemble::members() const { return impl_->cannot.size(); }
const Prepared& Ensemble::prepared() const { return *impl_->prepared; }
const Report& Ensemble::report() const { return impl_->report; }
const std::vector<Ensemble::Outcome>& Ensemble::outcomes() const { return impl_->outcomes; }

}  // namespace assur
