#include "program/together_step.hpp"

#include <algorithm>
#include <utility>

#include "evaluation/quadratic_equations-inl.hpp"
#include "index.hpp"
#include "program/anchor-inl.hpp"
#include "program/group_slots.hpp"
#include "program/group_tests-inl.hpp"
#include "program/linear_steps.hpp"
#include "program/step_graph.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

using Values = std::vector<Value>;
using Tests = HWY_NAMESPACE::GroupTests<Value>;

// Writes one pass.
class TogetherWriter {
  using Equations = HWY_NAMESPACE::QuadraticEquations<Value>;

 public:
  TogetherWriter(const TogetherClass& of, const TogetherShape& shape)
      : of_(of),
        class_(of.group_class),
        n_(idx(class_.n)),
        io_(graph_, class_, shape.stride, Reach::from),
        equations_(class_),
        inverse_(class_.pattern, of.elimination) {}

  [[nodiscard]] Phase write(TogetherPass pass) {
    switch (pass) {
      case TogetherPass::begin:
      case TogetherPass::linearise:
        linearise(pass == TogetherPass::begin);
        break;
      case TogetherPass::approach:
        approach();
        break;
      case TogetherPass::rates:
        find_own_rates();
        break;
      case TogetherPass::accelerations:
        find_own_accelerations();
        break;
      case TogetherPass::finish:
        finish();
        break;
      case TogetherPass::anchors:
        renew_anchors();
        break;
    }
    return graph_.take_phase();
  }

 private:
  // Places in Memory::work: weights, the largest residual, a right-hand side, and the inverse.
  [[nodiscard]] std::size_t relative() const { return n_; }
  [[nodiscard]] std::size_t rhs(std::size_t i) const { return n_ + 1 + i; }
  [[nodiscard]] std::size_t inverse() const { return 2 * n_ + 1; }

  // Numbers as functions, see QuadraticEquations.
  [[nodiscard]] auto coefficients() {
    return [this](std::int32_t k) { return io_.coefficient(k); };
  }
  // Derivatives of inputs that do not move are zero.
  [[nodiscard]] auto inputs(int derivative) {
    return [this, derivative](std::int32_t i) {
      return derivative == 0 || class_.input_moves[idx(i)] != 0 ? io_.input(derivative, i) : kNone;
    };
  }
  static auto into(Values& out) {
    return [&out](std::size_t i, const Value& number) { out[i] = number; };
  }
  [[nodiscard]] Values load(Memory memory, std::size_t first = 0) const {
    Values out;
    for (std::size_t j = 0; j < n_; ++j) out.push_back(io_.load(memory, first + j));
    return out;
  }
  void store(Memory memory, const Values& from, std::size_t first = 0) {
    for (std::size_t j = 0; j < from.size(); ++j) io_.store(memory, first + j, from[j]);
  }
  [[nodiscard]] Value figure(GroupFigure f) const { return io_.load(Memory::figures, static_cast<std::size_t>(f)); }
  void store_figure(GroupFigure f, const Value& value) {
    io_.store(Memory::figures, static_cast<std::size_t>(f), value);
  }
  // failed: 0, or anything else, even NaN
  void store_failed(const Value& failed) { store_figure(GroupFigure::failed, if_at_most(failed, kNone, kNone, kAll)); }

  // The equations at the current posture.
  Values evaluate() {
    equations_.set_inputs(coefficients(), inputs(0));
    const Values x = load(Memory::unknowns);
    for (std::size_t j = 0; j < n_; ++j) equations_.values().set(j, x[j]);
    Values phi(n_);
    equations_.evaluate(coefficients(), into(phi));
    return phi;
  }
  [[nodiscard]] Values jacobian() {
    Values out(idx(class_.pattern.nnz()));
    equations_.differentiate(coefficients(), into(out));
    return out;
  }
  // -Phi_h h'. rates: of the inputs, as a function
  template <class Rates>
  [[nodiscard]] Values rhs_of_rates(const Rates& rates) {
    Values out(n_);
    equations_.velocity_rhs(coefficients(), rates, into(out));
    return out;
  }
  [[nodiscard]] Values scales() {
    Values out(n_);
    equations_.scale(coefficients(), into(out));
    return out;
  }

  void linearise(bool begins) {
    const Value converged = io_.setting(GroupSetting::converged_at);
    const Values phi = evaluate();
    Values weight(n_), ratio(n_);
    if (begins) {
      const Values scale = scales();
      for (std::size_t i = 0; i < n_; ++i) weight[i] = kAll / if_at_most(scale[i], kNone, kAll, scale[i]);
      store(Memory::work, weight);
    } else {
      weight = load(Memory::work);
    }
    for (std::size_t i = 0; i < n_; ++i) ratio[i] = phi[i] * weight[i];
    const Value left = largest_of(ratio);
    Value failed = left - left, open;
    if (begins) {
      open = Tests::is_open(ratio, converged);
    } else {
      failed = figure(GroupFigure::failed) + failed;
      const Tests::Progress progress =
          Tests::progress(ratio, converged, left, io_.load(Memory::work, relative()),
                          io_.setting(GroupSetting::corrections), terms_may_vanish(class_), failed);
      failed = progress.failed;
      open = progress.goes_on;
    }
    io_.store(Memory::work, relative(), left);
    store_figure(GroupFigure::position, left);
    store_figure(kOpen, open);

    store_failed(failed + inverse_.invert(jacobian()));
    inverse_.keep(io_, inverse());
    Values rhs(n_);
    for (std::size_t i = 0; i < n_; ++i) rhs[i] = kNone - phi[i];
    store(Memory::own, inverse_.solve(rhs));
    for (std::size_t k = 0; k < of_.couplings.equations.size(); ++k) {
      store(static_cast<Memory>(kColumns + k), inverse_.column(idx(of_.couplings.equations[k])));
    }
    for (std::size_t e = 0; e < of_.couplings.entries.size(); ++e) {
      const Couplings::Coupling& entry = of_.couplings.entries[e];
      const auto unit = [&](std::int32_t i) { return i == entry.input ? kAll : kNone; };
      io_.store(Memory::couplings, e, rhs_of_rates(unit)[idx(of_.couplings.equations[idx(entry.row)])]);
    }
  }

  void approach() {
    Value largest = kNone, poison = kNone;
    for (const Value& x : load(Memory::change)) Tests::include(x, largest, poison);
    for (const Couplings::Coupling& e : of_.couplings.entries) {
      Tests::include(io_.load(Memory::sources, idx(e.input)), largest, poison);
    }
    const Value used = Tests::times_omega(io_, largest) + poison;
    const Value limit = Value::set(largest_first_correction(0)) * (kAll - io_.ball_used());
    store_failed(figure(GroupFigure::failed) + exceeds(used, limit));
  }

  void find_own_rates() {
    (void)evaluate();
    inverse_.recall(io_, inverse());
    store(Memory::own, inverse_.solve(rhs_of_rates(inputs(1))));
  }

  void find_own_accelerations() {
    (void)evaluate();
    const Values matrix = jacobian(), rate = load(Memory::rates);
    const Value residual = linear_residual(class_.pattern, matrix, rate, rhs_of_rates(inputs(1)));
    store_figure(GroupFigure::velocity, residual);
    store_failed(figure(GroupFigure::failed) + exceeds(residual, Value::set(kPivotsGrew)));
    if (class_.derivatives < 2) return;
    for (std::size_t j = 0; j < n_; ++j) equations_.rates().set(j, rate[j]);
    Values of_accelerations(n_);
    equations_.acceleration_rhs(coefficients(), inputs(2), into(of_accelerations));
    store(Memory::work, of_accelerations, rhs(0));
    inverse_.recall(io_, inverse());
    store(Memory::own, inverse_.solve(of_accelerations));
  }

  void finish() {
    (void)evaluate();
    if (class_.derivatives > 1) {
      Values right = load(Memory::work, rhs(0));
      for (std::size_t k = 0; k < of_.couplings.equations.size(); ++k) {
        Value& of_row = right[idx(of_.couplings.equations[k])];
        of_row = of_row + io_.load(Memory::loads, k);
      }
      const Value residual = linear_residual(class_.pattern, jacobian(), load(Memory::accelerations), right);
      store_figure(GroupFigure::acceleration, residual);
      store_failed(figure(GroupFigure::failed) + exceeds(residual, Value::set(kPivotsGrew)));
    }
    const Value used = Tests::ball_use(io_, of_.reads.size(), [&](std::size_t k) { return at(k); });
    store_figure(GroupFigure::ball_used, used);
    store_figure(GroupFigure::needs_anchor, Tests::needs_anchor(used, io_.ball_used()));
  }

  void renew_anchors() {
    (void)evaluate();
    const Values scale = scales();
    const Value poor = inverse_.invert(jacobian());
    std::vector<Values> columns;
    for (std::size_t e = 0; e < n_; ++e) columns.push_back(inverse_.column(e));
    const auto entry = [&](int r, int c) { return columns[idx(c)][idx(r)]; };
    HWY_NAMESPACE::renew_anchors<Value>(io_, class_.n, class_.derivatives, of_.reads, scale, entry, poor,
                                        [&](std::size_t k) { return at(k); });
  }

  // Coordinate k of the branch test.
  [[nodiscard]] Value at(std::size_t k) const { return equations_.value(of_.reads[k]); }

  const TogetherClass& of_;
  const GroupClass& class_;
  std::size_t n_;
  Graph graph_;
  GroupSlots io_;
  Equations equations_;
  Inverse inverse_;
};

// computed: inputs, 1 if another group computes the input.
Couplings couplings(const GroupClass& c, std::span<const std::uint8_t> computed) {
  Couplings out;
  for (std::int32_t i = 0; i < c.n; ++i) {
    std::vector<std::uint8_t> reads(computed.size(), 0);
    const auto read_input = [&](std::int32_t reg) {
      if (reg >= c.n && reg < c.one()) reads[idx(reg - c.n)] = 1;
    };
    const auto read = [&](std::int32_t reg) {
      read_input(reg);
      if (reg <= c.one()) return;
      const GroupClass::Form& f = c.forms[idx(reg - c.one() - 1)];  // the last registers, in order
      for (std::int32_t o = f.moving; o < f.unknowns; ++o) read_input(c.operands[idx(o)].reg);
    };
    const GroupClass::Equation& e = c.equations[idx(i)];
    for (std::int32_t o = e.input_linear.begin; o < e.input_linear.end; ++o) read(c.input_linear[idx(o)].reg);
    for (std::int32_t p = e.input_products.begin; p < e.input_products.end; ++p) read(c.input_products[idx(p)].a);
    const std::size_t before = out.entries.size();
    for (std::int32_t input = 0; input < c.inputs; ++input) {
      if (computed[idx(input)] != 0 && reads[idx(input)] != 0) out.entries.push_back({out.rows(), input});
    }
    if (out.entries.size() > before) out.equations.push_back(i);
  }
  return out;
}

}  // namespace

std::vector<Couplings> couplings_of(const GroupedSystem& s) {
  std::vector<std::uint8_t> is_computed(s.system->coordinates.size(), 0);
  for (const SolvedGroup& g : s.groups) {
    for (const std::int32_t u : g.unknowns) is_computed[idx(u)] = 1;
  }
  std::vector<std::vector<std::uint8_t>> computed;
  for (const GroupClass& c : s.classes) computed.emplace_back(idx(c.inputs), std::uint8_t{0});
  for (const SolvedGroup& g : s.groups) {
    std::vector<std::uint8_t>& of_class = computed[idx(g.group_class)];
    for (std::size_t i = 0; i < of_class.size(); ++i) of_class[i] |= is_computed[idx(g.inputs[i])];
  }
  std::vector<Couplings> out;
  for (std::size_t c = 0; c < s.classes.size(); ++c) out.push_back(couplings(s.classes[c], computed[c]));
  return out;
}

std::size_t work_of_together_step(const GroupClass& c) { return 2 * idx(c.n) + 1 + Inverse::most_numbers(c.n); }

StepProgram together_program(TogetherPass pass, const TogetherClass& of, const TogetherShape& shape) {
  StepProgram out{{TogetherWriter(of, shape).write(pass)}, {}};
  out.phases[0].lanes = shape.lanes_of(pass);
  return out;
}

}  // namespace assur
