// What a simulator and a saved state hold.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assur/simulator.hpp"
#include "equations/outputs.hpp"
#include "errors/error_estimate.hpp"
#include "index.hpp"
#include "motion/continuation.hpp"
#include "numbers.hpp"
#include "outputs/angle_turns.hpp"
#include "outputs/columns.hpp"
#include "outputs/output_program.hpp"
#include "outputs/output_steps.hpp"
#include "program/needs.hpp"
#include "program/step_rules.hpp"
#include "simulation/output_slopes.hpp"

namespace assur {

struct SimulatorState::Impl {
  struct Snapshot {
    std::shared_ptr<const Preparation> first, prepared;  // at the start of the run; now, perhaps with other equations
    Continuation::Snapshot motion;
    ErrorEstimate::Snapshot estimate;
    std::int64_t branch_checks = 0;
    Status verdict, doubt;
    std::vector<double> row;
    std::vector<double> divisors;
    bool in_one_piece = true;  // the posture was reached by a step that was not divided
  };
  Snapshot now;
  // For Simulator::retreat() if the step was divided, else without meaning. Simulators and states share no snapshots,
  // so that a simulator may write to its own ones and allocates none.
  Snapshot inside;
};

struct Simulator::Impl {
  using Snapshot = SimulatorState::Impl::Snapshot;

  // Only this part of the accuracy is used: conditions may grow before they are measured again, independently at each
  // level.
  static constexpr double kMargin = 16;
  static constexpr int kMostLevels = 8;      // further levels are ignored
  static constexpr double kLoosest = 1e-6;   // largest residual at which an equation counts as solved
  static constexpr int kMostPostponed = 16;  // measurements of errors in a row for which a deadline left no time

  // start() or restore() sets the posture.
  Impl(std::shared_ptr<const Preparation> p, StepSettings l)
      : owned(std::move(p)),
        prepared(*owned),
        first(owned),
        settings(l),
        structure(*prepared.structure),
        system(*structure.system),
        motion(prepared, settings, report, events),
        columns(column_names(system)),
        outputs(system, motion.layout().address),
        turns({&outputs, 1}),
        estimate(structure, motion.layout(), {&outputs, 1}, prepared.plan.accuracy),
        has_functions(needs_of(structure).has_any({Need::functions_in_equations, Need::functions_in_laws})) {
    std::vector<std::uint8_t> read(motion.layout().size, 0);
    outputs.mark(read);
    const bool has_code = prepared.code != nullptr && motion.levels().threads() == 1;
    if (has_code) output_steps = OutputSteps::of_one(outputs, *prepared.code);
    if (output_steps) {
      turns.use(*output_steps);
    } else {
      outputs.find_rows(motion.layout().size);
    }
    motion.keep_what_is_read(std::move(read));
    motion.follow(turns);
    row.resize(columns.size());
    divisors.resize(outputs.measures());
    checks = sorted(structure.checks);
    motion.before_dividing([this] {
      undivided = false;
      keep_start_of_step(true);
    });
    for (auto* kept : {&inside, &divided}) *kept = std::make_unique<Snapshot>();
    clear();
  }
  Impl(std::shared_ptr<const Preparation> p, StepSettings l, double start_time) : Impl(std::move(p), l) {
    start(start_time, structure.start);
  }

  static std::vector<std::int32_t> sorted(std::vector<std::int32_t> equations) {
    std::sort(equations.begin(), equations.end());
    return equations;
  }

  void clear() {
    fresh = false;
    report = Report{};
    reselections = 0;
    earlier_effort = {};
    earlier_error = {};
    own_lines = 0;
    events.clear();
    const System* const of[] = {&system};
    estimate.restart(of, motion.inputs().evaluated(), &motion.inputs());
    doubt = verdict = {};
    in_one_piece = true;
    began = nullptr;
    undivided = true;
  }

  // Starts from a posture (all coordinates) at a time: the start of the run, or another posture of the same motion.
  // before: the motion up to this posture, with another set of the redundant equations.
  void start(double time, const std::vector<double>& posture, Impl* before = nullptr) {
    clear();
    motion.start(time, posture, before != nullptr ? &before->motion : nullptr);
    if (before == nullptr) {
      fill_row();
      choose_convergence();
      (void)report_verdict(time);
      for (auto* kept : {&inside, &divided}) save(**kept, false);  // so that steps allocate nothing
      return;
    }
    turns.continue_from(before->row);
    fill_row();
    estimate.continue_from(before->estimate);
    doubt = before->doubt;
    verdict = before->verdict;
  }

  // ---- one step

  void begin_step() {
    fresh = false;
    began = nullptr;
    undivided = true;
    motion.count_rejected_from(0);
    motion.join_events_from(0);
    motion.start_clock();
  }

  Status step_to(double t, bool may_reselect) {
    Stride stride;
    return step_to(t, may_reselect, stride);
  }

  Status step_to(double t, bool may_reselect, Stride& stride) {
    const double from = motion.time();
    Status status;
    try {
      status = motion.step_to(t, may_reselect, stride);
    } catch (...) {
      if (motion.time() != from) fill_row();
      in_one_piece = in_one_piece && undivided;
      throw;
    }
    if (motion.time() != from) fill_row();
    if (t != from) report.status = status.ok() ? doubt : status;
    return status;
  }

  // ---- accuracy

  // Checks whether the posture that was reached from time `from` has the required accuracy.
  Status check_accuracy(double from) {
    const double* const q[3] = {motion.at(0), motion.at(1), motion.at(2)};
    const double now = motion.time();
    const bool due =
        estimate.due(report.counters.branch_checks, {&now, 1}, q, motion.errors().worst(), divisors.data());
    if (due || motion.on_change_point()) choose_convergence();
    if (postponed >= kMostPostponed) verdict = {Code::inaccurate, {}, kInfinity};
    return verdict.ok() && !motion.turn_guessed() ? Status{} : report_verdict(from);
  }

  Status report_verdict(double from) {
    Status s = verdict;
    if (motion.turn_guessed()) {  // the opposite sense of rotation gives an angle that differs by a whole turn
      s = {Code::inaccurate, s.where, std::max(s.figure, kTurn)};
      ErrorFigures turn;
      turn.estimated_position = kTurn;
      earlier_error.merge(turn);
    }
    if (s.ok()) return {};
    record_doubt(from, s);
    if (doubt.ok()) {
      doubt = s;
      if (report.status.arrived()) report.status = doubt;
    }
    return s;
  }

  // Consecutive steps in doubt become one event with the worst of their figures.
  void record_doubt(double from, const Status& s) {
    Noticed* event = events.last();
    if (event == nullptr || event->kind != s.code || event->until != from) {
      Noticed doubtful{from, motion.time(), only_group(s.where), s.code, s.figure};
      doubtful.structure = prepared.structure;
      events.add(std::move(doubtful));
      event = events.last();
    }
    event->until = motion.time();
    if (event->figure < s.figure) {
      event->figure = s.figure;
      event->about = only_group(s.where);
      event->structure = prepared.structure;
      if (event->told) event->told->group = structure.name_of(s.where);
    }
    if (event->missing.count == 0) event->missing = missing_from(row);
  }

  // If the deadline passes before the errors are measured, the next step measures them.
  void choose_convergence() {
    if (!measure()) {
      ++postponed;
      return;
    }
    postponed = 0;
    if (estimate.in_doubt() && motion.converged() > estimate.best() && motion.polish(estimate.best())) {
      fill_row();
      (void)measure();
    }
    double converged = kConverged;
    if (prepared.plan.accuracy > 0 && estimate.may_loosen()) {
      const double margin = kMargin * std::clamp(structure.levels, 1, kMostLevels);
      converged = std::clamp(estimate.residual_for(prepared.plan.accuracy / margin), kConverged, kLoosest);
    }
    // Solves as exactly as possible if errors are in doubt otherwise.
    if (motion.converged() == 0 && estimate.close_to_doubt()) converged = 0;
    motion.converge_to(converged);
    estimate.loosen(converged > kConverged);
    settle();
  }

  // Adds the measurement to the errors of the run, and makes it the status of the step.
  void settle() {
    estimate.keep();
    verdict = {};
    if (!estimate.in_doubt()) return;
    const auto [pack, lane] = estimate.worst_of();
    const std::span<const Pack> packs = motion.packs();
    verdict = {Code::inaccurate, packs.empty() ? Place{} : Place::group(packs[pack].groups[idx(lane)]),
               estimate.now().worst()};
  }

  bool measure(bool in_time = true) {
    const double* const q[3] = {motion.at(0), motion.at(1), motion.at(2)};
    const double now = motion.time();
    const double* const of = row.data();
    estimate.contradict(0, motion.contradiction());
    return estimate.measure(
        {&now, 1}, q, {&of, 1}, divisors.data(), [&](const auto& work) { motion.levels().each(work); },
        [&] { return in_time && motion.deadline_passed(); });
  }

  std::vector<GroupFigures> examine() {
    fresh = false;
    (void)measure(false);
    settle();
    (void)report_verdict(motion.time());
    std::vector<GroupFigures> all(structure.groups.size());
    for (Pack& pack : motion.packs()) {
      GroupSolver& solver = motion.levels().solver(pack);
      const GroupHealth health = solver.examine(pack, motion.at(0));
      const std::size_t w = idx(solver.lanes());
      for (std::size_t lane = 0; lane < pack.groups.size(); ++lane) {
        GroupFigures& of = all[idx(pack.groups[lane])];
        of = {pack.groups[lane], health.residual[lane], health.condition[lane], 0};
        for (std::size_t i = 0; i < idx(solver.group_class().n); ++i) {
          of.estimated_error = std::max(of.estimated_error, estimate.of_coordinate(pack.unknowns + i * w + lane));
        }
      }
    }
    return all;
  }

  // ---- going back

  void save(Snapshot& into, bool in_step) {
    into.first = first;
    into.prepared = owned;
    motion.save(into.motion, in_step);
    estimate.save(into.estimate);
    into.branch_checks = report.counters.branch_checks;
    into.verdict = verdict;
    into.doubt = doubt;
    into.row = row;
    into.divisors = divisors;
    into.in_one_piece = in_one_piece;
  }

  // The equations must be the same.
  void restore(const Snapshot& from) {
    fresh = false;
    motion.restore(from.motion);
    estimate.restore(from.estimate, report.counters.branch_checks - from.branch_checks);
    verdict = from.verdict;
    doubt = from.doubt;
    row = from.row;
    divisors = from.divisors;
    in_one_piece = from.in_one_piece;
  }

  // Called before a step is divided or fails (in_step), or before a step that may throw after it has arrived.
  void keep_start_of_step(bool in_step) {
    if (began != nullptr) return;
    Snapshot& kept = in_one_piece ? *inside : *divided;
    save(kept, in_step);
    if (!in_step) Inputs::withhold_targets(kept.motion.controls);
    began = &kept;
  }

  // Takes the results of another simulator, which has other equations of the same scene.
  void take_over(Impl& other) {
    first = other.first;
    other.drop_own_lines();
    report = std::move(other.report);
    std::swap(events, other.events);
    reselections = other.reselections;
    first_reselection = other.first_reselection;
    earlier_error = other.earlier_error;
    earlier_effort = other.earlier_effort;
    earlier_effort += other.motion.levels().effort();
    others = std::move(other.others);
    in_one_piece = other.in_one_piece;
    inside = std::move(other.inside);
    divided = std::move(other.divided);
    began = other.began;
    undivided = other.undivided;
    motion.count_rejected_from(other.motion.rejected());
    motion.join_events_from(other.motion.events_joined_from());
    motion.take_clock(other.motion);
    slowest_choice = other.slowest_choice;
    postponed = other.postponed;
  }

  void discount(const Effort& counted) {
    earlier_effort.redone -= counted.redone;
    earlier_effort.renewed -= counted.renewed;
    earlier_effort.refined -= counted.refined;
    earlier_effort.unplanned -= counted.unplanned;
    earlier_effort.in_double -= counted.in_double;
  }

  // Restores the simulator with the equations of that time. A simulator that has solved them before still has the pivot
  // orders of that time.
  static void restore(std::unique_ptr<Impl>& impl, const Snapshot& from) {
    if (impl->structure.checks != from.prepared->structure->checks) {
      std::unique_ptr<Impl> next = impl->known(sorted(from.prepared->structure->checks));
      if (!next) {
        next = std::make_unique<Impl>(from.prepared, impl->settings);
        next->motion.restart_solvers();
      }
      next->take_over(*impl);
      next->discount(next->motion.levels().effort());  // it was counted when that simulator was left
      replace(impl, std::move(next));
    }
    impl->restore(from);
  }

  // Makes simulators of the sets that were found before, and starts each where it was found, so that a later start
  // takes no memory.
  void know_other_sets() {
    for (const std::shared_ptr<const Preparation>& set : prepared.other_sets) {
      if (others.size() == kMostOthers) return;
      others.push_back(std::make_unique<Impl>(set, settings, set->start_time.value_or(set->time.start)));
    }
  }

  // Takes out the simulator that checks these equations, in ascending order; null if there is none.
  std::unique_ptr<Impl> known(const std::vector<std::int32_t>& wanted) {
    const auto found = std::find_if(others.begin(), others.end(), [&](const auto& o) { return o->checks == wanted; });
    if (found == others.end()) return nullptr;
    std::unique_ptr<Impl> out = std::move(*found);
    others.erase(found);
    return out;
  }

  // Puts another simulator of the same scene in the place of this one. Spans of its outputs stay valid.
  static void begin_anew(std::unique_ptr<Impl>& impl, std::unique_ptr<Impl> next) {
    take_row(*impl, *next);
    impl = std::move(next);
  }

  // The same, and keeps the present simulator for a return to its equations.
  static void replace(std::unique_ptr<Impl>& impl, std::unique_ptr<Impl> next) {
    take_row(*impl, *next);
    next->others.reserve(kMostOthers);
    if (next->others.size() == kMostOthers) next->others.erase(next->others.begin());
    next->others.push_back(std::move(impl));
    impl = std::move(next);
  }

  // Starts again with the equations of the start.
  static void return_to_first(std::unique_ptr<Impl>& impl, double start) {
    std::vector<std::unique_ptr<Impl>> family = std::move(impl->others);
    const auto found =
        std::find_if(family.begin(), family.end(), [&](const auto& o) { return o->owned == impl->first; });
    std::unique_ptr<Impl> next;
    if (found != family.end()) {
      next = std::move(*found);
      family.erase(found);
      next->inside = std::move(impl->inside);
      next->divided = std::move(impl->divided);
      next->start(start, next->structure.start);
    } else {
      next = std::make_unique<Impl>(impl->first, impl->settings, start);
    }
    next->others = std::move(family);
    replace(impl, std::move(next));
  }

  static void take_row(Impl& from, Impl& next) {
    std::copy(next.row.begin(), next.row.end(), from.row.begin());
    next.row.swap(from.row);
  }

  // ---- redundant equations

  // The same motion with another independent set of the redundant equations, chosen at the last accepted posture. Null
  // if that set is the current one, or if it cannot be started there.
  std::unique_ptr<Impl> reselected() {
    const std::vector<double> here = motion.posture();
    const std::vector<std::int32_t> better = motion.checks_chosen_anew(here);
    if (better == checks) {
      motion.keep_set();
      return nullptr;
    }
    if (auto next = known(better)) {
      if (auto started = continued_by(std::move(next), here)) return started;
    }
    if (!motion.has_time_for(slowest_choice)) return nullptr;
    const auto began_at = motion.now();
    try {
      Preparation chosen = prepared.reselect(here, motion.time(), better);
      slowest_choice = std::max(slowest_choice, motion.now() - began_at);
      if (const auto found = sorted(chosen.structure->checks); found != checks) {
        chosen.reselect = prepared.reselect;
        chosen.start_time = motion.time();
        std::unique_ptr<Impl> next = known(found);
        if (!next) next = std::make_unique<Impl>(std::make_shared<const Preparation>(std::move(chosen)), settings);
        if (auto started = continued_by(std::move(next), here)) return started;
      }
    } catch (const Error&) {  // the posture has no other set
    }
    motion.keep_set();
    return nullptr;
  }

  // The motion continued by another set from this posture; null if that set cannot be started there.
  std::unique_ptr<Impl> continued_by(std::unique_ptr<Impl> next, const std::vector<double>& posture) {
    try {
      next->start(motion.time(), posture, this);
    } catch (const Error&) {
      return nullptr;
    }
    const ErrorFigures there = next->report.error;
    next->take_over(*this);
    next->report.error.merge(there);
    if (next->reselections++ == 0) next->first_reselection = motion.time();
    return next;
  }

  // Chooses another set before the current one is close to being dependent.
  std::unique_ptr<Impl> reselected_if_poor() { return motion.set_is_poor() ? reselected() : nullptr; }

  // ---- results

  void drop_own_lines() { report.fallbacks.resize(report.fallbacks.size() - std::exchange(own_lines, 0)); }

  // Reports the unplanned work of the solvers, as a sum and in words.
  void report_effort() {
    Effort sum = earlier_effort;
    sum += motion.levels().effort();
    report.effort = sum;
    drop_own_lines();
    if (reselections > 0) {
      const std::string times =
          reselections == 1 ? "" : ", and " + std::to_string(reselections - 1) + " times later on";
      report.fallbacks.push_back("t = " + std::to_string(first_reselection) + " s" + times +
                                 ": another independent set of the redundant equations was chosen");
      ++own_lines;
    }
    const auto say = [&](std::int64_t count, const std::string& what) {
      if (count == 0) return;
      report.fallbacks.push_back(std::to_string(count) + what);
      ++own_lines;
    };
    say(report.counters.level_by_level, " attempts at a step solved level after level instead of together");
    say(sum.redone, " factorisations of one lane with its own pivots, because the pivots of the class failed");
    say(sum.renewed, " pivot orders chosen again, because the earlier ones failed repeatedly");
    say(sum.unplanned, " solutions of one lane refined, because the pivots had grown");
    say(sum.in_double, " factorisations of one lane in double, because refinement from float did not converge");
  }

  void report_events() {
    events.write_to(report, [&](const Noticed& event) {
      Event out = motion.in_words(event);
      if (out.detail.empty()) out.detail = without_derivatives(columns, event.missing);
      return out;
    });
  }

  void report_estimate() {
    if (!estimate.measured()) return;
    ErrorFigures all = estimate.of_run();
    all.merge(earlier_error);
    report.error.estimated_position = all.estimated_position;
    report.error.estimated_velocity = all.estimated_velocity;
    report.error.estimated_acceleration = all.estimated_acceleration;
  }

  void fill_row() {
    const double* const q[3] = {motion.at(0), motion.at(1), motion.at(2)};
    if (output_steps) {
      output_steps->evaluate(q, row.data(), turns.turns(), divisors.data());
    } else {
      motion.levels().share(row.size(), [&](std::size_t part, std::size_t parts) {
        outputs.evaluate(q, row.data(), turns.turns(), divisors.data(), part, parts);
      });
    }
    outputs.add_up(row.data());
  }

  // Sets the outputs of the current posture, which are known.
  void stands_at(std::span<const double> outputs_there) {
    std::copy(outputs_there.begin(), outputs_there.end(), row.begin());
    turns.continue_from(row);
  }

  std::shared_ptr<const Preparation> owned;
  const Preparation& prepared;
  std::shared_ptr<const Preparation> first;  // plan at the start of the run, for reset()
  StepSettings settings;
  Report report;  // without its events
  EventLog events;
  const GroupedSystem& structure;
  const System& system;
  Continuation motion;
  std::vector<std::string> columns;
  OutputProgram outputs;
  std::unique_ptr<OutputSteps> output_steps;  // null: outputs has no code
  AngleTurns turns;
  ErrorEstimate estimate;
  bool has_functions;  // of the program
  Status verdict;      // of the last measurement: ok, or inaccurate
  Status doubt;        // the first one of the run
  std::vector<double> row;
  std::vector<double> divisors;  // of the measures
  bool in_one_piece = true;      // the posture was reached by a step that was not divided
  // Nothing has happened since the start, and another one would do the same. A function of the program may return
  // something else the next time.
  bool fresh = false;
  // Starts of the last steps that were divided or failed: at a posture with in_one_piece, and at one without.
  std::unique_ptr<Snapshot> inside, divided;
  const Snapshot* began = nullptr;       // the snapshot before the current step, if there is one
  bool undivided = true;                 // the current step was neither divided, nor did it fail
  Effort earlier_effort;                 // effort of solvers that ran the chunks or solved another set
  ErrorFigures earlier_error;            // estimated errors of the chunks
  std::unique_ptr<OutputSlopes> slopes;  // null before the first jacobian()
  std::size_t own_lines = 0;             // lines that report_effort() added at the end of report.fallbacks
  std::vector<std::int32_t> checks;      // the redundant equations that are not solved, in ascending order
  // Simulators of the same motion with other sets of the redundant equations, the latest one last.
  static constexpr std::size_t kMostOthers = 8;
  std::vector<std::unique_ptr<Impl>> others;
  std::int64_t reselections = 0;
  double first_reselection = 0;                           // time
  std::chrono::steady_clock::duration slowest_choice{0};  // time that a choice of other equations took
  int postponed = 0;                                      // measurements of errors that were due and not in time
};

}  // namespace assur
