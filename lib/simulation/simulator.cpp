#include "assur/simulator.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "parallel/thread_state.hpp"
#include "simulation/chunks.hpp"
#include "simulation/error_estimate.hpp"
#include "simulation/inputs.hpp"
#include "simulation/layout.hpp"
#include "simulation/levels.hpp"
#include "simulation/memory.hpp"
#include "simulation/output_program.hpp"
#include "simulation/run_arguments.hpp"
#include "simulation/state.hpp"
#include "simulation/tolerances.hpp"
#include "simulation/watch.hpp"

namespace assur {
namespace {

constexpr int kHalvings = 20;  // a step is halved down to 2^-20
constexpr double kSmallest = 1.0 / (1 << kHalvings);
constexpr int kExpandAfter = 4;      // rejected attempts a predictor that reads no derivatives reads them
constexpr int kReach = 12;           // a change point is passed from 2^12 of the shortest steps before it to beyond
constexpr int kMoreHalvings = 6;     // of the shortest step, on the way back from a change point
constexpr double kApart = 1.0 / 16;  // of that reach: a step that ends nearer to the change point is in doubt
constexpr double kSure = 1e-3;       // largest correction over the distance of the branches
constexpr std::size_t kEventsReserved = 64;

// The length of the steps that are tried: halved where one fails, `growth` times as long after `patience` that arrived.
struct Stride {
  double length = std::numeric_limits<double>::infinity();
  int patience = 1;
  double growth = 2;
  int arrived = 0;

  void set(double to) {
    length = to;
    arrived = 0;
  }
  void arrive() {
    if (++arrived == patience) set(growth * length);
  }
};

// On the long way to the chunks the length that works hardly changes. Measured on stewart and four_bar, with patience
// from 2 to 16 and growth from 1.25 to 2: few attempts in all, and one in seven rejected.
constexpr Stride kLongWay{.patience = 4, .growth = 1.5};

constexpr double kEps = std::numeric_limits<double>::epsilon();
// Of the accuracy asked for, what is used: conditions grow before they are measured again, each level's for itself.
constexpr double kMargin = 16;
constexpr int kMostLevels = 8;     // that count
constexpr double kLoosest = 1e-6;  // where a residual counts as solved at most

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

double asked_accuracy(const Plan& plan) { return plan.accuracy > 0 ? plan.accuracy : kDoubtfulError; }

}  // namespace

struct Simulator::Impl {
  Impl(Prepared p, StepLimits l, double start_time)
      : prepared(std::move(p)),
        limits(l),
        structure(*prepared.structure),
        system(*structure.system),
        inputs(system, prepared.controlled),
        layout(lay_out(prepared)),
        packs(layout.packs),
        levels(prepared, layout, limits.pin_to),
        columns(column_names(system)),
        outputs(system, layout.address),
        estimate(system, layout, outputs, asked_accuracy(prepared.plan)) {
    state.resize(layout.first_unknown, layout.size, prepared.plan.predictor);
    if (!structure.watch_class.equations.empty()) watch.emplace(system, structure, layout.address);
    passing.assign(packs.size(), 0);
    keep_what_is_read();
    row.resize(columns.size());
    previous_row.resize(row.size());
    start(start_time, structure.start);
  }

  // Drivers behind nothing that is computed are left out.
  void keep_what_is_read() {
    std::vector<std::uint8_t> read(layout.size, 0);
    for (const Pack& pack : packs) {
      for (const std::int32_t a : pack.inputs) read[idx(a)] = 1;
    }
    outputs.mark(read);
    for (const std::int32_t c : structure.watch.inputs) read[idx(layout.address[idx(c)])] = 1;
    read.resize(system.coordinates.size());  // known coordinates lie at their own index
    inputs.keep(std::move(read));
  }

  // From a posture (all coordinates) at a time: where the run began, or another one of the same motion.
  void start(double time, const std::vector<double>& posture) {
    now = time;
    deadline = std::chrono::steady_clock::time_point::max();  // it is for steps
    inputs.reset();
    levels.restart();
    for (Pack& pack : packs) {
      pack.solver.reset();
      pack.factored = false;
    }
    report = Report{};
    earlier_effort = {};
    effort_lines = 0;
    report.events.reserve(kEventsReserved);
    estimate.restart();
    doubt = {};
    converged = kConverged;
    state.clear();
    for (std::size_t c = 0; c < layout.address.size(); ++c) {
      if (layout.address[c] >= 0) state.at(0)[layout.address[c]] = posture[c];
    }
    repeat_in_idle_lanes();
    StepErrors errors;
    const Status s = solve_at(now, Attempt::Branch::start, errors);
    if (!s.ok()) {
      const std::string group = s.where >= 0 ? " in group " + structure.groups[idx(s.where)].name : "";
      throw Error(
          Error::Kind::numerical,
          "the start posture has no " + std::string(s.code == Code::singular ? "velocities" : "solution") + ": " +
              std::string(name(s.code)) + group +
              (s.code == Code::singular ? "; the Jacobian is singular there, start elsewhere on the path" : ""));
    }
    accept(now, errors);
    report.reached = now;
    fill_row(false);
  }

  void repeat_in_idle_lanes() {
    for (const Pack& pack : packs) {
      const int w = levels.solver(pack).lanes();
      double* x = state.at(0) + pack.unknowns;
      for (std::int32_t i = 0; i < levels.solver(pack).program().n; ++i) {
        for (int lane = pack.used; lane < w; ++lane) x[i * w + lane] = x[i * w];
      }
    }
  }

  // ---- one posture

  // Known coordinates at t, then level after level, pack after pack.
  Status solve_at(double t, Attempt::Branch branch, StepErrors& errors) {
    double* const q[3] = {state.at(0), state.at(1), state.at(2)};
    failed_pack = packs.size();
    if (const Status s = inputs.drive(t, q); !s.ok()) return s;
    const auto attempt = [&](std::size_t p) {
      Attempt a;
      a.time = t;
      a.branch = passing[p] != 0 && branch == Attempt::Branch::inside ? Attempt::Branch::pass : branch;
      a.iterations = packs[p].level > 0 && branch == Attempt::Branch::inside ? limits.iterations : 0;
      a.most_iterations = limits.most_iterations;
      if (a.branch == Attempt::Branch::inside) a.converged = converged;
      if (a.branch == Attempt::Branch::pass) {
        const GroupSolver& s = levels.solver(packs[p]);
        const std::size_t count = idx(s.program().n) * idx(s.lanes());
        a.largest_correction = largest_correction * state.predicted_move(packs[p].unknowns, count);
      }
      return a;
    };
    // At the start every pack makes its solver from those of the packs before it.
    Status s = levels.solve(
        q, branch == Attempt::Branch::start, attempt, [&] { return deadline_passed(); }, report.counters, errors,
        failed_pack);
    if (s.code == Code::deadline) s.figure = limits.seconds;
    if (!s.ok()) return s;
    return check_watched(errors);
  }

  Status check_watched(StepErrors& errors) {
    if (!watch) return {};
    report.counters.evaluated_equations += static_cast<std::int64_t>(watch->equations());
    const double r = watch->residual(state.at(0));
    if (!(r <= kConsistent)) return {Code::inconsistent, -1, r};
    errors.position = std::max(errors.position, r);
    return {};
  }

  void accept(double t, const StepErrors& errors) {
    state.accept(t);
    now = t;
    report.reached = t;
    last_errors = errors;
    report.error.merge({.position = errors.position, .velocity = errors.velocity, .acceleration = errors.acceleration});
  }

  // Back to the last accepted posture.
  void restore() {
    state.restore();
    double* const q[3] = {state.at(0), state.at(1), state.at(2)};
    (void)inputs.drive(now, q);
  }

  bool deadline_passed() const { return limits.seconds > 0 && std::chrono::steady_clock::now() > deadline; }

  // ---- one step

  // `may_reselect`: at a singularity return with wants_reselection set, if there are redundant equations to choose
  // from.
  Status step_to(double t, bool may_reselect) {
    Stride stride;
    return step_to(t, may_reselect, stride);
  }

  Status step_to(double t, bool may_reselect, Stride& stride) {
    wants_reselection = false;
    if (t == now) return {};
    if (const Status s = check_aim(t); !s.ok()) return report.status = s;
    if (limits.seconds > 0) {
      deadline = std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                                        std::chrono::duration<double>(limits.seconds));
    }
    const double from = now;
    inputs.begin_step(now, t);
    Status status;
    try {
      status = advance(t, may_reselect, stride);
    } catch (...) {  // from a law or a callback
      std::fill(passing.begin(), passing.end(), 0);
      end_step(from, false);
      throw;
    }
    end_step(from, status.ok());
    report.status = status.ok() ? doubt : status;
    return status;
  }

  // From posture to posture until t.
  Status advance(double t, bool may_reselect, Stride& stride) {
    const double span = t - now, smallest = std::abs(span) * kSmallest;
    int in_a_row = 0;  // attempts that were rejected; once they are many, they stay so
    while (now != t) {
      const double h = std::copysign(std::min(stride.length, std::abs(span)), span);
      const double target = std::abs(t - now) <= std::abs(h) * 1.0000001 ? t : now + h;
      const Status s = try_step(target, Attempt::Branch::inside, in_a_row >= kExpandAfter);
      if (s.ok()) {
        if (in_a_row < kExpandAfter) in_a_row = 0;
        if (now == t) break;  // what was left says nothing of a whole stride
        stride.arrive();
        ++report.counters.substeps;
        continue;
      }
      ++report.counters.rejected;
      ++in_a_row;
      // Close to a singularity of the equations that are solved, what is watched is the first to tell.
      if (s.code == Code::inconsistent && may_choose_anew(may_reselect)) {
        wants_reselection = true;
        return s;
      }
      if (!worth_halving(s.code) || failed_pack == packs.size()) return s;
      if (std::abs(h) > smallest * 1.5) {
        stride.set(std::abs(target - now) / 2);
        continue;
      }
      if (may_choose_anew(may_reselect)) {
        wants_reselection = true;
        return s;
      }
      if (const Status found = at_the_limit(s, target, t); !found.ok()) return found;
      stride.set(smallest);
    }
    return {};
  }

  // A step that did not arrive leaves the last good posture, which may lie on the way.
  void end_step(double from, bool arrived) {
    if (!arrived) restore();
    const bool stands_still = inputs.end_step(now, wants_reselection);
    if (arrived) ++report.counters.steps;
    // Towards a fold rates are without bound, and tell nothing about how far an angle turned.
    if (now != from) fill_row(true, arrived ? now - from : 0);
    if (stands_still) state.stand_still();
  }

  // Of the posture that was reached at last, on the way from `from`: is it as accurate as was asked for?
  Status check_accuracy(double from) {
    if (!estimate.due(packs, report.counters.branch_checks, last_errors.worst())) return {};
    const double* const q[3] = {state.at(0), state.at(1), state.at(2)};
    estimate.measure(now, q, packs, levels, row);
    if (estimate.now().worst() > estimate.asked() && converged > kConverged && polish()) {
      const double* const exact[3] = {state.at(0), state.at(1), state.at(2)};
      estimate.measure(now, exact, packs, levels, row);
    }
    const double error = estimate.now().worst();
    if (prepared.plan.accuracy > 0) {
      // What is left in the equations shows in the outputs as their rounding does.
      const double margin = kMargin * std::clamp(structure.levels, 1, kMostLevels);
      const double left = prepared.plan.accuracy / margin * (2 * kEps + last_errors.worst()) / error;
      converged = std::clamp(left, kConverged, kLoosest);
      estimate.expect(converged > kConverged ? prepared.plan.accuracy / margin : 0);
    }
    if (error <= estimate.asked()) return {};
    const std::int32_t group = packs.empty() ? -1 : packs[estimate.worst_pack()].groups[idx(estimate.worst_lane())];
    const Status status{Code::inaccurate, group, error};
    record_doubt({from, now, group < 0 ? "" : structure.groups[idx(group)].name, status.code, error});
    if (doubt.ok()) report.status = doubt = status;
    return status;
  }

  std::vector<GroupFigures> examine() {
    const double* const q[3] = {state.at(0), state.at(1), state.at(2)};
    estimate.measure(now, q, packs, levels, row);
    std::vector<GroupFigures> all(structure.groups.size());
    for (Pack& pack : packs) {
      GroupSolver& solver = levels.solver(pack);
      const GroupSolver::Health health = solver.examine(pack, state.at(0));
      const std::size_t w = idx(solver.lanes());
      for (std::size_t lane = 0; lane < pack.groups.size(); ++lane) {
        GroupFigures& of = all[idx(pack.groups[lane])];
        of = {pack.groups[lane], health.residual[lane], health.condition[lane], 0};
        for (std::size_t i = 0; i < idx(solver.program().n); ++i) {
          of.estimated_error = std::max(of.estimated_error, estimate.of_coordinate(pack.unknowns + i * w + lane));
        }
      }
    }
    return all;
  }

  // The posture at hand once more, as exact as doubles are.
  bool polish() {
    converged = kConverged;
    state.restore();
    StepErrors errors;
    if (!solve_at(now, Attempt::Branch::inside, errors).ok()) {
      restore();
      return false;
    }
    state.replace();
    last_errors = errors;
    fill_row(true);
    return true;
  }

  // Steps one after the other are one event, of the worst of them.
  void record_doubt(Event event) {
    if (!report.events.empty()) {
      Event& before = report.events.back();
      if (before.kind == event.kind && before.until == event.time) {
        before.until = event.until;
        if (before.figure < event.figure) {
          before.figure = event.figure;
          before.group = std::move(event.group);
        }
        return;
      }
    }
    report.events.push_back(std::move(event));
  }

  // Is it somewhere? A driver that was set to nowhere is named by an event, and nothing moves.
  Status check_aim(double t) {
    if (!std::isfinite(t)) return {Code::not_finite, -1, t};
    double value = 0;
    const std::string* const driver = inputs.not_finite(value);
    if (driver == nullptr) return {};
    record({now, t, *driver, Code::not_finite, value}, std::abs(t - now));
    inputs.drop_pending();
    return {Code::not_finite, -1, value};
  }

  [[nodiscard]] bool may_choose_anew(bool asked) const { return asked && prepared.reselect && now != selected_at; }

  static bool worth_halving(Code code) {
    return code == Code::branch_unknown || code == Code::not_converged || code == Code::singular ||
           code == Code::not_finite;
  }

  void predict(double target, bool expand) {
    const State::Prediction prediction = expand ? state.begin_expansion(target) : state.begin_prediction(target);
    levels.share(state.unknowns(), [&](std::size_t part, std::size_t parts) {
      state.predict(prediction, state.unknowns() * part / parts, state.unknowns() * (part + 1) / parts);
    });
  }

  // expand: also with a predictor that reads no derivatives, by those of the posture at hand.
  Status try_step(double target, Attempt::Branch branch, bool expand = false) {
    predict(target, expand);
    StepErrors errors;
    const Status s = solve_at(target, branch, errors);
    if (s.ok()) accept(target, errors);
    return s;
  }

  // The smallest step fails: is this a limit, a change point that can be passed, or unknown?
  Status at_the_limit(const Status& failed, double target, double t) {
    restore();
    if (structure.classes[idx(packs[failed_pack].group_class)].derivatives == 0) state.estimate_rates();
    double* const q[3] = {state.at(0), state.at(1), state.at(2)};
    Status found = levels.solver(packs[failed_pack]).diagnose(packs[failed_pack], q);
    if (failed.code == Code::not_finite && found.code == Code::branch_unknown) found = failed;
    if (found.code == Code::change_point_passed && !pass(target, t)) found.code = Code::branch_unknown;
    if (found.code == Code::branch_unknown && failed.code == Code::not_converged && found.figure > 0.05) found = failed;
    const bool passed = found.code == Code::change_point_passed;
    if (found.code == Code::limit_reached) target = first_without_solution(target, t);
    record({passed ? last_before_pass : now, passed ? now : target,
            structure.groups[idx(found.where >= 0 ? found.where : failed.where)].name, found.code, found.figure},
           std::abs(t - target));
    return passed ? Status{} : found;
  }

  // The shortest steps through one change point are one event.
  void record(Event event, double step) {
    if (!report.events.empty()) {
      Event& before = report.events.back();
      if (before.kind == event.kind && before.group == event.group && std::abs(event.time - before.until) <= step) {
        before.until = event.until;
        before.figure = std::min(before.figure, event.figure);
        return;
      }
    }
    report.events.push_back(std::move(event));
  }

  // Steps end a little before a fold, where the ball around the posture shrinks to nothing; the fold itself lies before
  // the first time at which Newton's method finds no solution at all.
  double first_without_solution(double target, double t) {
    const double smallest = target - now;
    for (int k = 0; k <= kHalvings; ++k) {
      const double h = std::ldexp(smallest, k);
      target = std::abs(t - now) <= std::abs(h) ? t : now + h;
      state.predict(target);
      StepErrors errors;
      const bool exists = solve_at(target, Attempt::Branch::anywhere, errors).ok();
      if (!exists) break;
    }
    restore();
    return target;
  }

  // Over a change point by the smooth continuation. Close to it a posture is uncertain by eps / distance and its rates
  // by eps / distance^2, so the step starts well before it and lands as far beyond, where the branches are apart by
  // more than any error. Other packs may be at one of theirs at the same time.
  bool pass(double target, double t) {
    last_before_pass = now;
    const std::size_t at_its_change_point = failed_pack;
    const double change = now, smallest = target - now, reach = std::ldexp(smallest, kReach);
    const double to = std::abs(t - change) <= std::abs(reach) ? t : change + reach;
    bool passed = false;
    if (std::abs(to - change) >= kApart * std::abs(reach) && walk(change - reach, smallest, change)) {
      passing[at_its_change_point] = 1;
      largest_correction = kSure * (to - change) / (to - now);
      for (std::size_t more = 0; more < packs.size() && !passed; ++more) {
        passed = try_step(to, Attempt::Branch::inside).ok();
        // Beyond all packs if none of them failed.
        if (failed_pack == packs.size() || passing[failed_pack] != 0) break;
        passing[failed_pack] = 1;
      }
      std::fill(passing.begin(), passing.end(), 0);
    }
    if (!passed) {
      walk(change, smallest, change);
      restore();
    }
    return passed;
  }

  // By continuation to `until`, in steps of about h. Predictions away from a change point do not read the older of the
  // postures close to it.
  bool walk(double until, double h, double change) {
    h = std::abs(h);
    const double shortest = std::ldexp(h, -kMoreHalvings);
    while (now != until) {
      if (std::abs(now - change) < std::abs(until - change) / 4) state.forget();
      const double left = until - now;
      if (try_step(std::abs(left) <= h ? until : now + std::copysign(h, left), Attempt::Branch::inside).ok()) {
        h *= 2;
      } else if ((h /= 2) < shortest) {
        return false;
      }
    }
    return true;
  }

  // All coordinates; what presolve eliminated, and follows from the others, as guessed.
  std::vector<double> posture() const {
    std::vector<double> all = system.guess;
    for (std::size_t c = 0; c < all.size(); ++c) {
      if (layout.address[c] >= 0) all[c] = state.at(0)[layout.address[c]];
    }
    return all;
  }

  // ---- redundant equations

  // The same motion with another independent set of the redundant equations, chosen at the last accepted posture; null
  // if that is the set at hand or cannot be started there.
  std::unique_ptr<Impl> reselected() {
    try {
      Prepared chosen = prepared.reselect(posture(), now);
      if (chosen.structure->checks == structure.checks) return nullptr;
      chosen.reselect = prepared.reselect;
      auto next = std::make_unique<Impl>(std::move(chosen), limits, now);
      next->inputs.continue_from(inputs);
      next->selected_at = now;
      next->doubt = doubt;
      next->first_structure = first_structure != nullptr ? first_structure : std::make_shared<const Prepared>(prepared);
      drop_effort_lines();
      next->report = std::move(report);
      next->row = row;
      next->report.fallbacks.push_back(
          "t = " + std::to_string(now) +
          " s: an equation set became singular; another one of the redundant equations is solved");
      return next;
    } catch (const Error&) {
      return nullptr;
    }
  }

  // ---- results

  void drop_effort_lines() { report.fallbacks.resize(report.fallbacks.size() - std::exchange(effort_lines, 0)); }

  // What the solvers had to do beyond what was planned, as a sum and in words.
  void report_effort() {
    Effort sum = earlier_effort;
    sum += levels.effort();
    report.effort = sum;
    drop_effort_lines();
    const auto say = [&](std::int64_t count, const std::string& what) {
      if (count == 0) return;
      report.fallbacks.push_back(std::to_string(count) + what);
      ++effort_lines;
    };
    say(sum.redone, " factorisations of one lane with pivots of its own, where those of the class did not serve");
    say(sum.renewed, " pivot orders chosen anew");
    say(sum.unplanned, " solutions of one lane refined, because the factors had grown");
    say(sum.in_double, " factorisations of one lane in double, where float did not serve");
  }

  void report_estimate() {
    if (!estimate.measured()) return;
    const auto [position, velocity, acceleration] = estimate.of_run();
    report.error.estimated_position = position;
    report.error.estimated_velocity = velocity;
    report.error.estimated_acceleration = acceleration;
  }

  void fill_row(bool unwrap, double dt = 0) {
    const double* const q[3] = {state.at(0), state.at(1), state.at(2)};
    row.swap(previous_row);
    const double* const before = unwrap ? previous_row.data() : nullptr;
    levels.share(row.size(), [&](std::size_t part, std::size_t parts) {
      outputs.evaluate(q, row.data(), before, dt, part, parts);
    });
  }

  // The outputs follow those of a row that was reached elsewhere, a time dt before.
  void stands_behind(std::span<const double> last_row, double dt) {
    std::copy(last_row.begin(), last_row.end(), row.begin());
    if (dt != 0) fill_row(true, dt);
  }

  Prepared prepared;
  StepLimits limits;
  const Structure& structure;
  const System& system;
  Inputs inputs;
  Layout layout;
  std::vector<Pack>& packs;
  Levels levels;
  std::vector<std::string> columns;
  OutputProgram outputs;
  ErrorEstimate estimate;
  State state;
  std::optional<Watch> watch;
  Status doubt;                       // the first one of the run
  double converged = kConverged;      // residual of an equation that counts as solved
  StepErrors last_errors;             // of the last accepted posture
  std::vector<std::uint8_t> passing;  // packs: on the way through a change point
  double now = 0;
  double last_before_pass = 0;
  double largest_correction = 0;  // of a step through a change point, over the move that was predicted
  bool wants_reselection = false;
  double selected_at = std::numeric_limits<double>::quiet_NaN();  // time of the last reselection
  std::size_t failed_pack = 0;  // of the last posture that was tried; their number: none
  std::chrono::steady_clock::time_point deadline;
  std::vector<double> row, previous_row;
  std::shared_ptr<const Prepared> first_structure;  // what reset() goes back to, after a reselection
  Report report;
  Effort earlier_effort;         // of solvers that ran the chunks
  std::size_t effort_lines = 0;  // at the end of report.fallbacks
};

std::vector<double> posture_of(const Simulator& simulator) { return simulator.impl_->posture(); }

Simulator::Simulator(Prepared prepared, StepLimits limits) {
  check_limits(limits);
  const double start = prepared.start_time.value_or(prepared.time.start);
  impl_ = std::make_unique<Impl>(std::move(prepared), limits, start);
}
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;
Simulator::~Simulator() = default;

double Simulator::time() const { return impl_->now; }

Status Simulator::step(double t) {
  const double from = impl_->now;
  Status status = impl_->step_to(t, true);
  if (impl_->wants_reselection) {
    if (auto next = impl_->reselected()) {
      impl_ = std::move(next);
      return step(t);
    }
    status = impl_->step_to(t, false);
  }
  return status.ok() ? impl_->check_accuracy(from) : status;
}

void Simulator::set(std::string_view driver, double value, double rate, double acceleration) {
  impl_->inputs.set(driver, {value, rate, acceleration});
}

Status Simulator::step() { return step(impl_->now + impl_->prepared.time.step); }

void Simulator::reset() {
  const double start = impl_->prepared.start_time.value_or(impl_->prepared.time.start);
  if (impl_->first_structure != nullptr) {
    impl_ = std::make_unique<Impl>(*impl_->first_structure, impl_->limits, start);
  } else {
    impl_->start(start, impl_->structure.start);
  }
}

Trajectory Simulator::run(const Observer& observer) {
  const TimeGrid& grid = impl_->prepared.time;
  // The grid itself, the trajectory's times and its values.
  check_memory(static_cast<std::size_t>(grid.steps()) + 1, columns().size() + 2);
  std::vector<double> times;
  for (std::int64_t k = 0; k <= grid.steps(); ++k) times.push_back(grid.time(k));
  return run(times, observer);
}

Trajectory Simulator::run(std::span<const double> times, const Observer& observer) {
  check_times(times);
  reset();
  Trajectory out;
  out.columns_ = impl_->columns;
  check_memory(times.size(), out.columns_.size() + 1);
  if (impl_->prepared.plan.chunks > 1 && run_in_chunks(times, observer, out)) return out;
  out.values_.reserve(times.size() * out.columns_.size());
  out.times_.reserve(times.size());
  const auto of = static_cast<std::int64_t>(times.size());
  std::optional<Pinned> here;  // once, not in every step
  if (!impl_->limits.pin_to.empty() && impl_->levels.threads() > 1) here.emplace(impl_->limits.pin_to[0]);
  for (const double t : times) {
    if (!step(t).arrived()) break;
    out.times_.push_back(t);
    out.values_.insert(out.values_.end(), impl_->row.begin(), impl_->row.end());
    if (observer && !observer(static_cast<std::int64_t>(out.times_.size()), of)) {
      if (static_cast<std::int64_t>(out.times_.size()) < of) impl_->report.status = {Code::interrupted, -1, t};
      break;
    }
  }
  impl_->report.counters.stored_values = static_cast<std::int64_t>(out.values_.size());
  return out;
}

// False if there is a reason against it, which is reported: then nothing is done.
bool Simulator::run_in_chunks(std::span<const double> times, const Observer& observer, Trajectory& out) {
  if (times.empty()) return false;
  const auto refuse = [&](const std::string& why) {
    reset();
    impl_->report.fallbacks.push_back("no chunks: " + why);
    return false;
  };
  if (const std::string why = no_chunks(*impl_->prepared.structure, impl_->limits, times); !why.empty()) {
    return refuse(why);
  }
  const ChunkGrid grid = chunk_grid(times.size(), idx(impl_->prepared.plan.chunks));
  const double first_time = impl_->now;
  Stride stride = kLongWay;
  const auto reach = [&](double t) {
    if (impl_->step_to(t, true, stride).ok()) return true;
    // The chunks begin with the equations that the run began with, or not at all.
    return impl_->wants_reselection && !impl_->reselected() && impl_->step_to(t, false, stride).ok();
  };
  std::vector<Variant> starts;
  for (const std::size_t row : grid.first) {
    if (!reach(times[row])) {
      return refuse("their start postures were found up to t = " + std::to_string(impl_->now) + " s only");
    }
    starts.push_back({impl_->structure.system, impl_->posture(), impl_->now, impl_->prepared.reselect});
  }
  Counters counters = impl_->report.counters;
  counters.steps = 0;  // those between the starts are not of the grid
  ChunkedRun run = assur::run_in_chunks(impl_->prepared, impl_->limits, times, grid, std::move(starts), observer);
  if (run.rows == 0) return refuse("the first one could not be started");
  out.values_ = std::move(run.values);
  out.times_.assign(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(run.rows));

  impl_->start(run.reached, run.posture);
  impl_->stands_behind(out.row(run.rows - 1), run.reached - out.times_.back());
  impl_->earlier_effort = run.totals.effort;
  Report& report = impl_->report;
  report = {};
  report.counters = counters;
  report.counters += run.totals.counters;
  report.counters.steps = static_cast<std::int64_t>(run.rows) - (times[0] == first_time ? 1 : 0);
  report.counters.stored_values = static_cast<std::int64_t>(out.values_.size());
  report.error = run.totals.error;
  report.status = run.status;
  report.reached = run.reached;
  report.events = std::move(run.events);
  report.fallbacks = std::move(run.fallbacks);
  return true;
}

const std::vector<std::string>& Simulator::columns() const { return impl_->columns; }
std::span<const double> Simulator::outputs() const { return impl_->row; }

double Simulator::output(std::string_view column) const {
  const auto& columns = impl_->columns;
  const auto found = std::find(columns.begin(), columns.end(), column);
  if (found == columns.end()) throw Error(Error::Kind::input, "no column '" + std::string(column) + "'");
  return impl_->row[static_cast<std::size_t>(found - columns.begin())];
}

std::vector<GroupFigures> Simulator::examine() { return impl_->examine(); }

const Report& Simulator::report() const {
  impl_->report_effort();
  impl_->report_estimate();
  return impl_->report;
}
const Prepared& Simulator::prepared() const { return impl_->prepared; }

}  // namespace assur
