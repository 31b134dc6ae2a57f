// Compiled once for each SIMD target; make_evaluator() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "equations/evaluator.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "equations/evaluator.hpp"
#include "equations/lane_vector-inl.hpp"

#include <limits>
#include <stdexcept>

#include "equations/callbacks.hpp"
#include "equations/lane_array.hpp"
#include "scene/residual_scale.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W>
class EvaluatorOf final : public Evaluator {
  using L = Lanes<W>;

 public:
  EvaluatorOf(const System& system, const Program& program)
      : p_(program),
        callbacks_(system, program, W),
        memory_(8 * static_cast<std::size_t>(program.registers) * W),
        value_(memory_.data()),
        base_(value_ + program.registers * W),
        base_magnitude_(base_ + program.registers * W),
        input_rate_(base_magnitude_ + program.registers * W),
        rate_(input_rate_ + program.registers * W),
        acceleration_(rate_ + program.registers * W),
        magnitude_(acceleration_ + program.registers * W),
        change_(magnitude_ + program.registers * W) {
    L::set(1).store(value_ + p_.one() * W);
  }

  void set_inputs(const double* coefficients, const double* inputs) override {
    k_ = coefficients;
    copy(inputs, p_.inputs, value_ + p_.n * W);
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

  void evaluate(const double* unknowns, double* phi, double* jacobian) override {
    copy(unknowns, p_.n, value_);
    for (const Program::Form& f : p_.forms) {
      sum(f.unknowns, f.end, value_, reg(base_, f.reg)).store(value_ + f.reg * W);
    }
    for (const Program::Equation& e : p_.equations) {
      L total = L::set(0);
      for (const Program::Operand* o = at(p_.linear, e.linear.begin); o != at(p_.linear, e.linear.end); ++o) {
        total.add_product(k(o->coefficient), reg(value_, o->reg));
      }
      for (const Program::Product* q = at(p_.products, e.products.begin); q != at(p_.products, e.products.end); ++q) {
        total.add_product(k(q->coefficient), reg(value_, q->a) * reg(value_, q->b));
      }
      total.store(phi);
      phi += W;
    }
    if (jacobian != nullptr) {
      double* entry = jacobian;
      for (const Program::Range& r : p_.entries) {
        L total = L::set(0);
        for (const Program::Operand* o = at(p_.entry_operands, r.begin); o != at(p_.entry_operands, r.end); ++o) {
          total.add_product(k(o->coefficient), reg(value_, o->reg));
        }
        total.store(entry);
        entry += W;
      }
    }
    if (callbacks_.empty()) return;
    callbacks_.residuals(k_, value_, phi - p_.equations_count * W);
    if (jacobian != nullptr) callbacks_.jacobian(k_, value_, jacobian);
  }

  void scale(double* scale) override {
    for (int i = 0; i <= p_.one(); ++i) abs(reg(value_, i)).store(magnitude_ + i * W);
    for (const Program::Form& f : p_.forms) {
      L total = reg(base_magnitude_, f.reg);
      for (const Program::Operand* o = at(p_.operands, f.unknowns); o != at(p_.operands, f.end); ++o) {
        total.add_product(abs(k(o->coefficient)), reg(magnitude_, o->reg));
      }
      total.store(magnitude_ + f.reg * W);
    }
    for (const Program::Equation& e : p_.equations) {
      L total = L::set(0);
      for (const Program::Operand* o = at(p_.linear, e.linear.begin); o != at(p_.linear, e.linear.end); ++o) {
        total.add_product(abs(k(o->coefficient)), reg(magnitude_, o->reg));
      }
      for (const Program::Product* q = at(p_.products, e.products.begin); q != at(p_.products, e.products.end); ++q) {
        L terms = reg(magnitude_, q->a) * abs(reg(value_, q->b));
        terms.add_product(abs(reg(value_, q->a)), reg(magnitude_, q->b));
        total.add_product(abs(k(q->coefficient)), terms);
      }
      total.store(scale);
      scale += W;
    }
    if (!callbacks_.empty()) callbacks_.scale(k_, value_, scale - p_.equations_count * W);
  }

  void raise_scale(double* scale) override {
    for (const Program::Equation& e : p_.equations) {
      L least = L::set(0), a = L::set(0), b = L::set(0);
      for (std::int32_t i = e.linear.begin; i < e.factors; ++i) {
        const Program::Operand& o = p_.linear[static_cast<std::size_t>(i)];
        least.add_product(abs(k(o.coefficient)), coordinates_of(o.reg));
      }
      const auto multiply = [&](const L& first, const L& second) {
        a.add_product(first, first);
        b.add_product(second, second);
      };
      for (const Program::Operand* o = at(p_.linear, e.factors); o != at(p_.linear, e.linear.end); ++o) {
        if (o->reg != p_.one()) multiply(k(o->coefficient), reg(value_, o->reg));
      }
      for (const Program::Product* q = at(p_.products, e.products.begin); q != at(p_.products, e.products.end); ++q) {
        if (q->a != q->b) multiply(k(q->coefficient) * reg(value_, q->a), reg(value_, q->b));
      }
      a = sqrt(a);
      b = sqrt(b);
      least.add_product(a, b);
      least.add_product(L::set(kLeastFactor), a + b);
      max_if_finite(L::load(scale), least).store(scale);
      scale += W;
    }
    if (!callbacks_.empty()) callbacks_.raise_scale(k_, value_, scale - p_.equations_count * W);
  }

  void rounding(double* bound) override {
    double* const error = magnitude_;  // of the registers
    for (int i = 0; i <= p_.one(); ++i) L::set(0).store(error + i * W);
    for (const Program::Form& f : p_.forms) {
      RoundedSum sum{L::set(0), L::set(0)};
      for (const Program::Operand* o = at(p_.operands, f.begin); o != at(p_.operands, f.end); ++o) {
        sum.add(k(o->coefficient), reg(value_, o->reg), L::set(0));
      }
      sum.error.store(error + f.reg * W);
    }
    for (const Program::Equation& e : p_.equations) {
      RoundedSum sum{L::set(0), L::set(0)};
      for (const Program::Operand* o = at(p_.linear, e.linear.begin); o != at(p_.linear, e.linear.end); ++o) {
        sum.add(k(o->coefficient), reg(value_, o->reg), reg(error, o->reg));
      }
      for (const Program::Product* q = at(p_.products, e.products.begin); q != at(p_.products, e.products.end); ++q) {
        const L a = reg(value_, q->a), b = reg(value_, q->b);
        L of_factors = reg(error, q->a) * abs(b);
        of_factors.add_product(abs(a), reg(error, q->b));
        of_factors.add_product(abs(a), abs(b));
        sum.add(k(q->coefficient), a * b, of_factors);
      }
      sum.error.store(bound);
      bound += W;
    }
    if (!callbacks_.empty()) callbacks_.scale(k_, value_, bound - p_.equations_count * W);
  }

  void velocity_rhs(const double* input_rates, double* rhs) override {
    set_input_derivatives(input_rates, input_rate_);
    for (std::size_t i = 0; i < p_.equations.size(); ++i) {
      input_terms(p_.equations[i], input_rate_, L::set(0)).store(rhs + i * W);
    }
    if (!callbacks_.empty()) callbacks_.rates(k_, value_, input_rate_, rhs);
  }

  void acceleration_rhs(const double* unknown_rates, const double* input_accelerations, double* rhs) override {
    copy(unknown_rates, p_.n, rate_);
    copy(input_rate_ + p_.n * W, p_.inputs, rate_ + p_.n * W);
    for (const Program::Form& f : p_.forms) {
      sum(f.unknowns, f.end, rate_, reg(input_rate_, f.reg)).store(rate_ + f.reg * W);
    }
    set_input_derivatives(input_accelerations, acceleration_);
    for (std::size_t i = 0; i < p_.equations.size(); ++i) {
      const Program::Equation& e = p_.equations[i];
      input_terms(e, acceleration_, curvature(e)).store(rhs + i * W);
    }
    if (callbacks_.empty()) return;
    callbacks_.rates(k_, value_, acceleration_, rhs);
    callbacks_.curvature(k_, value_, rate_, rhs);
  }

  void subtract_bend(const Change& a, const Change& b, double times, double* bent, double* out) override {
    set_change(a, rate_);
    set_change(b, change_);
    for (std::size_t i = 0; i < p_.equations.size(); ++i) {
      const Program::Equation& e = p_.equations[i];
      L twice = L::set(0);
      for (const Program::Product* q = at(p_.curvature, e.curvature.begin); q != at(p_.curvature, e.curvature.end);
           ++q) {
        twice.add_product(k(q->coefficient),
                          reg(rate_, q->a) * reg(change_, q->b) + reg(rate_, q->b) * reg(change_, q->a));
      }
      L of = L::load(out + i * W);
      of.subtract_product(L::set(times / 2), twice);
      of.store(out + i * W);
    }
    if (!callbacks_.empty()) subtract_bend_of_callbacks(a, b, times, bent, out);
  }

 private:
  template <class T>
  static HWY_INLINE const T* at(const std::vector<T>& list, std::int32_t i) {
    return list.data() + i;
  }
  static HWY_INLINE L reg(const double* registers, std::int32_t i) { return L::load(registers + i * W); }
  HWY_INLINE L k(std::int32_t i) const { return L::load(k_ + i * W); }

  // A sum and a bound of its rounding error, in units of epsilon / 2. Adding the first term, and multiplying by factors
  // of size 1, cause no rounding.
  struct RoundedSum {
    L value, error;

    HWY_INLINE void add(const L& coefficient, const L& term, const L& term_error) {
      const L before = abs(value);
      L product = coefficient * term;
      value = value + product;
      error = error + if_positive(before, abs(value), L::set(0));
      error.add_product(abs(coefficient), term_error);
      product = abs(product);
      error = error + if_positive(abs(abs(coefficient) - L::set(1)), product, L::set(0));
    }
  };

  static void copy(const double* from, std::int32_t count, double* to) {
    for (std::int32_t i = 0; i < count; ++i) L::load(from + i * W).store(to + i * W);
  }

  HWY_INLINE L sum(std::int32_t begin, std::int32_t end, const double* registers, L total) const {
    for (const Program::Operand* o = at(p_.operands, begin); o != at(p_.operands, end); ++o) {
      total.add_product(k(o->coefficient), reg(registers, o->reg));
    }
    return total;
  }

  // For a linear form: the sum of |coefficient| over its coordinates.
  L coordinates_of(std::int32_t r) const {
    if (r <= p_.one()) return L::set(r < p_.one() ? 1 : 0);
    const Program::Form& f = p_.forms[static_cast<std::size_t>(r - p_.one() - 1)];  // the last registers, in order
    L total = L::set(0);
    for (const Program::Operand* o = at(p_.operands, f.begin); o != at(p_.operands, f.end); ++o) {
      if (o->reg != p_.one()) total = total + abs(k(o->coefficient));
    }
    return total;
  }

  // Derivatives of inputs, and their contributions to forms. In `out`, the derivatives of unknowns and of fixed forms
  // stay zero.
  void set_input_derivatives(const double* inputs, double* out) const {
    copy(inputs, p_.inputs, out + p_.n * W);
    for (const Program::Form& f : p_.forms) {
      if (f.moving != f.unknowns) sum(f.moving, f.unknowns, out, L::set(0)).store(out + f.reg * W);
    }
  }

  // -Phi''[q', q'] with the rates at hand.
  HWY_INLINE L curvature(const Program::Equation& e) const {
    L total = L::set(0);
    for (const Program::Product* q = at(p_.curvature, e.curvature.begin); q != at(p_.curvature, e.curvature.end); ++q) {
      total.subtract_product(k(q->coefficient), reg(rate_, q->a) * reg(rate_, q->b));
    }
    return total;
  }

  void set_change(const Change& of, double* registers) const {
    copy(of.unknowns, p_.n, registers);
    copy(of.inputs, p_.inputs, registers + p_.n * W);
    set_forms(registers);
  }
  // The forms of the unknowns and of the moving inputs.
  void set_forms(double* registers) const {
    for (const Program::Form& f : p_.forms) {
      sum(f.unknowns, f.end, registers, sum(f.moving, f.unknowns, registers, L::set(0))).store(registers + f.reg * W);
    }
  }
  // By the curvatures along a + b and a - b. Scales a and b to size 1 in every lane, because their squares may
  // overflow. bent: one number for each equation
  void subtract_bend_of_callbacks(const Change& a, const Change& b, double times, double* bent, double* out) {
    const L factor = to_unit_size(a) * to_unit_size(b) * L::set(times) / L::set(4);
    for (const double side : {1.0, -1.0}) {
      const auto move = [&](const double* from, const double* by, std::int32_t count, double* to) {
        for (std::int32_t i = 0; i < count; ++i) (reg(from, i) + L::set(side) * reg(by, i)).store(to + i * W);
      };
      move(a.unknowns, b.unknowns, p_.n, rate_);
      move(a.inputs, b.inputs, p_.inputs, rate_ + p_.n * W);
      set_forms(rate_);
      for (std::size_t i = 0; i < p_.equations.size(); ++i) L::set(0).store(bent + i * W);
      callbacks_.curvature(k_, value_, rate_, bent);
      for (std::size_t i = 0; i < p_.equations.size(); ++i) {
        double* const of = out + i * W;
        (L::load(of) + L::set(side) * L::load(bent + i * W) * factor).store(of);
      }
    }
  }

  // Divides the numbers of each lane by the largest of them, and returns the divisors. Ignores NaN.
  L to_unit_size(const Change& change) const {
    const auto each = [&](const auto& work) {
      for (std::int32_t i = 0; i < p_.n; ++i) work(change.unknowns + i * W);
      for (std::int32_t i = 0; i < p_.inputs; ++i) work(change.inputs + i * W);
    };
    L largest = L::set(0);
    each([&](const double* x) {
      const L size = abs(L::load(x));
      largest = if_positive(size - largest, size, largest);
    });
    const L inverse = L::set(1) / largest, most = L::set(std::numeric_limits<double>::max());
    const L factor = if_positive(largest, if_positive(most - inverse, inverse, most), L::set(0));
    each([&](double* x) { (L::load(x) * factor).store(x); });
    return largest;
  }

  // total - sum of dPhi/dh * derivative over all inputs h that move
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
  CallbackRows callbacks_;
  LaneArray memory_;
  // registers x W; base: contribution of constants and inputs to a form
  double *value_, *base_, *base_magnitude_, *input_rate_, *rate_, *acceleration_, *magnitude_, *change_;
  const double* k_ = nullptr;  // coefficients of the current pack
};

Evaluator* make(const System& system, const Program& program, int lanes) {
  switch (lanes) {
    case 1:
      return new EvaluatorOf<1>(system, program);
    case 2:
      return new EvaluatorOf<2>(system, program);
    case 4:
      return new EvaluatorOf<4>(system, program);
    case 8:
      return new EvaluatorOf<8>(system, program);
    case 16:
      return new EvaluatorOf<16>(system, program);
    default:
      return nullptr;
  }
}

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);

std::unique_ptr<Evaluator> make_evaluator(const System& system, const Program& program, int lanes) {
  std::unique_ptr<Evaluator> evaluator(HWY_DYNAMIC_DISPATCH(make)(system, program, lanes));
  if (!evaluator) throw std::invalid_argument("lanes must be 1, 2, 4, 8 or 16");
  return evaluator;
}

}  // namespace assur
#endif
