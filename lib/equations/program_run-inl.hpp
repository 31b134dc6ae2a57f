// The parts of a Program's evaluation, over W lanes: they are put together by Evaluator and by the steps of small
// groups. Included once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_PROGRAM_RUN_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_PROGRAM_RUN_INL
#undef ASSUR_PROGRAM_RUN_INL
#else
#define ASSUR_PROGRAM_RUN_INL
#endif

#include <cstddef>
#include <vector>

#include "equations/lane_vector-inl.hpp"
#include "equations/program.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Registers are written by the caller, [register][lane]: unknowns and inputs at their own number. Each forms_of...()
// completes them with the forms; it wants those before it in this list to have been called.
template <int W>
class ProgramRun {
  using L = Lanes<W>;

 public:
  explicit ProgramRun(const Program& program)
      : p_(program),
        memory_(7 * static_cast<std::size_t>(program.registers) * W),
        value_(memory_.data()),
        base_(value_ + program.registers * W),
        base_magnitude_(base_ + program.registers * W),
        input_rate_(base_magnitude_ + program.registers * W),
        rate_(input_rate_ + program.registers * W),
        acceleration_(rate_ + program.registers * W),
        magnitude_(acceleration_ + program.registers * W) {
    L::set(1).store(value_ + p_.one() * W);
    L::set(1).store(magnitude_ + p_.one() * W);
    std::vector<bool> read(static_cast<std::size_t>(p_.one()));
    const auto mark = [&](std::int32_t reg) {
      if (reg >= p_.one() || read[static_cast<std::size_t>(reg)]) return;
      read[static_cast<std::size_t>(reg)] = true;
      read_directly_.push_back(reg);
    };
    for (const Program::Operand& o : p_.linear) mark(o.reg);
    for (const Program::Product& q : p_.products) {
      mark(q.a);
      mark(q.b);
    }
  }

  [[nodiscard]] const Program& program() const { return p_; }
  void set_coefficients(const double* coefficients) { k_ = coefficients; }

  [[nodiscard]] double* values() const { return value_; }
  [[nodiscard]] double* input_rates() const { return input_rate_; }
  [[nodiscard]] double* rates() const { return rate_; }  // of unknowns and, again, of inputs
  [[nodiscard]] double* input_accelerations() const { return acceleration_; }

  HWY_INLINE void forms_of_inputs() {
    for (const Program::Form& f : p_.forms) {
      L total = L::set(0), magnitude = L::set(0);
      for (const Program::Operand* o = at(p_.operands, f.begin); o != at(p_.operands, f.unknowns); ++o) {
        const L term = k(o->coefficient) * reg(value_, o->reg);
        total = total + term;
        magnitude = magnitude + abs(term);
      }
      total.store(base_ + f.reg * W);
      magnitude.store(base_magnitude_ + f.reg * W);
    }
  }
  HWY_INLINE void forms_of_unknowns() {
    for (const Program::Form& f : p_.forms) {
      sum(f.unknowns, f.end, value_, reg(base_, f.reg)).store(value_ + f.reg * W);
    }
  }
  HWY_INLINE void forms_of_magnitudes() {
    for (const std::int32_t i : read_directly_) abs(reg(value_, i)).store(magnitude_ + i * W);
    for (const Program::Form& f : p_.forms) {
      L total = reg(base_magnitude_, f.reg);
      for (const Program::Operand* o = at(p_.operands, f.unknowns); o != at(p_.operands, f.end); ++o) {
        total.add_product(abs(k(o->coefficient)), abs(reg(value_, o->reg)));
      }
      total.store(magnitude_ + f.reg * W);
    }
  }
  // Of the inputs: what stands still has no rate, and neither have forms of it.
  HWY_INLINE void forms_of_input_rates() { forms_of_moving(input_rate_); }
  HWY_INLINE void forms_of_rates() {
    for (const Program::Form& f : p_.forms) {
      sum(f.unknowns, f.end, rate_, reg(input_rate_, f.reg)).store(rate_ + f.reg * W);
    }
  }
  HWY_INLINE void forms_of_input_accelerations() { forms_of_moving(acceleration_); }

  // Phi_i
  HWY_INLINE L residual(const Program::Equation& e) const {
    L total = L::set(0);
    for (const Program::Operand* o = at(p_.linear, e.linear.begin); o != at(p_.linear, e.linear.end); ++o) {
      total.add_product(k(o->coefficient), reg(value_, o->reg));
    }
    for (const Program::Product* q = at(p_.products, e.products.begin); q != at(p_.products, e.products.end); ++q) {
      total.add_product(k(q->coefficient), reg(value_, q->a) * reg(value_, q->b));
    }
    return total;
  }
  // A nonzero of the Jacobian; an empty range is a zero.
  HWY_INLINE L entry(const Program::Range& r) const {
    L total = L::set(0);
    for (const Program::Operand* o = at(p_.entry_operands, r.begin); o != at(p_.entry_operands, r.end); ++o) {
      total.add_product(k(o->coefficient), reg(value_, o->reg));
    }
    return total;
  }
  // sum_j |dPhi_i/dq_j| |q_j| + |constant|
  HWY_INLINE L scale(const Program::Equation& e) const {
    L total = L::set(0);
    for (const Program::Operand* o = at(p_.linear, e.linear.begin); o != at(p_.linear, e.linear.end); ++o) {
      total.add_product(abs(k(o->coefficient)), reg(magnitude_, o->reg));
    }
    for (const Program::Product* q = at(p_.products, e.products.begin); q != at(p_.products, e.products.end); ++q) {
      L terms = reg(magnitude_, q->a) * abs(reg(value_, q->b));
      terms.add_product(abs(reg(value_, q->a)), reg(magnitude_, q->b));
      total.add_product(abs(k(q->coefficient)), terms);
    }
    return total;
  }
  // -Phi_h h'
  HWY_INLINE L velocity_rhs(const Program::Equation& e) const { return input_terms(e, input_rate_, L::set(0)); }
  // -(Phi_h h'' + d/dt(Phi_q) q')
  HWY_INLINE L acceleration_rhs(const Program::Equation& e) const {
    L total = L::set(0);
    for (const Program::Product* q = at(p_.curvature, e.curvature.begin); q != at(p_.curvature, e.curvature.end); ++q) {
      total.subtract_product(k(q->coefficient), reg(rate_, q->a) * reg(rate_, q->b));
    }
    return input_terms(e, acceleration_, total);
  }

 private:
  template <class T>
  static HWY_INLINE const T* at(const std::vector<T>& list, std::int32_t i) {
    return list.data() + i;
  }
  static HWY_INLINE L reg(const double* registers, std::int32_t i) { return L::load(registers + i * W); }
  HWY_INLINE L k(std::int32_t i) const { return L::load(k_ + i * W); }

  HWY_INLINE L sum(std::int32_t begin, std::int32_t end, const double* registers, L total) const {
    for (const Program::Operand* o = at(p_.operands, begin); o != at(p_.operands, end); ++o) {
      total.add_product(k(o->coefficient), reg(registers, o->reg));
    }
    return total;
  }
  HWY_INLINE void forms_of_moving(double* derivative) const {
    for (const Program::Form& f : p_.forms) {
      if (f.moving != f.unknowns) sum(f.moving, f.unknowns, derivative, L::set(0)).store(derivative + f.reg * W);
    }
  }
  // total - sum over what moves of dPhi/dh * derivative
  HWY_INLINE L input_terms(const Program::Equation& e, const double* derivative, L total) const {
    for (const Program::Operand* o = at(p_.input_linear, e.input_linear.begin);
         o != at(p_.input_linear, e.input_linear.end); ++o) {
      total.subtract_product(k(o->coefficient), reg(derivative, o->reg));
    }
    for (const Program::Product* q = at(p_.input_products, e.input_products.begin);
         q != at(p_.input_products, e.input_products.end); ++q) {
      total.subtract_product(k(q->coefficient), reg(derivative, q->a) * reg(value_, q->b));
    }
    return total;
  }

  const Program& p_;
  std::vector<std::int32_t> read_directly_;  // coordinates that stand in equations without a form around them
  std::vector<double> memory_;
  // registers x W; base: what constants and inputs add to a form
  double *value_, *base_, *base_magnitude_, *input_rate_, *rate_, *acceleration_, *magnitude_;
  const double* k_ = nullptr;  // coefficients of the pack at hand
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
