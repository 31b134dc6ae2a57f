// The quadratic equations and the gears of a class, as their class lists them, with their derivatives, scales and
// bounds of their rounding: the one text for numbers in registers (Evaluator, SmallGroup) and for the programs of
// steps. Included once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_QUADRATIC_EQUATIONS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_QUADRATIC_EQUATIONS_INL
#undef ASSUR_QUADRATIC_EQUATIONS_INL
#else
#define ASSUR_QUADRATIC_EQUATIONS_INL
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "equations/residual_scale.hpp"
#include "evaluation/coefficients.hpp"
#include "evaluation/gear_rows-inl.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// L: Lanes, or Value. Numbers of the caller are functions:
//   L k(i)          coefficient i of the equations, also zero_coefficient() and one_coefficient()
//   L x(j), h(i)    an unknown, an input, or a derivative of one
//   void put(i, L)  takes the result for equation i, or for nonzero i of the Jacobian
// The first n registers are the unknowns; the caller sets them. Registers keep what a function needs of an earlier one.
template <class L>
class QuadraticEquations {
  using Operand = GroupClass::Operand;
  using Product = GroupClass::Product;

 public:
  using Array = typename L::Array;  // of registers

  explicit QuadraticEquations(const GroupClass& group_class) : class_(group_class) {
    value_.set(idx(class_.one()), L::set(1));
  }

  [[nodiscard]] Array& values() { return value_; }
  [[nodiscard]] Array& input_rates() { return input_rate_; }
  [[nodiscard]] Array& rates() { return rate_; }
  [[nodiscard]] Array& accelerations() { return acceleration_; }
  [[nodiscard]] HWY_INLINE L value(std::int32_t reg) const { return value_[idx(reg)]; }

  // The parts of the forms that do not depend on the unknowns.
  template <class Coefficient, class Input>
  HWY_INLINE void set_inputs(const Coefficient& k, const Input& h) {
    for (std::int32_t i = 0; i < class_.inputs; ++i) value_.set(idx(class_.n + i), h(i));
    for (std::size_t f = 0; f < class_.forms.size(); ++f) {
      L total = L::set(0), magnitude = L::set(0);
      for (const Operand& o : part(class_.operands, class_.forms[f].begin, class_.forms[f].unknowns)) {
        const L term = k(o.coefficient) * value(o.reg);
        total = total + term;
        magnitude = magnitude + abs(term);
      }
      base_.set(f, total);
      base_magnitude_.set(f, magnitude);
    }
  }

  // Phi, for the unknowns in values().
  template <class Coefficient, class Put>
  HWY_INLINE void evaluate(const Coefficient& k, const Put& put) {
    for (std::size_t f = 0; f < class_.forms.size(); ++f) {
      value_.set(idx(class_.forms[f].reg), sum(k, class_.forms[f].unknowns, class_.forms[f].end, value_, base_[f]));
    }
    gears_.evaluate(k, value_);
    for (std::size_t i = 0; i < class_.equations.size(); ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      L total = e.gear < 0 ? L::set(0) : gears_.residual(e.gear);
      for (const Operand& o : part(class_.linear, e.linear)) total.add_product(k(o.coefficient), value(o.reg));
      for (const Product& q : part(class_.products, e.products)) {
        total.add_product(k(q.coefficient), value(q.a) * value(q.b));
      }
      put(i, total);
    }
  }

  // After evaluate(): the nonzeros of the Jacobian.
  template <class Coefficient, class Put>
  HWY_INLINE void differentiate(const Coefficient& k, const Put& put) const {
    const GroupClass::GearEntry* of_gear = class_.gear_entries.data();
    const GroupClass::GearEntry* const end = of_gear + class_.gear_entries.size();
    for (std::size_t e = 0; e < class_.entries.size(); ++e) {
      L total = L::set(0);
      for (const Operand& o : part(class_.entry_operands, class_.entries[e])) {
        total.add_product(k(o.coefficient), value(o.reg));
      }
      for (; of_gear != end && idx(of_gear->nonzero) == e; ++of_gear) {
        total.add_product(k(of_gear->coefficient), gears_.derivative(of_gear->gear, of_gear->argument));
      }
      put(e, total);
    }
  }

  // After evaluate(): sum_j |dPhi_i/dq_j| |q_j| + |constant|, over unknowns and inputs.
  template <class Coefficient, class Put>
  HWY_INLINE void scale(const Coefficient& k, const Put& put) {
    for (std::int32_t i = 0; i <= class_.one(); ++i) magnitude_.set(idx(i), abs(value(i)));
    for (std::size_t f = 0; f < class_.forms.size(); ++f) {
      L total = base_magnitude_[f];
      for (const Operand& o : part(class_.operands, class_.forms[f].unknowns, class_.forms[f].end)) {
        total.add_product(abs(k(o.coefficient)), magnitude_[idx(o.reg)]);
      }
      magnitude_.set(idx(class_.forms[f].reg), total);
    }
    for (std::size_t i = 0; i < class_.equations.size(); ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      L total = e.gear < 0 ? L::set(0) : gears_.scale(e.gear);
      for (const Operand& o : part(class_.linear, e.linear)) {
        total.add_product(abs(k(o.coefficient)), magnitude_[idx(o.reg)]);
      }
      for (const Product& q : part(class_.products, e.products)) {
        L terms = magnitude_[idx(q.a)] * abs(value(q.b));
        terms.add_product(abs(value(q.a)), magnitude_[idx(q.b)]);
        total.add_product(abs(k(q.coefficient)), terms);
      }
      put(i, total);
    }
  }

  // After evaluate(): the lower bounds of scales that residual_scale() explains.
  template <class Coefficient, class Put>
  HWY_INLINE void least_scale(const Coefficient& k, const Put& put) const {
    for (std::size_t i = 0; i < class_.equations.size(); ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      L least = e.gear < 0 ? L::set(0) : gears_.least_scale(e.gear), a = L::set(0), b = L::set(0);
      for (const Operand& o : part(class_.linear, e.linear.begin, e.factors)) {
        least.add_product(abs(k(o.coefficient)), coordinates_of(k, o.reg));
      }
      const auto multiply = [&](const L& first, const L& second) HWY_ATTR {
        a.add_product(first, first);
        b.add_product(second, second);
      };
      for (const Operand& o : part(class_.linear, e.factors, e.linear.end)) {
        if (o.reg != class_.one()) multiply(k(o.coefficient), value(o.reg));
      }
      for (const Product& q : part(class_.products, e.products)) {
        if (q.a != q.b) multiply(k(q.coefficient) * value(q.a), value(q.b));
      }
      a = sqrt(a);
      b = sqrt(b);
      least.add_product(a, b);
      least.add_product(L::set(kLeastFactor), a + b);
      put(i, least);
    }
  }

  // After evaluate(): see Evaluator::rounding().
  template <class Coefficient, class Put>
  HWY_INLINE void rounding(const Coefficient& k, const Put& put) {
    Array& error = magnitude_;
    for (std::int32_t i = 0; i <= class_.one(); ++i) error.set(idx(i), L::set(0));
    for (const GroupClass::Form& f : class_.forms) {
      RoundedSum sum{L::set(0), L::set(0)};
      for (const Operand& o : part(class_.operands, f.begin, f.end)) sum.add(k(o.coefficient), value(o.reg), L::set(0));
      error.set(idx(f.reg), sum.error);
    }
    for (std::size_t i = 0; i < class_.equations.size(); ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      RoundedSum sum{L::set(0), e.gear < 0 ? L::set(0) : gears_.rounding(e.gear)};
      for (const Operand& o : part(class_.linear, e.linear)) sum.add(k(o.coefficient), value(o.reg), error[idx(o.reg)]);
      for (const Product& q : part(class_.products, e.products)) {
        const L a = value(q.a), b = value(q.b);
        L of_factors = error[idx(q.a)] * abs(b);
        of_factors.add_product(abs(a), error[idx(q.b)]);
        of_factors.add_product(abs(a), abs(b));
        sum.add(k(q.coefficient), a * b, of_factors);
      }
      put(i, sum.error);
    }
  }

  // After evaluate(): -Phi_h h'. h: rates
  template <class Coefficient, class Input, class Put>
  HWY_INLINE void velocity_rhs(const Coefficient& k, const Input& h, const Put& put) {
    derive(k, h, input_rate_);
    for (std::size_t i = 0; i < class_.equations.size(); ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      L total = e.gear < 0 ? L::set(0) : L::set(0) - gears_.change(e.gear, input_rate_);
      subtract_inputs(k, e, input_rate_, total);
      put(i, total);
    }
  }

  // After velocity_rhs(): -(Phi_h h'' + d/dt(Phi_q) q'), for the rates of the unknowns in rates(). h: accelerations
  template <class Coefficient, class Input, class Put>
  HWY_INLINE void acceleration_rhs(const Coefficient& k, const Input& h, const Put& put) {
    for (std::int32_t i = class_.n; i < class_.one(); ++i) rate_.set(idx(i), input_rate_[idx(i)]);
    for (const GroupClass::Form& f : class_.forms) {
      rate_.set(idx(f.reg), sum(k, f.unknowns, f.end, rate_, input_rate_[idx(f.reg)]));
    }
    derive(k, h, acceleration_);
    for (std::size_t i = 0; i < class_.equations.size(); ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      L total = L::set(0);
      if (e.gear >= 0)
        total = total - gears_.change(e.gear, acceleration_) - gears_.bend(e.gear, k, value_, rate_, rate_);
      for (const Product& q : part(class_.curvature, e.curvature)) {
        total.subtract_product(k(q.coefficient), rate_[idx(q.a)] * rate_[idx(q.b)]);
      }
      subtract_inputs(k, e, acceleration_, total);
      put(i, total);
    }
  }

  // Phi''[a, b] for the changes of all coordinates in two sets of registers, see set_change(). twice: put() takes twice
  // of it
  template <class Coefficient, class Put>
  HWY_INLINE void twice_bend(const Coefficient& k, const Array& a, const Array& b, const Put& put) const {
    for (std::size_t i = 0; i < class_.equations.size(); ++i) {
      const GroupClass::Equation& e = class_.equations[i];
      L twice = e.gear < 0 ? L::set(0) : L::set(2) * gears_.bend(e.gear, k, value_, a, b);
      for (const Product& q : part(class_.curvature, e.curvature)) {
        twice.add_product(k(q.coefficient), a[idx(q.a)] * b[idx(q.b)] + a[idx(q.b)] * b[idx(q.a)]);
      }
      put(i, twice);
    }
  }
  // x, h: changes
  template <class Coefficient, class Unknown, class Input>
  HWY_INLINE void set_change(const Coefficient& k, const Unknown& x, const Input& h, Array& out) const {
    for (std::int32_t j = 0; j < class_.n; ++j) out.set(idx(j), x(j));
    for (std::int32_t i = 0; i < class_.inputs; ++i) out.set(idx(class_.n + i), h(i));
    set_forms(k, out);
  }
  // The forms of the unknowns and of the moving inputs.
  template <class Coefficient>
  HWY_INLINE void set_forms(const Coefficient& k, Array& registers) const {
    for (const GroupClass::Form& f : class_.forms) {
      const L of_inputs = sum(k, f.moving, f.unknowns, registers, L::set(0));
      registers.set(idx(f.reg), sum(k, f.unknowns, f.end, registers, of_inputs));
    }
  }

 private:
  template <class T>
  struct Slice {
    const T *first, *last;
    [[nodiscard]] HWY_INLINE const T* begin() const { return first; }
    [[nodiscard]] HWY_INLINE const T* end() const { return last; }
  };
  template <class T>
  static HWY_INLINE Slice<T> part(const std::vector<T>& list, std::int32_t begin, std::int32_t end) {
    return {list.data() + begin, list.data() + end};
  }
  template <class T>
  static HWY_INLINE Slice<T> part(const std::vector<T>& list, const GroupClass::Range& r) {
    return part(list, r.begin, r.end);
  }

  // A sum and a bound of its rounding error, in units of epsilon / 2. Adding the first term, and multiplying by factors
  // of size 1, cause no rounding.
  struct RoundedSum {
    L value, error;

    HWY_INLINE void add(const L& coefficient, const L& term, const L& term_error) {
      const L before = abs(value), zero = L::set(0);
      L product = coefficient * term;
      value = value + product;
      error = error + if_at_most(before, zero, zero, abs(value));
      error.add_product(abs(coefficient), term_error);
      product = abs(product);
      error = error + if_at_most(abs(abs(coefficient) - L::set(1)), zero, zero, product);
    }
  };

  template <class Coefficient>
  HWY_INLINE L sum(const Coefficient& k, std::int32_t begin, std::int32_t end, const Array& registers, L total) const {
    for (const Operand& o : part(class_.operands, begin, end))
      total.add_product(k(o.coefficient), registers[idx(o.reg)]);
    return total;
  }
  // For a linear form: the sum of |coefficient| over its coordinates.
  template <class Coefficient>
  HWY_INLINE L coordinates_of(const Coefficient& k, std::int32_t r) const {
    if (r <= class_.one()) return L::set(r < class_.one() ? 1 : 0);
    const GroupClass::Form& f = class_.forms[idx(r - class_.one() - 1)];  // the last registers, in order
    L total = L::set(0);
    for (const Operand& o : part(class_.operands, f.begin, f.end)) {
      if (o.reg != class_.one()) total = total + abs(k(o.coefficient));
    }
    return total;
  }
  // Derivatives of inputs, and their contributions to forms. In `out`, the derivatives of unknowns and of fixed forms
  // stay zero.
  template <class Coefficient, class Input>
  HWY_INLINE void derive(const Coefficient& k, const Input& h, Array& out) const {
    for (std::int32_t i = 0; i < class_.inputs; ++i) out.set(idx(class_.n + i), h(i));
    for (const GroupClass::Form& f : class_.forms) {
      if (f.moving != f.unknowns) out.set(idx(f.reg), sum(k, f.moving, f.unknowns, out, L::set(0)));
    }
  }
  // total -= sum of dPhi/dh * derivative over all inputs h that move
  template <class Coefficient>
  HWY_INLINE void subtract_inputs(const Coefficient& k, const GroupClass::Equation& e, const Array& derivative,
                                  L& total) const {
    for (const Operand& o : part(class_.input_linear, e.input_linear)) {
      total.subtract_product(k(o.coefficient), derivative[idx(o.reg)]);
    }
    for (const Product& q : part(class_.input_products, e.input_products)) {
      total.subtract_product(k(q.coefficient), derivative[idx(q.a)] * value(q.b));
    }
  }

  const GroupClass& class_;
  GearRows<L> gears_{class_};
  Array value_{idx(class_.registers())}, magnitude_{idx(class_.registers())};
  Array base_{class_.forms.size()}, base_magnitude_{class_.forms.size()};  // parts from constants and inputs
  Array input_rate_{idx(class_.registers())}, rate_{idx(class_.registers())}, acceleration_{idx(class_.registers())};
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
