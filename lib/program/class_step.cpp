#include "program/class_step.hpp"

#include <cstddef>
#include <utility>
#include <vector>

#include "evaluation/quadratic_equations-inl.hpp"
#include "index.hpp"
#include "program/anchor-inl.hpp"
#include "program/group_slots.hpp"
#include "program/group_tests-inl.hpp"
#include "program/linear_steps.hpp"
#include "program/needs.hpp"
#include "program/step_graph.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

using Values = std::vector<Value>;
using Tests = HWY_NAMESPACE::GroupTests<Value>;

class ClassWriter {
  using Equations = HWY_NAMESPACE::QuadraticEquations<Value>;

  // Numbers as functions, see QuadraticEquations.
  [[nodiscard]] auto coefficients() {
    return [this](std::int32_t k) { return slots().coefficient(k); };
  }
  // Derivatives of inputs that do not move are zero.
  [[nodiscard]] auto inputs(int derivative) {
    return [this, derivative](std::int32_t i) {
      return derivative == 0 || class_.input_moves[idx(i)] != 0 ? slots().input(derivative, i) : kNone;
    };
  }
  static auto into(Values& out) {
    return [&out](std::size_t i, const Value& number) { out[i] = number; };
  }

 public:
  ClassWriter(const GroupClass& group_class, const lanes::Elimination& elimination, std::span<const std::int32_t> reads)
      : class_(group_class), reads_(reads), n_(idx(group_class.n)), linear_(class_.pattern, elimination) {}

  // As many steps take one correction as two, so the end is a phase of its own.
  [[nodiscard]] StepProgram step() {
    StepProgram out;
    begin();
    out.phases.push_back(graph_.take_phase());
    iterate();
    out.phases.push_back(graph_.take_phase());
    out.phases.back().repeat_while = work(kActive);
    finish();
    out.phases.push_back(graph_.take_phase());
    return out;
  }

  [[nodiscard]] StepProgram factors() {
    Equations equations(class_);
    Values phi, jacobian;
    evaluate(equations, predicted(equations), phi, jacobian);
    GroupSlots to = slots();
    for (std::size_t k = 0; k < jacobian.size(); ++k) to.store(Memory::work, k, jacobian[k]);
    to.store(Memory::figures, static_cast<std::size_t>(GroupFigure::failed), linear_.factorize(jacobian));
    std::size_t next = jacobian.size();
    linear_.each_number([&](const Value& number) { to.store(Memory::work, next++, number); });
    return {{graph_.phase()}, {}};
  }

  [[nodiscard]] StepProgram changes() {
    Equations equations(class_);
    Values phi, jacobian, rhs(n_);
    evaluate(equations, predicted(equations), phi, jacobian);
    GroupSlots io = slots();
    for (std::size_t k = 0; k < jacobian.size(); ++k) jacobian[k] = io.load(Memory::work, k);
    std::size_t next = jacobian.size();
    linear_.each_number([&](Value& number) { number = io.load(Memory::work, next++); });
    equations.velocity_rhs(coefficients(), inputs(1), into(rhs));
    const Values x = linear_.solve(rhs);
    for (std::size_t j = 0; j < n_; ++j) io.store(Memory::rates, j, x[j]);
    const Slot failed = slot_of(GroupFigure::failed);
    const Value grown = exceeds(linear_residual(class_.pattern, jacobian, x, rhs), Value::set(kPivotsGrew));
    graph_.store(failed, graph_.load(failed) + grown);
    return {{graph_.phase()}, {}};
  }

  [[nodiscard]] StepProgram anchor() {
    Equations equations(class_);
    Values phi, jacobian, scale(n_);
    evaluate(equations, predicted(equations), phi, jacobian);
    equations.scale(coefficients(), into(scale));
    const Value poor = linear_.factorize(jacobian);
    std::vector<Values> columns;
    for (std::size_t e = 0; e < n_; ++e) {
      Values unit(n_);
      unit[e] = kAll;
      columns.push_back(linear_.solve(unit));
    }
    GroupSlots io = slots();
    HWY_NAMESPACE::renew_anchors<Value>(
        io, class_.n, class_.derivatives, reads_, scale, [&](int r, int c) { return columns[idx(c)][idx(r)]; }, poor,
        [&](std::size_t k) { return equations.value(reads_[k]); });
    return {{graph_.phase()}, {}};
  }

 private:
  // Places in Memory::work: reciprocal scales, unknowns, then numbers of the lane.
  enum Number : std::uint32_t { kActive, kFailed, kRelative, kLast, kFirst };
  struct State {
    Values x, weight;
    Value relative, active, failed, iterations;  // as in SmallGroup
    Value last;                                  // largest entry of the last correction
  };

  [[nodiscard]] GroupSlots slots() { return {graph_, class_, std::uint16_t{0}}; }
  [[nodiscard]] static Slot slot(Memory memory, std::size_t i) { return {memory, static_cast<std::uint32_t>(i)}; }
  [[nodiscard]] Slot work(Number n) const { return slot(Memory::work, 2 * n_ + n); }
  [[nodiscard]] Value setting(GroupSetting s) { return slots().setting(s); }

  // Equations and Jacobian at x.
  void evaluate(Equations& equations, const Values& x, Values& phi, Values& jacobian) {
    for (std::size_t j = 0; j < n_; ++j) equations.values().set(j, x[j]);
    phi.resize(n_);
    jacobian.resize(idx(class_.pattern.nnz()));
    equations.evaluate(coefficients(), into(phi));
    equations.differentiate(coefficients(), into(jacobian));
  }
  [[nodiscard]] Value relative(const Values& phi, const Values& weight) const {
    Values ratio(n_);
    for (std::size_t i = 0; i < n_; ++i) ratio[i] = phi[i] * weight[i];
    return largest_of(ratio);
  }

  // One correction at a posture that was evaluated, in lanes that are active. Leaves equations and Jacobian of the next
  // posture.
  void correct(Equations& equations, State& s, Values& phi, Values& jacobian, bool is_first) {
    s.failed = s.failed + linear_.factorize(jacobian);
    const Values by = linear_.solve(phi);
    if (!is_first || !class_.quadratic())
      s.failed = s.failed + exceeds(linear_residual(class_.pattern, jacobian, by, phi), Value::set(kPivotsGrew));
    const Value size = largest_of(by), largest = if_at_most(s.active, kNone, kNone, size);
    s.failed = s.failed + (largest - largest);
    if (is_first) graph_.store(work(kFirst), largest);
    if (!is_first && !class_.quadratic()) {
      const Value diverges = exceeds(largest, Value::set(kContraction) * s.last);
      s.failed = s.failed + s.active * diverges * exceeds(s.relative, Value::set(kRoundingLevel));
    }
    s.last = largest;
    for (std::size_t j = 0; j < n_; ++j) s.x[j] = if_at_most(s.active, kNone, s.x[j], s.x[j] - by[j]);
    evaluate(equations, s.x, phi, jacobian);
    const Value before = std::exchange(s.relative, relative(phi, s.weight));
    s.failed = s.failed + (s.relative - s.relative);
    s.iterations = s.iterations + s.active;
    const Value solved = at_most(s.relative, setting(GroupSetting::converged_at));
    const Value is_rounding =
        at_most(s.relative, Value::set(kRoundingLevel)) * exceeds(s.relative, Value::set(0.25) * before);
    s.active = if_at_most(solved + is_rounding, kNone, s.active, kNone);
    const Value is_last = at_most(setting(GroupSetting::most_iterations), s.iterations);
    s.failed = s.failed + s.active * is_last;
    s.active = if_at_most(s.failed, kNone, s.active, kNone);
  }

  // Sets the inputs, too.
  [[nodiscard]] Values predicted(Equations& equations) {
    equations.set_inputs(coefficients(), inputs(0));
    Values x(n_);
    for (std::size_t j = 0; j < n_; ++j) x[j] = graph_.load(slot(Memory::unknowns, j));
    return x;
  }

  void begin() {
    Equations equations(class_);
    State s{predicted(equations), Values(n_), {}, {}, kNone, kNone, {}};
    Values phi, jacobian;
    evaluate(equations, s.x, phi, jacobian);
    equations.scale(coefficients(), [&](std::size_t i, const Value& scale) {
      s.weight[i] = kAll / if_at_most(scale, kNone, kAll, scale);
      graph_.store(slot(Memory::work, i), s.weight[i]);
    });
    s.relative = relative(phi, s.weight);
    s.failed = s.relative - s.relative;
    s.active = exceeds(s.relative, setting(GroupSetting::converged_at));
    correct(equations, s, phi, jacobian, true);
    keep(s);
  }

  void iterate() {
    Equations equations(class_);
    equations.set_inputs(coefficients(), inputs(0));
    State s = recall();
    Values phi, jacobian;
    evaluate(equations, s.x, phi, jacobian);
    // If nearly all terms of an equation vanish, its residual is measured against a larger scale from now on.
    const Value slow = Value::set(kSlowIterations);
    const Value raises = s.active * at_most(slow, s.iterations) * at_most(s.iterations, slow);
    equations.least_scale(coefficients(), [&](std::size_t i, const Value& least) {
      const Value raised = if_at_most(least, kNone, s.weight[i], kAll / least);
      const Value smaller = if_at_most(s.weight[i], raised, s.weight[i], raised);
      s.weight[i] = if_at_most(raises, kNone, s.weight[i], smaller);
      graph_.store(slot(Memory::work, i), s.weight[i]);
    });
    s.relative = relative(phi, s.weight);
    const Value solved = raises * at_most(s.relative, setting(GroupSetting::converged_at));
    s.active = if_at_most(solved, kNone, s.active, kNone);
    correct(equations, s, phi, jacobian, false);
    keep(s);
  }

  // Velocity and acceleration with the Jacobian of the solved posture, and the branch test.
  void finish() {
    Equations equations(class_);
    equations.set_inputs(coefficients(), inputs(0));
    const State s = recall();
    Values phi, jacobian;
    evaluate(equations, s.x, phi, jacobian);
    Value failed = s.failed;
    Value residuals[] = {Value::set(-1), Value::set(-1)};  // not computed
    const int derivatives = class_.derivatives;
    if (derivatives > 0) failed = failed + linear_.factorize(jacobian);
    Values rhs(n_), rate;
    for (int d = 1; d <= derivatives; ++d) {
      if (d == 1) {
        equations.velocity_rhs(coefficients(), inputs(1), into(rhs));
      } else {
        for (std::size_t j = 0; j < n_; ++j) equations.rates().set(j, rate[j]);
        equations.acceleration_rhs(coefficients(), inputs(2), into(rhs));
      }
      const std::size_t first = d == derivatives ? idx(class_.first_wanted) : 0;
      const Values x = linear_.solve(rhs, static_cast<int>(first));
      for (std::size_t j = 0; j < n_; ++j) {
        graph_.store(slot(d == 1 ? Memory::rates : Memory::accelerations, j), j < first ? kNone : x[j]);
      }
      if (d == 1) rate = x;
      if (first > 0) continue;
      Value& residual = residuals[d - 1];
      residual = linear_residual(class_.pattern, jacobian, x, rhs);
      failed = failed + exceeds(residual, Value::set(kPivotsGrew));
    }
    const GroupSlots in = slots();
    Value used = kNone, needs_anchor = kNone;
    if (class_.quadratic()) {
      used = Tests::ball_use(in, reads_.size(), [&](std::size_t k) {
        return idx(reads_[k]) < n_ ? s.x[idx(reads_[k])] : equations.value(reads_[k]);
      });
      needs_anchor = Tests::needs_anchor(used, in.ball_used());
      failed = failed + (used - used);
    }
    const auto store_figure = [&](GroupFigure f, const Value& value) { graph_.store(slot_of(f), value); };
    for (std::size_t j = 0; j < n_; ++j) graph_.store(slot(Memory::unknowns, j), s.x[j]);
    store_figure(GroupFigure::failed, if_at_most(failed, kNone, kNone, kAll));
    store_figure(GroupFigure::position, s.relative);
    store_figure(GroupFigure::velocity, residuals[0]);
    store_figure(GroupFigure::acceleration, residuals[1]);
    store_figure(GroupFigure::ball_used, used);
    store_figure(GroupFigure::needs_anchor, needs_anchor);
  }

  void keep(const State& s) {
    for (std::size_t j = 0; j < n_; ++j) graph_.store(slot(Memory::work, n_ + j), s.x[j]);
    graph_.store(work(kActive), s.active);
    graph_.store(work(kFailed), s.failed);
    graph_.store(work(kRelative), s.relative);
    if (!class_.quadratic()) graph_.store(work(kLast), s.last);
    graph_.store(slot_of(GroupFigure::iterations), s.iterations);
  }
  [[nodiscard]] State recall() {
    State s{Values(n_),
            Values(n_),
            graph_.load(work(kRelative)),
            graph_.load(work(kActive)),
            graph_.load(work(kFailed)),
            graph_.load(slot_of(GroupFigure::iterations)),
            class_.quadratic() ? kNone : graph_.load(work(kLast))};
    for (std::size_t j = 0; j < n_; ++j) {
      s.weight[j] = graph_.load(slot(Memory::work, j));
      s.x[j] = graph_.load(slot(Memory::work, n_ + j));
    }
    return s;
  }

  const GroupClass& class_;
  std::span<const std::int32_t> reads_;
  std::size_t n_;
  LinearSteps linear_;
  Graph graph_;
};

}  // namespace

bool has_class_step(const GroupClass& c) {
  return c.n > 0 && can_take(Path::step_program, needs_of(c)) && c.blocks == 1 && c.derivatives > 0 &&
         !has_group_step(c);
}

StepProgram class_anchor(const GroupClass& group_class, const lanes::Elimination& elimination,
                         std::span<const std::int32_t> reads) {
  return ClassWriter(group_class, elimination, reads).anchor();
}

// The step factorises three times; a product is two numbers.
bool is_short(const lanes::Elimination& elimination, std::size_t most) {
  return 3 * elimination.factor.size() / 2 <= most;
}

StepProgram class_step(const GroupClass& group_class, const lanes::Elimination& elimination,
                       std::span<const std::int32_t> reads) {
  return ClassWriter(group_class, elimination, reads).step();
}

StepProgram class_factors(const GroupClass& group_class, const lanes::Elimination& elimination) {
  return ClassWriter(group_class, elimination, {}).factors();
}

StepProgram class_changes(const GroupClass& group_class, const lanes::Elimination& elimination) {
  return ClassWriter(group_class, elimination, {}).changes();
}

std::size_t work_of_changes(const GroupClass& group_class) {
  return idx(group_class.pattern.nnz()) + idx(group_class.n) * idx(group_class.n);
}

}  // namespace assur
