#include "program/group_step.hpp"

#include <utility>
#include <vector>

#include "backends/lanes_factors.hpp"
#include "program/step_rules.hpp"
#include "index.hpp"
#include "program/graph.hpp"

namespace assur {
namespace {

using Column = std::vector<Value>;
using Matrix = std::vector<Column>;  // rows

// Places in Memory::work.
struct Layout {
  explicit Layout(const Program& p)
      : n(static_cast<std::uint32_t>(p.n)), forms(static_cast<std::uint32_t>(p.forms.size())) {}

  std::uint32_t n, forms;
  [[nodiscard]] std::uint32_t unknown(std::uint32_t j) const { return j; }
  [[nodiscard]] std::uint32_t residual(std::uint32_t i) const { return n + i; }
  [[nodiscard]] std::uint32_t weight(std::uint32_t i) const { return 2 * n + i; }  // 1 / scale of an equation
  [[nodiscard]] std::uint32_t known(std::uint32_t f) const { return 3 * n + f; }   // part of a form from its inputs
  [[nodiscard]] std::uint32_t relative() const { return 3 * n + forms; }           // residual
  [[nodiscard]] std::uint32_t active() const { return relative() + 1; }            // 1 as long as it iterates
  [[nodiscard]] std::uint32_t size() const { return active() + 1; }
};

// The equations of a group in one phase.
class Equations {
 public:
  Equations(Graph& graph, const Program& program) : g_(graph), p_(program), layout_(program) {}

  [[nodiscard]] Value load(Memory memory, std::uint32_t index) const { return g_.load({memory, index}); }
  [[nodiscard]] Value work(std::uint32_t index) const { return load(Memory::work, index); }
  [[nodiscard]] Value figure(GroupFigure f) const { return g_.load(slot_of(f)); }
  [[nodiscard]] Value setting(GroupSetting s) const { return g_.load(slot_of(s)); }
  [[nodiscard]] Value number(double x) const { return g_.constant(x); }
  void keep(std::uint32_t index, Value v) const { g_.store({Memory::work, index}, v); }
  void tell(GroupFigure f, Value v) const { g_.store(slot_of(f), v); }

  // Parts of the forms from constants and inputs, with the magnitudes of their terms.
  void read_inputs() {
    for (const Program::Form& f : p_.forms) {
      Value total = number(0), magnitude = number(0);
      for (std::int32_t o = f.begin; o < f.unknowns; ++o) {
        const Value term = coefficient(operand(o)) * input(Memory::inputs, operand(o).reg);
        total = total + term;
        magnitude = magnitude + absolute(term);
      }
      known_.push_back(total);
      known_magnitude_.push_back(magnitude);
    }
  }
  void keep_inputs() const {
    for (std::uint32_t f = 0; f < layout_.forms; ++f) keep(layout_.known(f), known_[f]);
  }
  // The same from an earlier phase.
  void recall_inputs() {
    for (std::uint32_t f = 0; f < layout_.forms; ++f) known_.push_back(work(layout_.known(f)));
  }

  void set_unknowns(const Column& x) {
    x_ = x;
    values_.clear();
    for (const Program::Form& f : p_.forms) {
      Value total = known_[values_.size()];
      for (std::int32_t o = f.unknowns; o < f.end; ++o)
        total = total + coefficient(operand(o)) * x_[idx(operand(o).reg)];
      values_.push_back(total);
    }
  }

  [[nodiscard]] Column residuals() const {
    Column phi;
    for (const Program::Equation& e : p_.equations) {
      Value total = number(0);
      for (std::int32_t o = e.linear.begin; o < e.linear.end; ++o) {
        total = total + coefficient(p_.linear[idx(o)]) * value(p_.linear[idx(o)].reg);
      }
      for (std::int32_t q = e.products.begin; q < e.products.end; ++q) {
        const Program::Product& t = p_.products[idx(q)];
        total = total + coefficient(t.coefficient) * (value(t.a) * value(t.b));
      }
      phi.push_back(total);
    }
    return phi;
  }

  // sum_j |dPhi_i/dq_j| |q_j| + |constant|, over unknowns and inputs; 1 if it vanishes.
  [[nodiscard]] Column scales() const {
    Column scale;
    for (const Program::Equation& e : p_.equations) {
      Value total = number(0);
      for (std::int32_t o = e.linear.begin; o < e.linear.end; ++o) {
        total = total + absolute(coefficient(p_.linear[idx(o)])) * magnitude(p_.linear[idx(o)].reg);
      }
      for (std::int32_t q = e.products.begin; q < e.products.end; ++q) {
        const Program::Product& t = p_.products[idx(q)];
        const Value a = magnitude(t.a) * absolute(value(t.b)), b = absolute(value(t.a)) * magnitude(t.b);
        total = total + absolute(coefficient(t.coefficient)) * (a + b);
      }
      scale.push_back(if_at_most(total, number(0), number(1), total));
    }
    return scale;
  }

  [[nodiscard]] Matrix jacobian() const {
    const std::size_t n = idx(p_.n);
    Matrix j(n, Column(n, number(0)));
    for (std::size_t column = 0; column < n; ++column) {
      for (std::int32_t k = p_.pattern.column_start[column]; k < p_.pattern.column_start[column + 1]; ++k) {
        const Program::Range r = p_.entries[idx(k)];
        Value& entry = j[idx(p_.pattern.row[idx(k)])][column];
        for (std::int32_t o = r.begin; o < r.end; ++o) {
          entry = entry + coefficient(p_.entry_operands[idx(o)]) * value(p_.entry_operands[idx(o)].reg);
        }
      }
    }
    return j;
  }

  // -Phi_h h'
  [[nodiscard]] Column velocity_rhs() const {
    Column rhs;
    for (const Program::Equation& e : p_.equations) rhs.push_back(number(0) - by_inputs(e, Memory::input_rates));
    return rhs;
  }
  // -(Phi_h h'' + Phi'_q q')
  [[nodiscard]] Column acceleration_rhs(const Column& rates) const {
    const auto rate = [&](std::int32_t reg) {
      Value total = by_input(Memory::input_rates, reg);
      if (reg < p_.n) return rates[idx(reg)];
      if (reg <= p_.one()) return total;
      const Program::Form& f = form(reg);
      for (std::int32_t o = f.unknowns; o < f.end; ++o) {
        total = total + coefficient(operand(o)) * rates[idx(operand(o).reg)];
      }
      return total;
    };
    Column rhs;
    for (const Program::Equation& e : p_.equations) {
      Value total = number(0);
      for (std::int32_t q = e.curvature.begin; q < e.curvature.end; ++q) {
        const Program::Product& t = p_.curvature[idx(q)];
        total = total + coefficient(t.coefficient) * (rate(t.a) * rate(t.b));
      }
      rhs.push_back(number(0) - (total + by_inputs(e, Memory::input_accelerations)));
    }
    return rhs;
  }

  // A coordinate: an unknown or an input.
  [[nodiscard]] Value coordinate(std::int32_t reg) const {
    return reg < p_.n ? x_[idx(reg)] : input(Memory::inputs, reg);
  }

 private:
  [[nodiscard]] const Program::Operand& operand(std::int32_t o) const { return p_.operands[idx(o)]; }
  [[nodiscard]] const Program::Form& form(std::int32_t reg) const { return p_.forms[idx(reg - p_.one() - 1)]; }
  [[nodiscard]] Value coefficient(const Program::Operand& o) const { return coefficient(o.coefficient); }
  // Without constants of the group it is part of the program.
  [[nodiscard]] Value coefficient(std::int32_t k) const {
    const Coefficient& c = p_.coefficients[idx(k)];
    const bool is_literal = c.constant[0] < 0 && c.constant[1] < 0 && c.constant[2] < 0;
    return is_literal ? number(c.literal) : load(Memory::coefficients, static_cast<std::uint32_t>(k));
  }
  [[nodiscard]] Value input(Memory memory, std::int32_t reg) const {
    if (reg == p_.one()) return number(memory == Memory::inputs ? 1 : 0);
    return load(memory, static_cast<std::uint32_t>(reg - p_.n));
  }
  [[nodiscard]] Value value(std::int32_t reg) const {
    if (reg > p_.one()) return values_[idx(reg - p_.one() - 1)];
    return reg < p_.n ? x_[idx(reg)] : input(Memory::inputs, reg);
  }
  // Sum of the magnitudes of the terms.
  [[nodiscard]] Value magnitude(std::int32_t reg) const {
    if (reg <= p_.one()) return absolute(value(reg));
    const Program::Form& f = form(reg);
    Value total = known_magnitude_[idx(reg - p_.one() - 1)];
    for (std::int32_t o = f.unknowns; o < f.end; ++o) {
      total = total + absolute(coefficient(operand(o))) * absolute(x_[idx(operand(o).reg)]);
    }
    return total;
  }
  // The part of the derivative of a register that comes from inputs.
  [[nodiscard]] Value by_input(Memory derivatives, std::int32_t reg) const {
    if (reg < p_.n) return number(0);
    if (reg <= p_.one()) return input(derivatives, reg);
    const Program::Form& f = form(reg);
    Value total = number(0);
    for (std::int32_t o = f.moving; o < f.unknowns; ++o) {
      total = total + coefficient(operand(o)) * input(derivatives, operand(o).reg);
    }
    return total;
  }
  [[nodiscard]] Value by_inputs(const Program::Equation& e, Memory derivatives) const {
    Value total = number(0);
    for (std::int32_t o = e.input_linear.begin; o < e.input_linear.end; ++o) {
      const Program::Operand& t = p_.input_linear[idx(o)];
      total = total + coefficient(t) * by_input(derivatives, t.reg);
    }
    for (std::int32_t q = e.input_products.begin; q < e.input_products.end; ++q) {
      const Program::Product& t = p_.input_products[idx(q)];
      total = total + coefficient(t.coefficient) * (by_input(derivatives, t.a) * value(t.b));
    }
    return total;
  }

  Graph& g_;
  const Program& p_;
  Layout layout_;
  Column x_;
  std::vector<Value> known_, known_magnitude_, values_;  // forms
};

// P A = L U with U's unit diagonal, and the tests of pivots of the backend `lanes`.
class Factors {
 public:
  Factors(const Equations& in, Matrix a) : f_(std::move(a)), n_(f_.size()) {
    const lanes::Limits limits = lanes::limits(static_cast<int>(n_), Precision::binary64);
    const auto square = [&](double x) { return in.number(x * x); };
    const Value shrink = in.number(1 / (limits.growth * limits.growth));
    std::uint32_t pivot = 0;
    for (std::size_t k = 0; k < n_; ++k) {
      for (std::size_t i = k + 1; i < n_; ++i) {
        swaps_.push_back({k, i, in.load(Memory::pivots, pivot++)});
        for (std::size_t j = 0; j < n_; ++j) swap(in, swaps_.back(), f_[k][j], f_[i][j]);
      }
    }
    Column of_a;
    for (const Column& row : f_) {
      Value sum = row[0] * row[0];
      for (std::size_t j = 1; j < n_; ++j) sum = sum + row[j] * row[j];
      of_a.push_back(sum);
    }
    Value largest_u = in.number(1);
    poor_ = in.number(0);
    // The second of two pivots is determinant / first, so that both divisions run at the same time.
    const Column quotient = n_ == 2 ? Column{in.number(1) / f_[0][0],
                                             f_[0][0] / (f_[0][0] * f_[1][1] - f_[1][0] * f_[0][1])}
                                    : Column();
    for (std::size_t k = 0; k < n_; ++k) {
      reciprocal_.push_back(n_ == 2 ? quotient[k] : in.number(1) / f_[k][k]);
      const Value of_pivot = f_[k][k] * f_[k][k];
      Value of_l = of_pivot, of_u = in.number(0);
      for (std::size_t j = 0; j < k; ++j) of_l = of_l + f_[k][j] * f_[k][j];
      for (std::size_t j = k + 1; j < n_; ++j) {
        of_u = of_u + f_[k][j] * f_[k][j];
        f_[k][j] = f_[k][j] * reciprocal_[k];
        for (std::size_t i = k + 1; i < n_; ++i) f_[i][j] = f_[i][j] - f_[i][k] * f_[k][j];
      }
      const Value least = square(limits.smallest) + of_a[k] * square(limits.pivot);
      poor_ = if_at_most((of_l + of_u) * shrink * largest_u, of_a[k], poor_, in.number(1));
      poor_ = if_at_most(least, of_pivot, poor_, in.number(1));
      largest_u = larger(largest_u, of_u * reciprocal_[k] * reciprocal_[k]);
    }
  }

  [[nodiscard]] Column solve(const Equations& in, Column b) const {
    for (const Swap& s : swaps_) swap(in, s, b[s.first], b[s.second]);
    for (std::size_t k = 0; k < n_; ++k) {
      b[k] = b[k] * reciprocal_[k];
      for (std::size_t i = k + 1; i < n_; ++i) b[i] = b[i] - f_[i][k] * b[k];
    }
    for (std::size_t k = n_ - 1; k > 0; --k) {
      for (std::size_t i = 0; i < k; ++i) b[i] = b[i] - f_[i][k] * b[k];
    }
    return b;
  }

  // 0, or 1 if a pivot is outside its limits.
  [[nodiscard]] Value poor() const { return poor_; }

 private:
  struct Swap {
    std::size_t first, second;
    Value if_positive;
  };
  static void swap(const Equations& in, const Swap& s, Value& a, Value& b) {
    const Value first = a;
    a = if_at_most(s.if_positive, in.number(0), first, b);
    b = if_at_most(s.if_positive, in.number(0), b, first);
  }

  Matrix f_;
  std::size_t n_;
  Column reciprocal_;
  std::vector<Swap> swaps_;
  Value poor_;
};

// NaN if a number is not finite, else 0. The comparisons of a maximum would lose it.
Value poison_of(const Equations& in, const Column& numbers) {
  Value sum = in.number(0);
  for (const Value v : numbers) sum = sum + (v - v);
  return sum;
}

Value largest_of(const Equations& in, const Column& numbers) {
  Value largest = in.number(0);
  for (const Value v : numbers) largest = larger(absolute(v), largest);
  return largest;
}

Column product(const Column& a, const Column& b) {
  Column out;
  for (std::size_t i = 0; i < a.size(); ++i) out.push_back(a[i] * b[i]);
  return out;
}

// 0 if all numbers are at most the bound, else 1, also for NaN.
Value is_open(const Equations& in, const Column& numbers, Value bound) {
  Value open = in.number(0);
  for (const Value v : numbers) open = if_at_most(absolute(v), bound, open, in.number(1));
  return open;
}

// |b - J x| / (|J| |x| + |b|) in maximum norms.
Value linear_residual(const Equations& in, const Matrix& jacobian, const Column& x, const Column& b) {
  Column rest = b;
  Value norm = in.number(0);
  for (std::size_t i = 0; i < b.size(); ++i) {
    Value sum = in.number(0);
    for (std::size_t j = 0; j < x.size(); ++j) {
      rest[i] = rest[i] - jacobian[i][j] * x[j];
      sum = sum + absolute(jacobian[i][j]);
    }
    norm = larger(sum, norm);
  }
  const Value size = norm * largest_of(in, x) + largest_of(in, b);
  return (largest_of(in, rest) + poison_of(in, rest)) / if_at_most(size, in.number(0), in.number(1), size);
}

// omega |by|; a step of 0 is within any ball.
Value part_of_ball(const Equations& in, const Column& by) {
  const Value size = largest_of(in, by);
  return if_at_most(size, in.number(0), size, in.load(Memory::omega, 0) * size) + poison_of(in, by);
}

Column load_column(const Equations& in, std::uint32_t first, std::size_t n) {
  Column out;
  for (std::uint32_t i = 0; i < n; ++i) out.push_back(in.work(first + i));
  return out;
}

void keep_column(const Equations& in, std::uint32_t first, const Column& numbers) {
  for (std::uint32_t i = 0; i < numbers.size(); ++i) in.keep(first + i, numbers[i]);
}

Phase begin(const Program& p, const Layout& at) {
  Graph graph;
  Equations in(graph, p);
  in.read_inputs();
  Column x;
  for (std::uint32_t j = 0; j < at.n; ++j) x.push_back(in.load(Memory::unknowns, j));
  in.set_unknowns(x);
  const Column phi = in.residuals();
  Column weight;
  for (const Value scale : in.scales()) weight.push_back(in.number(1) / scale);
  const Column relative = product(phi, weight);
  in.keep_inputs();
  keep_column(in, at.unknown(0), x);
  keep_column(in, at.residual(0), phi);
  keep_column(in, at.weight(0), weight);
  in.keep(at.relative(), largest_of(in, relative) + poison_of(in, relative));
  in.keep(at.active(), is_open(in, relative, in.setting(GroupSetting::converged_at)));
  in.tell(GroupFigure::failed, in.number(0));
  in.tell(GroupFigure::iterations, in.number(0));
  return graph.phase();
}

// One correction. A lane that is not active keeps its numbers.
Phase iterate(const Program& p, const Layout& at, bool may_vanish) {
  Graph graph;
  Equations in(graph, p);
  const Value zero = in.number(0), one = in.number(1);
  const Value active = in.work(at.active()), count = in.figure(GroupFigure::iterations),
              before = in.work(at.relative());
  const auto if_active = [&](Value yes, Value no) { return if_at_most(active, zero, no, yes); };
  in.recall_inputs();
  const Column x = load_column(in, at.unknown(0), at.n), phi = load_column(in, at.residual(0), at.n),
               weight = load_column(in, at.weight(0), at.n);
  in.set_unknowns(x);
  const Factors factors(in, in.jacobian());
  const Column by = factors.solve(in, phi);
  Column next;
  for (std::size_t j = 0; j < x.size(); ++j) next.push_back(x[j] - by[j]);
  in.set_unknowns(next);
  const Column left = in.residuals(), ratios = product(left, weight);

  // The rules of SmallStep: unusual lanes fail.
  const Value relative = largest_of(in, ratios) + poison_of(in, ratios), iterations = count + one;
  const Value used = part_of_ball(in, by);
  Value failed = factors.poor();
  const Value is_near = if_at_most(used, in.setting(GroupSetting::largest_first), failed, one);
  failed = if_at_most(count, zero, is_near, failed);
  failed = failed + (relative - relative);
  failed = if_at_most(failed, zero, zero, one);
  Value open = is_open(in, ratios, in.setting(GroupSetting::converged_at));
  const Value falls = relative - before * in.number(0.25);  // above 0: slowly
  const Value only_rounding = if_at_most(falls, zero, zero, if_at_most(relative, in.number(kRoundingLevel), one, zero));
  if (may_vanish) {
    const Value slow = if_at_most(falls, zero, failed, if_at_most(iterations, one, failed, one));
    failed = if_at_most(open, zero, failed, slow);
  }
  const Value too_many = if_at_most(in.setting(GroupSetting::most_iterations), iterations, one, failed);
  const Value open_still = if_at_most(only_rounding, zero, open, zero);
  failed = if_at_most(open_still, zero, failed, too_many);
  open = if_at_most(failed, zero, open_still, zero);

  for (std::uint32_t i = 0; i < at.n; ++i) {
    in.keep(at.unknown(i), if_active(next[i], x[i]));
    in.keep(at.residual(i), if_active(left[i], phi[i]));
  }
  in.keep(at.relative(), if_active(relative, before));
  in.keep(at.active(), if_active(open, zero));
  in.tell(GroupFigure::failed, if_active(failed, in.figure(GroupFigure::failed)));
  in.tell(GroupFigure::iterations, if_active(iterations, count));
  Phase phase = graph.phase();
  phase.repeat_while = Slot{Memory::work, at.active()};
  return phase;
}

Phase finish(const Program& p, const Layout& at, int derivatives, std::span<const std::int32_t> reads) {
  Graph graph;
  Equations in(graph, p);
  in.recall_inputs();
  const Column x = load_column(in, at.unknown(0), at.n);
  in.set_unknowns(x);
  Value failed = in.figure(GroupFigure::failed);
  in.tell(GroupFigure::position, in.work(at.relative()));
  if (derivatives > 0) {
    const Matrix jacobian = in.jacobian();
    const Factors factors(in, jacobian);
    const auto store = [&](Memory memory, const Column& numbers) {
      for (std::uint32_t j = 0; j < numbers.size(); ++j) graph.store({memory, j}, numbers[j]);
    };
    const Column rhs = in.velocity_rhs(), rates = factors.solve(in, rhs);
    const Value velocity = linear_residual(in, jacobian, rates, rhs);
    store(Memory::rates, rates);
    in.tell(GroupFigure::velocity, velocity);
    failed = failed + factors.poor() + (velocity - velocity);
    if (derivatives > 1) {
      const Column of = in.acceleration_rhs(rates), accelerations = factors.solve(in, of);
      const Value acceleration = linear_residual(in, jacobian, accelerations, of);
      store(Memory::accelerations, accelerations);
      in.tell(GroupFigure::acceleration, acceleration);
      failed = failed + (acceleration - acceleration);
    }
  }
  Column moved;
  for (std::uint32_t c = 0; c < reads.size(); ++c)
    moved.push_back(in.coordinate(reads[c]) - in.load(Memory::anchor, c));
  in.tell(GroupFigure::ball_used, part_of_ball(in, moved));
  in.tell(GroupFigure::failed, if_at_most(failed, in.number(0), in.number(0), in.number(1)));
  return graph.phase();
}

}  // namespace

std::uint32_t work_of_group_step(const Program& equations) { return Layout(equations).size(); }
std::uint32_t pivots_of_group_step(const Program& equations) {
  return static_cast<std::uint32_t>(equations.n * (equations.n - 1) / 2);
}

StepProgram group_step(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads) {
  const Layout at(equations);
  // All terms of an equation may vanish at a posture, unless it is a sum of squares and a constant.
  const bool may_vanish = [&] {
    for (const Program::Equation& e : equations.equations) {
      for (std::int32_t o = e.linear.begin; o < e.linear.end; ++o) {
        if (equations.linear[idx(o)].reg != equations.one()) return true;
      }
    }
    return false;
  }();
  return {{begin(equations, at), iterate(equations, at, may_vanish),
           finish(equations, at, group_class.derivatives, reads)}};
}

}  // namespace assur
