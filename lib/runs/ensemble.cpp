#include "assur/ensemble.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "equations/outputs.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "parallel/team.hpp"
#include "program/needs.hpp"
#include "runs/bound_members.hpp"
#include "runs/memory.hpp"
#include "runs/row_consumers.hpp"
#include "runs/tiles.hpp"
#include "runs/work_queue.hpp"
#include "simulation/run_arguments.hpp"
#include "structure/same_structure.hpp"

namespace assur {

// Members whose figures are kept at once.
constexpr std::size_t kMostLaneRuns = 65'536;
// Members that are prepared at once.
constexpr std::size_t kMostPrepared = 256;

struct Ensemble::Impl {
  // Members of one structure, in tiles.
  struct Class {
    Preparation prepared;
    std::vector<std::size_t> members;
    std::vector<Variant> variants;  // of the members
    std::unique_ptr<Tiles> tiles;
  };

  Impl(std::size_t count, const std::function<Prepared(std::size_t)>& member, StepSettings step_settings)
      : settings(step_settings), cannot(count) {
    refuse_wrong_settings();
    std::exception_ptr first_error;
    for (std::size_t i = 0; i < count; ++i) {
      try {
        take(i, preparation(member(i)));
      } catch (const Error& e) {
        if (e.kind() == Error::Kind::environment) throw;
        if (!first_error) first_error = std::current_exception();
        cannot[i] = e.what();
      }
    }
    if (!prepared && first_error) std::rethrow_exception(first_error);
    if (!prepared) throw Error(Error::Kind::input, "an ensemble needs at least one member");
    make_tiles(classes.begin() + 1);
  }

  Impl(std::unique_ptr<BoundMembers> of_table, StepSettings step_settings)
      : settings(step_settings), bound(std::move(of_table)) {
    refuse_wrong_settings();
    columns = bound->columns();
    time = bound->time();
    meet_bound(true);
  }

  void refuse_wrong_settings() const {
    check_settings(settings);
    const std::string reason = why_not(Path::ensemble, needs_of(settings));
    if (!reason.empty()) {
      throw Error(Error::Kind::input, reason + ", which an ensemble does not support; set it to 0");
    }
  }

  // Gets ready for the members of the table. anew: the tiles cannot serve them.
  void meet_bound(bool anew) {
    if (!prepared && bound->first() != nullptr) {
      prepared = *bound->first();
      prepared->plan.run.chunks = 1;
    }
    const std::size_t most = std::min(bound->count(), kMostLaneRuns);
    if (anew || most > std::min(cannot.size(), kMostLaneRuns)) {
      bound_tiles.reset();
      if (bound->why_not().empty()) bound_tiles = make_tiles(*prepared, most, bound.get());
    }
    cannot.assign(bound->count(), {});
    report = {};
    outcomes.clear();
  }

  // The team, with as many threads of the plan as `pieces` of work keep busy.
  Team& team_for(std::size_t pieces) {
    const std::size_t most = prepared ? idx(prepared->plan.run.threads) : 1;
    const auto size = static_cast<int>(std::clamp<std::size_t>(pieces, 1, most));
    if (!team || team->size() < size) team = std::make_unique<Team>(size, settings.pin_to);
    return *team;
  }

  // Workers for all threads that the team may ever have.
  [[nodiscard]] std::unique_ptr<Tiles> make_tiles(const Preparation& of, std::size_t members,
                                                  const BoundMembers* table = nullptr) const {
    return std::make_unique<Tiles>(of, settings, members, prepared->plan.run.threads, table);
  }

  // A structure that only one member has is not worth a tile; classes before `first` get one nevertheless.
  void make_tiles(std::vector<Class>::iterator first) {
    const auto single = std::partition(first, classes.end(), [](const Class& c) { return c.members.size() > 1; });
    for (auto c = single; c != classes.end(); ++c) others.emplace(c->members[0], std::move(c->prepared));
    classes.erase(single, classes.end());
    std::size_t pieces = others.size();
    for (Class& c : classes) {
      c.tiles = make_tiles(c.prepared, c.members.size());
      pieces += c.tiles->tiles(c.members.size());
    }
    (void)team_for(pieces);
  }

  void take(std::size_t i, Preparation p) {
    p.plan.run.chunks = 1;
    if (!prepared) {
      prepared = p;
      columns = column_names(*p.structure->system);
      time = p.time;
    } else if (column_names(*p.structure->system) != columns) {
      cannot[i] = "its outputs differ from those of the first member";
      return;
    }
    if (p.time.start != time.start) {
      others.emplace(i, std::move(p));
      return;
    }
    auto c = std::find_if(classes.begin(), classes.end(),
                          [&](const Class& of) { return same_structure(*of.prepared.structure, *p.structure); });
    if (c == classes.end()) c = classes.insert(c, {p, {}, {}, nullptr});
    c->members.push_back(i);
    c->variants.push_back({p.structure->system, p.structure->start, p.time.start, p.reselect});
  }

  // Where the rows of the members go.
  struct Results {
    std::span<const double> times;
    std::vector<std::size_t>& rows;  // receives the number of rows of each member
    double* values = nullptr;        // members x times x columns, or
    std::function<RowConsumer&(std::size_t member)> consumer = {};
    std::size_t columns = 0;

    [[nodiscard]] double* values_of(std::size_t member) const { return values + member * times.size() * columns; }
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
      if (!cannot[i].empty()) outcomes[i].status.code = Code::not_assembled;
    }
  }

  void run(const Results& results, const Observer& observer) {
    start(results);
    const auto rows = [&](std::size_t members) { return static_cast<std::int64_t>(members * results.times.size()); };
    const std::int64_t of = rows(static_cast<std::size_t>(std::count(cannot.begin(), cannot.end(), std::string())));
    Progress progress{observer, of, 0, false};
    if (bound) {
      run_bound(results, progress);
    } else {
      run_prepared(results, progress);
    }
    summarize(results);
  }

  void interrupt(std::size_t i, const Results& results) {
    outcomes[i].status = {Code::interrupted, {}, results.times[0]};
  }

  // A member that runs alone.
  struct LoneRun {
    std::size_t member = 0;
    RowConsumer* consumer = nullptr;
    Report report;
    bool begun = false;
  };

  // Runs the tiles of all classes, and then the members that run alone, in one queue.
  void run_prepared(const Results& results, Progress& progress) {
    struct Piece {
      std::size_t of, tile;
    };
    std::vector<std::vector<LaneRun>> runs;
    std::vector<Piece> pieces;
    for (Class& c : classes) {
      std::vector<LaneRun> own(c.members.size());
      for (std::size_t i = 0; i < own.size(); ++i) own[i].variant = c.variants[i];
      set_results(own, c.members, results);
      for (std::size_t t = 0; t < c.tiles->tiles(own.size()); ++t) pieces.push_back({runs.size(), t});
      runs.push_back(std::move(own));
    }
    const std::size_t tiles = pieces.size();
    std::vector<LoneRun> alone;
    for (const auto& [i, other] : others) {
      alone.push_back({i, results.values == nullptr ? &results.consumer(i) : nullptr, {}, false});
    }
    run_queue(
        team_for(tiles + alone.size()), tiles + alone.size(),
        [&](int rank, std::size_t p, const auto& proceed) {
          if (p >= tiles) {
            run_alone(alone[p - tiles], results, proceed);
          } else {
            classes[pieces[p].of].tiles->run(rank, runs[pieces[p].of], pieces[p].tile, proceed);
          }
        },
        progress);
    for (std::size_t c = 0; c < classes.size(); ++c) {
      take_results(runs[c], classes[c].members, results, progress);
      totals.merge(classes[c].tiles->totals());
    }
    for (const LoneRun& run : alone) take_results(run, results, progress);
  }

  // Runs the members of the table: in lanes where they can be bound, and prepared where not.
  void run_bound(const Results& results, Progress& progress) {
    std::vector<std::size_t> unbound, members;
    if (bound_tiles) bound_tiles->clear();
    for (std::size_t begin = 0; begin < cannot.size(); begin += kMostLaneRuns) {
      members.resize(std::min(kMostLaneRuns, cannot.size() - begin));
      std::iota(members.begin(), members.end(), begin);
      if (!bound_tiles) {
        unbound.insert(unbound.end(), members.begin(), members.end());
        continue;
      }
      std::vector<LaneRun> runs(members.size());
      for (std::size_t i = 0; i < runs.size(); ++i) runs[i].member = members[i];
      set_results(runs, members, results);
      const std::size_t tiles = bound_tiles->tiles(runs.size());
      run_queue(
          team_for(tiles), tiles,
          [&](int rank, std::size_t tile, const auto& proceed) { bound_tiles->run(rank, runs, tile, proceed); },
          progress);
      take_results(runs, members, results, progress);
      for (const LaneRun& run : runs) {
        if (run.unbound) unbound.push_back(run.member);
      }
    }
    if (bound_tiles) totals.merge(bound_tiles->totals());
    for (std::size_t begin = 0; begin < unbound.size(); begin += kMostPrepared) {
      run_unbound(std::span(unbound).subspan(begin, std::min(kMostPrepared, unbound.size() - begin)), results,
                  progress);
    }
    if (unbound.empty()) return;
    report.fallbacks.push_back(
        std::to_string(unbound.size()) + " of " + std::to_string(cannot.size()) +
        " members were prepared one by one, because " +
        (bound->why_not().empty()
             ? "their start posture does not follow from their guess group by group, or their equations differ"
             : bound->why_not()));
  }

  // Prepares members of the table, and runs them.
  void run_unbound(std::span<const std::size_t> members, const Results& results, Progress& progress) {
    std::vector<std::optional<Preparation>> made(members.size());
    std::atomic<std::size_t> next = 0;
    if (!progress.stopped) {
      team_for(members.size()).run([&](int) {
        for (std::size_t k; (k = next++) < members.size();) {
          try {
            made[k] = bound->prepare(members[k]);
          } catch (const Error& e) {
            if (e.kind() == Error::Kind::environment) throw;
            outcomes[members[k]].cannot = e.what();
          }
        }
      });
    }
    for (std::size_t k = 0; k < members.size(); ++k) {
      const std::size_t i = members[k];
      if (progress.stopped) {
        interrupt(i, results);
        continue;
      }
      if (made[k]) take(i, std::move(*made[k]));
      made[k].reset();
      if (outcomes[i].cannot.empty()) outcomes[i].cannot = std::exchange(cannot[i], {});
      if (!outcomes[i].cannot.empty()) outcomes[i].status.code = Code::not_assembled;
    }
    make_tiles(classes.begin());
    run_prepared(results, progress);
    classes.clear();
    others.clear();
  }

  // Says where the rows of runs go.
  static void set_results(std::span<LaneRun> runs, std::span<const std::size_t> members, const Results& results) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      runs[i].times = results.times;
      if (results.values != nullptr) {
        runs[i].rows = results.values_of(members[i]);
      } else {
        runs[i].consumer = &results.consumer(members[i]);
      }
    }
  }

  // Members that are not bound keep their outcomes.
  void take_results(std::span<LaneRun> runs, std::span<const std::size_t> members, const Results& results,
                    Progress& progress) {
    mark_not_begun(runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      LaneRun& run = runs[i];
      if (run.unbound) continue;
      progress.done += static_cast<std::int64_t>(results.times.size());
      results.rows[members[i]] = run.done;
      totals.error.merge(run.error);
      outcomes[members[i]] = {run.status, run.reached,    std::move(run.cannot),
                              run.alone,  run.alone_from, std::move(run.events)};
      note(members[i], run.fallbacks);
    }
  }

  // Called by all threads, for members of their own.
  void run_alone(LoneRun& run, const Results& results, const std::function<bool(std::size_t rows)>& proceed) {
    Preparation p = others.at(run.member);
    p.plan.run.threads = 1;
    run.begun = true;
    Outcome& outcome = outcomes[run.member];
    outcome.alone = true;
    outcome.alone_from = results.times[0];
    std::optional<Simulator> simulator;
    try {
      simulator.emplace(Preparation::shared(std::move(p)), settings);
    } catch (const Error& e) {
      if (e.kind() != Error::Kind::numerical) throw;
      outcome.cannot = e.what();
      outcome.status.code = Code::singular;
      return;
    }
    const Trajectory t = simulator->run(
        results.times, [&](std::int64_t done, std::int64_t) { return !proceed(static_cast<std::size_t>(done)); });
    if (run.consumer == nullptr) {
      std::copy(t.values().begin(), t.values().end(), results.values_of(run.member));
    } else {
      for (std::size_t k = 0; k < t.rows(); ++k) run.consumer->add_row(t.times()[k], t.row(k).data());
      if (t.rows() > 0) run.consumer->finish();
    }
    run.report = simulator->report();
    results.rows[run.member] = t.rows();
    outcome.status = run.report.status;
    outcome.reached = run.report.reached;
    outcome.events = run.report.events;
  }

  void take_results(const LoneRun& run, const Results& results, Progress& progress) {
    if (!run.begun) {
      interrupt(run.member, results);
      return;
    }
    progress.done += static_cast<std::int64_t>(results.times.size());
    note(run.member, run.report.fallbacks);
    totals.merge({run.report.counters, run.report.error, run.report.effort});
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

  StepSettings settings;
  std::unique_ptr<BoundMembers> bound;        // null: the members were prepared
  std::unique_ptr<Tiles> bound_tiles;         // null: no member is bound
  std::unique_ptr<Team> team;                 // threads of the plan, as many as were needed so far
  std::vector<std::string> cannot;            // reason why the member cannot be started; empty: it can
  std::optional<Preparation> prepared;        // as Ensemble::prepared()
  std::vector<std::string> columns;           // of all members
  TimeGrid time;                              // of all members
  std::vector<Class> classes;                 // the first one is that of `prepared`
  std::map<std::size_t, Preparation> others;  // members that run alone
  Totals totals;
  Report report;
  std::vector<Outcome> outcomes;
};

Ensemble::Ensemble(std::size_t members, const std::function<Prepared(std::size_t)>& member, StepSettings settings)
    : impl_(std::make_unique<Impl>(members, member, settings)) {}
Ensemble::Ensemble(std::unique_ptr<BoundMembers> members, StepSettings settings)
    : impl_(std::make_unique<Impl>(std::move(members), settings)) {}
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

void check_begin(std::span<const double> times, const TimeGrid& grid) {
  if (times.empty() || times[0] != grid.start) {
    throw Error(Error::Kind::input, "the times of an ensemble must begin with time.start of its scene");
  }
  check_times(times);
}

}  // namespace

EnsembleTrajectory Ensemble::run(const Observer& observer) { return run(times_of(impl_->time), observer); }

EnsembleTrajectory Ensemble::run(std::span<const double> times, const Observer& observer) {
  check_begin(times, impl_->time);
  EnsembleTrajectory out;
  out.columns_ = impl_->columns;
  out.times_.assign(times.begin(), times.end());
  check_memory(members() * times.size(), out.columns_.size());
  out.values_ = shared_rows(members() * times.size() * out.columns_.size());
  impl_->run({out.times_, out.rows_, out.values_.get(), {}, out.columns_.size()}, observer);
  Impl::fill_missing_rows(out);
  return out;
}

EnsembleTrajectory Ensemble::run(const std::vector<std::string>& columns, const Observer& observer) {
  return run(columns, times_of(impl_->time), observer);
}

EnsembleTrajectory Ensemble::run(const std::vector<std::string>& columns, std::span<const double> times,
                                 const Observer& observer) {
  check_begin(times, impl_->time);
  const std::vector<std::size_t> indices = indices_of(columns, impl_->columns);
  EnsembleTrajectory out;
  out.columns_ = columns;
  out.times_.assign(times.begin(), times.end());
  const std::size_t size = times.size() * columns.size();  // of a member
  check_memory(members() * times.size(), columns.size());
  out.values_ = shared_rows(members() * size);
  std::vector<RowStore> stores;
  for (std::size_t i = 0; i < members(); ++i) stores.emplace_back(indices, out.values_.get() + i * size);
  impl_->run({out.times_, out.rows_, nullptr, [&](std::size_t i) -> RowConsumer& { return stores[i]; }}, observer);
  for (const std::size_t rows : out.rows_) {
    impl_->report.counters.stored_values += static_cast<std::int64_t>(rows * columns.size());
  }
  Impl::fill_missing_rows(out);
  return out;
}

EnsembleSummary Ensemble::summarize(const std::vector<std::string>& columns, const Observer& observer) {
  return summarize(columns, times_of(impl_->time), observer);
}

EnsembleSummary Ensemble::summarize(const std::vector<std::string>& columns, std::span<const double> times,
                                    const Observer& observer) {
  check_begin(times, impl_->time);
  const std::vector<std::size_t> indices = indices_of(columns, impl_->columns);
  EnsembleSummary out;
  out.columns_ = columns;
  check_memory(members() * columns.size(), sizeof(ColumnSummary) / sizeof(double));
  out.values_.resize(members() * columns.size());
  std::vector<RowSummary> summaries;
  for (std::size_t i = 0; i < members(); ++i) {
    summaries.emplace_back(indices, std::span(out.values_).subspan(i * columns.size(), columns.size()));
  }
  impl_->run({times, out.rows_, nullptr, [&](std::size_t i) -> RowConsumer& { return summaries[i]; }}, observer);
  return out;
}

void Ensemble::stream(const RowSelection& selection, const RowSink& sink, const Observer& observer) {
  stream(selection, sink, times_of(impl_->time), observer);
}

void Ensemble::stream(const RowSelection& selection, const RowSink& sink, std::span<const double> times,
                      const Observer& observer) {
  check_begin(times, impl_->time);
  const std::vector<std::size_t> indices = selected(selection, sink, impl_->columns);
  std::vector<RowStream> streams;
  for (std::size_t i = 0; i < members(); ++i) streams.emplace_back(i, indices, selection, sink);
  std::vector<std::size_t> rows;
  impl_->run({times, rows, nullptr, [&](std::size_t i) -> RowConsumer& { return streams[i]; }}, observer);
}

void Ensemble::bind(std::vector<double> values) {
  if (!impl_->bound) {
    throw Error(Error::Kind::input,
                "the members of this ensemble were prepared one by one; an ensemble with a table of "
                "values takes another table");
  }
  try {
    impl_->meet_bound(impl_->bound->take(std::move(values)));
  } catch (const Error& e) {
    // Recording began, and a file of the scene can no longer be read: the tiles have lost what they repeat.
    if (e.kind() == Error::Kind::environment) impl_->bound_tiles.reset();
    throw;
  }
}

const std::vector<std::string>& Ensemble::columns() const { return impl_->columns; }
std::size_t Ensemble::members() const { return impl_->cannot.size(); }
Prepared Ensemble::prepared() const {
  if (impl_->prepared) return Preparation::shared(*impl_->prepared);
  throw Error(Error::Kind::numerical,
              "no member of the ensemble can be assembled, nor can the scene as written; the "
              "outcomes of a run have the reasons");
}
const TimeGrid& Ensemble::time() const { return impl_->time; }
const Report& Ensemble::report() const { return impl_->report; }
const std::vector<Ensemble::Outcome>& Ensemble::outcomes() const { return impl_->outcomes; }

}  // namespace assur
