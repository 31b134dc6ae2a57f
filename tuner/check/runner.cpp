#include "check/runner.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "check/condition.hpp"
#include "check/doubt.hpp"
#include "check/makers.hpp"
#include "check/matrices.hpp"
#include "check/strategies.hpp"
#include "check/twin.hpp"
#include "check/yardstick.hpp"
#include "numbers.hpp"
#include "output/format.hpp"
#include "plan/preparation.hpp"

namespace assur::check {
namespace {

constexpr double kHopeless = 1, kHopelessQuick = 0.1;  // s for one run, by operation counts

Made made(const Case& c) {
  Made out = [&]() -> Made {
    if (!c.maker.empty()) return make(c.maker, c.set);
    if (!c.scene.empty()) return {parse_scene(c.scene, c.name, ".", c.set), nullptr};
    return {open_scene(c.text, c.set, c.tables), nullptr};
  }();
  if (!c.outputs.empty()) out.scene = out.scene.with_outputs(c.outputs);
  if (c.time) out.scene = out.scene.with_time(*c.time);
  if (!c.closed_form.empty()) out.closed_form = closed_form(c.closed_form, out.scene);
  return out;
}

bool wants_derivatives(const GroupedSystem& s) {
  return std::any_of(s.groups.begin(), s.groups.end(), [](const SolvedGroup& g) { return g.wanted_derivatives > 0; });
}

// Runs one case with all its strategies.
class CaseRun {
 public:
  CaseRun(const Case& c, const RunnerOptions& options) : options_(options) { result_.what = c; }

  Result take() {
    try {
      made_ = made(result_.what);
    } catch (const Error& error) {
      refuse("reading", error);
      return std::move(result_);
    }
    Selection selection;
    try {
      selection =
          select_strategies(result_.what, made_->scene, options_.quick ? kHopelessQuick : kHopeless, options_.quick);
    } catch (const Error& error) {
      refuse("analysing", error);
      return std::move(result_);
    }
    result_.notes = std::move(selection.left_out);
    for (const std::string& strategy : selection.strategies) {
      if (options_.stop()) result_.interrupted = true;
      if (result_.interrupted) break;
      with(strategy);
    }
    return std::move(result_);
  }

 private:
  void refuse(const std::string& strategy, const Error& error) {
    result_.add({strategy, "refused", error.what(), std::nullopt, std::nullopt});
  }

  void with(const std::string& strategy) {
    PrepareOptions how;
    how.strategy = strategy;
    how.accuracy = result_.what.accuracy;
    std::optional<Prepared> prepared;
    std::optional<Simulator> simulator;
    try {
      prepared = prepare(made_->scene, how);
      simulator.emplace(*prepared, StepSettings{.iterations = result_.what.iterations});
    } catch (const Error& error) {
      if (error.kind() == Error::Kind::environment) return leave_out(strategy, error.what());
      return refuse(strategy, error);
    }
    const Trajectory trajectory = simulator->run([this](std::int64_t, std::int64_t) { return options_.stop(); });
    const Report& report = simulator->report();
    if (report.status.code == Code::interrupted) {
      result_.interrupted = true;
      return;
    }
    try {
      if (!yardstick_) look_for_yardstick(*prepared, trajectory);
    } catch (const Error& error) {  // the start posture is wrong
      result_.add({strategy, "wrong", error.what(), std::nullopt, std::nullopt});
      return;
    }
    Run run = verdict_of(strategy, trajectory, report);
    if (!result_.what.twin.empty()) compare_with_twin(run, how, trajectory);
    result_.add(std::move(run));
  }

  void leave_out(const std::string& strategy, const std::string& why) {
    result_.left_out.insert(parse_strategy(strategy).solver.backend + ": " + why);
  }

  // Called for the first run that starts.
  void look_for_yardstick(const Prepared& prepared, const Trajectory& trajectory) {
    std::unique_ptr<TrueMotion> motion;
    if (made_->closed_form) {
      motion = known_motion(prepared, made_->closed_form);
    } else if (result_.what.plain) {
      motion = plain_motion(prepared);
    } else {
      try {
        motion = reference_motion(prepared);
      } catch (const Error& error) {
        result_.notes.push_back(std::string("strategies are compared with the first one: ") + error.what());
      }
      if (!motion && result_.notes.empty()) {
        result_.notes.push_back("strategies are compared with the first one: this build has no quadruple precision");
      }
      if (!motion) motion = agreed_motion(trajectory);
    }
    yardstick_ = std::make_unique<Yardstick>(prepared, std::move(motion));
    result_.condition = worst_condition(prepared, options_.stop);
    if (!result_.condition) return;
    const double kappa = *result_.condition;
    result_.bound = kEps * kappa * (wants_derivatives(*preparation(prepared).structure) ? kappa : 1);
  }

  // Number of rows on the right branch: from its first event on, a run warns that its branch is in doubt.
  [[nodiscard]] std::size_t sure_rows(const Trajectory& trajectory, const Report& report) const {
    if (made_->closed_form) return trajectory.rows();  // a closed form is on the right branch
    double until = HUGE_VAL;
    for (const Event& e : report.events) {
      if (doubts_branch(e)) until = std::min(until, e.time);
    }
    const auto& times = trajectory.times();
    return static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), until) - times.begin());
  }

  Run verdict_of(const std::string& strategy, const Trajectory& trajectory, const Report& report) {
    Run run;
    run.strategy = strategy;
    if (const double residual = report.error.residual(); !std::isnan(residual)) run.backward_error = residual;
    run.verdict = report.status.ok() ? "pass" : std::string(name(report.status.code));
    for (const Event& e : report.events) {
      if (report.status.ok() && doubts_branch(e)) run.verdict = name(e.kind);
    }
    double untold = 0;
    try {
      const std::size_t rows = sure_rows(trajectory, report);
      run.forward_error = yardstick_->forward_error(trajectory, rows);
      untold = yardstick_->forward_error(trajectory, rows, [&](std::size_t row) {
        return std::none_of(report.events.begin(), report.events.end(), [t = trajectory.times()[row]](const Event& e) {
          return e.kind == Code::inaccurate && e.time <= t && t <= e.until;
        });
      });
    } catch (const Error& error) {
      run.message = run.verdict + ", but its error is unknown: " + error.what();
      run.verdict = "no_yardstick";
      return run;
    }
    if (!(untold <= result_.what.limit())) {
      run.message = run.verdict + ", but the error is " + output::error_figure(untold) + " where " +
                    output::error_figure(result_.what.limit()) + " is required, and no event reports it";
      run.verdict = "wrong";
    }
    return run;
  }

  void compare_with_twin(Run& run, const PrepareOptions& how, const Trajectory& trajectory) {
    Case other = result_.what;
    for (const auto& [parameter, value] : other.twin) other.set[parameter] = value;
    const Trajectory twin = Simulator(prepare(made(other).scene, how)).run();
    if (const std::string difference = other_bits(trajectory, twin); !difference.empty() && run.verdict == "pass") {
      run.verdict = "other_bits";
      run.message = difference;
    }
  }

  const RunnerOptions& options_;
  Result result_;
  std::optional<Made> made_;
  std::unique_ptr<Yardstick> yardstick_;
};

}  // namespace

Scene scene_of(const Case& c) { return made(c).scene; }

Result run(const Case& c, const RunnerOptions& options) {
  if (!c.matrix.empty()) return run_matrix(c, options.stop);
  return CaseRun(c, options).take();
}

}  // namespace assur::check
