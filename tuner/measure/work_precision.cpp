#include "measure/work_precision.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "assur/machine.hpp"
#include "measure/motion.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"

namespace assur::measure {
namespace {

constexpr double kWrong = 0.1;  // forward error above which a run has another motion and is not timed

// A prepared way to run the scene. Ways with the same plan share an entrant.
struct Entrant {
  WorkPrecisionRow row = {};
  std::optional<Prepared> prepared = std::nullopt;  // empty until enter()
  std::string essence = {};
  std::uint64_t motion = 0;  // hash of the trajectory
  std::unique_ptr<StepWorkload> step = nullptr;

  [[nodiscard]] bool runs() const { return step != nullptr; }
};

// FNV-1a hash of the bits.
std::uint64_t number_of(std::span<const double> values) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const double v : values) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    hash = (hash ^ bits) * 0x100000001b3;
  }
  return hash;
}

std::optional<double> worst_estimate(const ErrorFigures& e) {
  std::optional<double> worst;
  for (const auto& estimate : {e.estimated_position, e.estimated_velocity, e.estimated_acceleration}) {
    if (estimate) worst = std::max(worst.value_or(0), *estimate);
  }
  return worst;
}

class Comparison {
 public:
  Comparison(const Scene& scene, const WorkPrecisionOptions& options) : scene_(scene), options_(options) {
    if (scene.time().steps() < 1) {
      throw Error(Error::Kind::input, {{"/time", "the scene has no steps to compare; give it a time grid"}});
    }
    out_.steps = scene.time().steps();
  }

  WorkPrecision run() {
    if (!options_.strategies) {
      compare_all();
    } else {
      const std::int64_t accuracies = std::ssize(options_.accuracies);
      expected_ = std::ssize(*options_.strategies) * (accuracies + 1) + accuracies;
      for (const Strategy& s : *options_.strategies) enter_forced({s}, true, true);
      enter_picks();
    }
    race(pointers(), options_.rules);
    return finished();
  }

 private:
  // All solvers; then variations of the fastest one, and fixed iterations in the fastest ones of other formulations.
  void compare_all() {
    const std::vector<Way> all = solvers(scene_, options_.budget);
    expected_ = std::ssize(all) + std::ssize(options_.accuracies);
    for (const Way& way : all) enter_forced(way, false, false);
    enter_picks();
    RaceRules trial = options_.rules;
    trial.most_rounds = trial.least_rounds = std::min(trial.least_rounds, 5);
    race(pointers(), trial);
    struct Leader {
      Strategy strategy;
      Entrant* entrant;
    };
    const auto seconds = [](const Leader& l) { return l.entrant->row.seconds.value_or(HUGE_VAL); };
    std::map<Formulation, Leader> fastest;
    for (const Way& way : all) {
      const Leader leader{way.strategy, find(to_string(way))};
      if (leader.entrant == nullptr || !leader.entrant->row.seconds) continue;
      const auto [at, is_new] = fastest.try_emplace(way.strategy.run.formulation, leader);
      if (!is_new && seconds(leader) < seconds(at->second)) at->second = leader;
    }
    // All later candidates depend on the fastest of these, so they are raced again with all rounds.
    std::vector<Entrant*> leaders;
    for (const auto& [formulation, leader] : fastest) leaders.push_back(leader.entrant);
    race(leaders, options_.rules);
    const auto best = std::min_element(fastest.begin(), fastest.end(), [&](const auto& a, const auto& b) {
      return seconds(a.second) < seconds(b.second);
    });
    std::vector<Way> more;
    for (auto at = fastest.begin(); at != fastest.end(); ++at) {
      const Strategy& solver = at->second.strategy;
      const std::vector<Way> ways = at == best ? variations(solver) : fixed_iterations(solver);
      more.insert(more.end(), ways.begin(), ways.end());
    }
    const auto heeds = [](const Way& way) { return way.knob == Knob::predictor; };
    expected_ =
        done_ + std::ssize(more) + std::ssize(options_.accuracies) * std::count_if(more.begin(), more.end(), heeds);
    for (const Way& way : more) enter_forced(way, heeds(way), false);
  }

  // must: throws if the strategy cannot run.
  void enter_forced(const Way& way, bool with_accuracies, bool must) {
    std::vector<double> accuracies = {0};
    if (with_accuracies) accuracies.insert(accuracies.end(), options_.accuracies.begin(), options_.accuracies.end());
    for (const double accuracy : accuracies) {
      WorkPrecisionRow row;
      row.strategy = to_string(way.strategy);
      row.iterations = way.iterations;
      row.knob = way.knob;
      row.accuracies = {accuracy};
      enter(std::move(row), {.strategy = to_string(way.strategy), .budget = options_.budget, .accuracy = accuracy},
            must);
    }
  }

  void enter_picks() {
    for (const double accuracy : options_.accuracies) {
      WorkPrecisionRow row;
      row.strategy = "auto";
      row.accuracies = row.picked = {accuracy};
      enter(std::move(row), {.budget = options_.budget, .accuracy = accuracy}, true);
    }
  }

  void enter(WorkPrecisionRow row, PrepareOptions how, bool must) {
    if (options_.instruments.stop()) return;
    if (options_.progress) options_.progress(done_, std::max(expected_, done_));
    ++done_;
    how.model = options_.model;
    Entrant e;
    e.row = std::move(row);
    try {
      e.prepared = prepare(scene_, how);
      e.essence = essence(e.prepared->plan()) + " " + std::to_string(e.row.iterations);
      if (e.row.strategy == "auto") e.row.strategy = essence(e.prepared->plan());
      const bool means_nothing =
          e.row.iterations > 0 && preparation(*e.prepared).structure->levels < 2;  // the first level is free
      if (means_nothing || is_known(e) || is_hopeless(e.prepared->plan())) return;
      verify(e);
      if (e.runs() && joins_another(e)) return;
    } catch (const Error& error) {
      if (must && error.kind() != Error::Kind::numerical) throw;
      if (error.kind() == Error::Kind::environment) return;  // `assur backends` says why
      e.row.status = error.what();
      e.step = nullptr;
    }
    if (options_.instruments.stop() && !e.runs()) return;
    entrants_.push_back(std::move(e));
  }

  // True if the same plan with the same settings is known already.
  bool is_known(const Entrant& e) const {
    return e.row.picked.empty() && std::any_of(entrants_.begin(), entrants_.end(), [&](const Entrant& other) {
             const std::vector<double>& asked = other.row.accuracies;
             return other.essence == e.essence &&
                    std::find(asked.begin(), asked.end(), e.row.accuracies[0]) != asked.end();
           });
  }

  // Merges the entrant with another one that has the same plan and the same motion, although its settings differ.
  bool joins_another(const Entrant& e) {
    const auto at = std::find_if(entrants_.begin(), entrants_.end(), [&](const Entrant& other) {
      return other.runs() && other.essence == e.essence && other.motion == e.motion;
    });
    if (at == entrants_.end()) return false;
    const auto add = [](std::vector<double>& to, const std::vector<double>& from) {
      for (const double a : from) {
        if (std::find(to.begin(), to.end(), a) == to.end()) to.push_back(a);
      }
    };
    add(at->row.accuracies, e.row.accuracies);
    add(at->row.picked, e.row.picked);
    return true;
  }

  // Computes the whole motion and its true error.
  void verify(Entrant& e) {
    Simulator simulator(*e.prepared, {.iterations = e.row.iterations});
    const Trajectory motion = simulator.run([&](auto, auto) { return options_.instruments.stop(); });
    const Report& report = simulator.report();
    e.row.status = name(report.status.code);
    if (!report.status.arrived()) return;
    e.row.estimated = worst_estimate(report.error);
    e.motion = number_of(motion.values());
    e.row.error = error_of(e, motion);
    const double worst = e.row.worst_error();
    if (e.row.error && !(worst < kWrong)) {
      e.row.status = "another motion";
      return;
    }
    e.step = std::make_unique<StepWorkload>(*e.prepared, cores_, e.row.iterations);
  }

  std::optional<ForwardError> error_of(const Entrant& e, const Trajectory& motion) {
    if (!out_.no_yardstick.empty()) return std::nullopt;
    const auto known = errors_.find(e.motion);
    if (known != errors_.end()) return known->second;
    try {
      return errors_[e.motion] = forward_error(*e.prepared, motion);
    } catch (const Error& error) {
      if (error.kind() == Error::Kind::input) throw;
      out_.no_yardstick = error.what();
      return std::nullopt;
    }
  }

  Entrant* find(const std::string& strategy) {
    const auto at = std::find_if(entrants_.begin(), entrants_.end(),
                                 [&](const Entrant& e) { return e.row.strategy == strategy && e.row.iterations == 0; });
    return at == entrants_.end() ? nullptr : &*at;
  }

  std::vector<Entrant*> pointers() {
    std::vector<Entrant*> all;
    for (Entrant& e : entrants_) all.push_back(&e);
    return all;
  }

  void race(const std::vector<Entrant*>& entrants, const RaceRules& rules) {
    std::vector<Runner> runners;
    std::vector<WorkPrecisionRow*> rows;
    for (Entrant* e : entrants) {
      e->row.seconds.reset();
      if (!e->runs()) continue;
      runners.push_back({.work = e->step.get()});
      rows.push_back(&e->row);
    }
    (void)measure::race(runners, rules, options_.instruments);
    for (std::size_t i = 0; i < runners.size(); ++i) {
      const Runner& r = runners[i];
      if (r.failed) rows[i]->status = "failed while being timed";
      if (r.seconds.empty()) continue;
      rows[i]->seconds = r.median();
      rows[i]->spread = r.spread();
      rows[i]->rounds = r.seconds.size();
    }
  }

  WorkPrecision finished() {
    out_.interrupted = options_.instruments.stop();
    for (Entrant& e : entrants_) out_.rows.push_back(std::move(e.row));
    std::vector<Trade> trades;
    for (const WorkPrecisionRow& row : out_.rows) trades.push_back(row.trade());
    const std::vector<bool> front = pareto_front(trades);
    for (std::size_t i = 0; i < front.size(); ++i) out_.rows[i].on_front = front[i];
    std::stable_sort(out_.rows.begin(), out_.rows.end(), [](const WorkPrecisionRow& a, const WorkPrecisionRow& b) {
      return a.seconds.value_or(HUGE_VAL) < b.seconds.value_or(HUGE_VAL);
    });
    return std::move(out_);
  }

  const Scene& scene_;
  const WorkPrecisionOptions& options_;
  const std::vector<int> cores_ = this_machine().cores;
  std::vector<Entrant> entrants_;
  std::map<std::uint64_t, ForwardError> errors_;  // by motion
  std::int64_t done_ = 0, expected_ = 0;
  WorkPrecision out_;
};

}  // namespace

double WorkPrecisionRow::worst_error() const {
  if (!error) return kNan;
  return std::fmax(error->position, std::fmax(error->velocity, error->acceleration));
}

Trade WorkPrecisionRow::trade() const { return {seconds.value_or(kNan), worst_error()}; }

const WorkPrecisionRow* WorkPrecision::pick(double accuracy) const {
  const auto at = std::find_if(rows.begin(), rows.end(), [&](const WorkPrecisionRow& row) {
    return std::find(row.picked.begin(), row.picked.end(), accuracy) != row.picked.end();
  });
  return at == rows.end() ? nullptr : &*at;
}

std::optional<double> WorkPrecision::behind(double accuracy) const {
  const WorkPrecisionRow* const chosen = pick(accuracy);
  if (chosen == nullptr || !chosen->seconds) return std::nullopt;
  if (!(chosen->worst_error() <= accuracy)) return std::nullopt;
  return *chosen->seconds / *fastest_within(accuracy)->seconds - 1;
}

const WorkPrecisionRow* WorkPrecision::fastest_within(double error) const {
  const auto at = std::find_if(rows.begin(), rows.end(), [&](const WorkPrecisionRow& row) {
    return row.seconds && row.worst_error() <= error;  // the fastest come first
  });
  return at == rows.end() ? nullptr : &*at;
}

Scene first_steps(const Scene& scene, std::int64_t most) {
  TimeGrid grid = scene.time();
  if (grid.steps() <= most) return scene;
  grid.end = grid.time(most);
  return scene.with_time(grid);
}

WorkPrecision work_precision(const Scene& scene, const WorkPrecisionOptions& options) {
  return Comparison(scene, options).run();
}

}  // namespace assur::measure
