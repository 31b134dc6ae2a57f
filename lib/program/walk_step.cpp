#include "program/walk_step.hpp"

#include <cstdint>
#include <vector>

#include "evaluation/quadratic_equations-inl.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "program/linear_steps.hpp"
#include "program/step_graph.hpp"
#include "start/walk.hpp"

namespace assur {
namespace {

constexpr double kMostUsed = 1e6;  // a larger part of the bound counts as infinite

using Values = std::vector<Value>;

class WalkWriter : WalkRules {
  using Equations = HWY_NAMESPACE::QuadraticEquations<Value>;
  using Registers = Values;

 public:
  WalkWriter(const GroupClass& group_class, const lanes::Elimination& elimination)
      : class_(group_class), n_(idx(group_class.n)), inverse_(class_.pattern, elimination) {}

  [[nodiscard]] StepProgram write() {
    StepProgram out;
    begin();
    out.phases.push_back(graph_.take_phase());
    correct();
    out.phases.push_back(graph_.take_phase());
    out.phases.back().repeat_while = slot(Memory::work, n_ + kActive);
    test();
    out.phases.push_back(graph_.take_phase());
    return out;
  }

 private:
  // Behind the unknowns in Memory::work.
  enum Number : std::size_t { kActive, kFailed, kLast, kCorrections };

  [[nodiscard]] static Slot slot(Memory memory, std::size_t i) { return {memory, static_cast<std::uint32_t>(i)}; }
  [[nodiscard]] Value load(Memory memory, std::size_t i) { return graph_.load(slot(memory, i)); }
  [[nodiscard]] Value work(Number n) { return load(Memory::work, n_ + n); }
  void keep(Number n, const Value& value) { graph_.store(slot(Memory::work, n_ + n), value); }
  [[nodiscard]] auto coefficients() {
    return [this](std::int32_t k) { return coefficient(k); };
  }
  [[nodiscard]] Value coefficient(std::int32_t k) {
    return GroupSlots(graph_, class_, std::uint16_t{0}).coefficient(k);
  }

  // A posture: of unknowns and inputs.
  struct Posture {
    Values unknowns, inputs;
  };
  [[nodiscard]] Posture posture(Memory unknowns, Memory inputs) {
    Posture out;
    for (std::size_t j = 0; j < n_; ++j) out.unknowns.push_back(load(unknowns, j));
    for (std::size_t i = 0; i < idx(class_.inputs); ++i) out.inputs.push_back(load(inputs, i));
    return out;
  }
  [[nodiscard]] Posture begin_of_chord() { return posture(WalkSlots::from, WalkSlots::from_inputs); }
  [[nodiscard]] Posture end_of_chord() { return posture(Memory::work, WalkSlots::inputs); }

  // Residuals at a posture.
  [[nodiscard]] Values residuals(Equations& equations, const Posture& at) {
    equations.set_inputs(coefficients(), [&](std::int32_t i) { return at.inputs[idx(i)]; });
    for (std::size_t j = 0; j < n_; ++j) equations.values().set(j, at.unknowns[j]);
    Values phi(n_);
    equations.evaluate(coefficients(), [&](std::size_t i, const Value& x) { phi[i] = x; });
    return phi;
  }
  [[nodiscard]] Values jacobian(Equations& equations) {
    Values out(idx(class_.pattern.nnz()));
    equations.differentiate(coefficients(), [&](std::size_t k, const Value& x) { out[k] = x; });
    return out;
  }

  void begin() {
    for (std::size_t j = 0; j < n_; ++j) graph_.store(slot(Memory::work, j), load(WalkSlots::from, j));
    keep(kActive, kAll);
    keep(kFailed, kNone);
    keep(kLast, Value::set(kInfinity));
    keep(kCorrections, kNone);
  }

  // One of Newton's corrections, in lanes that are active.
  void correct() {
    Equations equations(class_);
    const Posture at = end_of_chord();
    Values phi = residuals(equations, at);
    for (std::size_t i = 0; i < n_; ++i) phi[i] = phi[i] - load(WalkSlots::aims, i);
    const Values matrix = jacobian(equations);
    const Value active = work(kActive);
    Value failed = work(kFailed) + active * inverse_.invert(matrix);
    const Values by = inverse_.solve(phi);
    const Value size = largest_of(by), slow = exceeds(size, Value::set(0.5) * work(kLast));
    const Value done = work(kCorrections) + active;
    failed = failed + active * slow * exceeds(size, Value::set(kRoundingOnly)) + active * exceeds(size - size, kNone);
    failed = failed + active * exceeds(done, Value::set(kMostCorrections));
    for (std::size_t j = 0; j < n_; ++j) {
      graph_.store(slot(Memory::work, j), if_at_most(active, kNone, at.unknowns[j], at.unknowns[j] - by[j]));
    }
    const Value goes_on = active * exceeds(size, Value::set(kCorrected)) * at_most(slow, kNone);
    keep(kActive, if_at_most(failed, kNone, goes_on, kNone));
    keep(kFailed, failed);
    keep(kLast, if_at_most(active, kNone, work(kLast), size));
    keep(kCorrections, done);
  }

  // Sizes of the changes of all registers for these of unknowns and inputs.
  [[nodiscard]] Registers changes(const Values& unknowns, const Values& inputs) {
    Registers out(idx(class_.registers()));
    for (std::size_t j = 0; j < n_; ++j) out[j] = unknowns[j];
    for (std::size_t i = 0; i < inputs.size(); ++i) out[n_ + i] = inputs[i];
    for (const GroupClass::Form& f : class_.forms) {
      Value sum = kNone;
      for (std::int32_t o = f.begin; o < f.end; ++o) {
        const GroupClass::Operand& term = class_.operands[idx(o)];
        sum.add_product(abs(coefficient(term.coefficient)), out[idx(term.reg)]);
      }
      out[idx(f.reg)] = sum;
    }
    return out;
  }
  // For each equation: bounds of the sums of the sizes of the changes of its row of the Jacobian.
  [[nodiscard]] Values row_changes(const Registers& by) {
    Values sums(n_);
    for (std::int32_t c = 0; c < class_.n; ++c) {
      for (std::int32_t k = class_.pattern.column_start[idx(c)]; k < class_.pattern.column_start[idx(c) + 1]; ++k) {
        Value& sum = sums[idx(class_.pattern.row[idx(k)])];
        for (std::int32_t o = class_.entries[idx(k)].begin; o < class_.entries[idx(k)].end; ++o) {
          const GroupClass::Operand& term = class_.entry_operands[idx(o)];
          sum.add_product(abs(coefficient(term.coefficient)), by[idx(term.reg)]);
        }
      }
    }
    return sums;
  }
  // For each equation: a bound of its change if the inputs leave their chords, anywhere on the chord.
  [[nodiscard]] Values input_changes(const Equations& middle, const Registers& half, const Registers& strays) {
    Values sums(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      for (std::int32_t o = e.linear.begin; o < e.linear.end; ++o) {
        const GroupClass::Operand& term = class_.linear[idx(o)];
        sums[i].add_product(abs(coefficient(term.coefficient)), strays[idx(term.reg)]);
      }
      for (std::int32_t o = e.products.begin; o < e.products.end; ++o) {
        const GroupClass::Product& q = class_.products[idx(o)];
        Value by = (abs(middle.value(q.a)) + half[idx(q.a)]) * strays[idx(q.b)];
        by.add_product(strays[idx(q.a)], abs(middle.value(q.b)) + half[idx(q.b)]);
        sums[i].add_product(abs(coefficient(q.coefficient)), by);
      }
    }
    return sums;
  }

  // See Walk::test() in start/walk.cpp: with the inverse C of the Jacobian in the middle of the chord,
  //   Y = |C residuals of the chord| + |C residuals at its end| + |C| |change by inputs off their chords|,
  //   Z = |C| |change of the Jacobian along the chord|, B = |C| |that within a ball of radius 1|,
  // the proof needs Z + 2 sqrt(B Y) < 1. Residuals are those beyond the ones that the way has there: none where the
  // chord begins. Along it they are those of its end, and 4 t (1 - t) times those in the middle.
  void test() {
    const Posture from = begin_of_chord(), to = end_of_chord();
    Equations equations(class_);
    const Values open = residuals(equations, from);
    Values left = residuals(equations, to);
    Posture middle;
    Values half, half_inputs, strays, none(n_), units(n_, kAll), no_inputs(idx(class_.inputs));
    const auto go = [](const Value& begin, const Value& end, Values& at, Values& by) {
      by.push_back(Value::set(0.5) * (end - begin));
      at.push_back(begin + by.back());
      by.back() = abs(by.back());
    };
    for (std::size_t j = 0; j < n_; ++j) go(from.unknowns[j], to.unknowns[j], middle.unknowns, half);
    for (std::size_t i = 0; i < no_inputs.size(); ++i) {
      go(from.inputs[i], to.inputs[i], middle.inputs, half_inputs);
      strays.push_back(load(WalkSlots::strays, i));
      half_inputs[i] = half_inputs[i] + strays[i];
    }
    Values chord = residuals(equations, middle);
    for (std::size_t i = 0; i < n_; ++i) {
      const Value aim = load(WalkSlots::aims, i);
      chord[i] = chord[i] - Value::set(0.5) * (open[i] + aim);
      left[i] = left[i] - aim;
      graph_.store(slot(WalkSlots::open, i), open[i]);
    }
    const Value failed = work(kFailed) + inverse_.invert(jacobian(equations));
    const Registers along = changes(half, half_inputs), beside = changes(none, strays);
    const Values by_chord = row_changes(along), by_ball = row_changes(changes(units, no_inputs)),
                 by_inputs = input_changes(equations, along, beside);
    Values of_chord(n_), of_end(n_), y(n_), z(n_), b(n_);
    for (std::size_t e = 0; e < n_; ++e) {
      const Values column = inverse_.column(e);
      for (std::size_t r = 0; r < n_; ++r) {
        of_chord[r].add_product(column[r], chord[e]);
        of_end[r].add_product(column[r], left[e]);
        y[r].add_product(abs(column[r]), by_inputs[e]);
        z[r].add_product(abs(column[r]), by_chord[e]);
        b[r].add_product(abs(column[r]), Value::set(0.5) * by_ball[e]);
      }
    }
    const Value of_y = largest_of(of_chord) + largest_of(of_end) + largest_of(y), of_z = largest_of(z),
                of_b = largest_of(b);
    const Value used = of_z + Value::set(2) * sqrt(of_b * of_y);
    const Value rest = kAll - of_z;
    const Value radius = Value::set(2) * of_y / (rest + sqrt(rest * rest - Value::set(4) * (of_b * of_y)));
    for (std::size_t j = 0; j < n_; ++j) graph_.store(slot(WalkSlots::to, j), to.unknowns[j]);
    graph_.store(slot(WalkSlots::stray, 0), radius);
    const Value none_left = Value::set(kInfinity), finite = if_at_most(used, Value::set(kMostUsed), used, none_left);
    graph_.store(slot(WalkSlots::used, 0), if_at_most(failed, kNone, finite, none_left));
  }

  const GroupClass& class_;
  std::size_t n_;
  Inverse inverse_;
  Graph graph_;
};

}  // namespace

StepProgram walk_step(const GroupClass& group_class, const lanes::Elimination& elimination) {
  return WalkWriter(group_class, elimination).write();
}

}  // namespace assur
