// Quadratic equations of a small group, as their Program lists them. Included once for each target, inside its
// HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_GENERAL_EQUATIONS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_GENERAL_EQUATIONS_INL
#undef ASSUR_GENERAL_EQUATIONS_INL
#else
#define ASSUR_GENERAL_EQUATIONS_INL
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "assur/structure.hpp"
#include "equations/program.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Has the functions of DistanceEquations that SmallGroup calls. L, Source: see SmallGroup.
template <class L, int N>
class GeneralEquations {
 public:
  using Column = L[N];
  using Matrix = L[N][N];
  using Array = typename L::Array;
  struct Values {};  // registers hold them

  GeneralEquations(const GroupClass& group_class, const Program& program)
      : p_(program),
        values_(idx(program.registers)),
        by_inputs_{Array(idx(program.registers)), Array(idx(program.registers))},
        rates_(idx(program.registers)),
        known_(program.forms.size()),
        magnitudes_(program.forms.size()) {
    for (std::int32_t i = 0; i < p_.inputs; ++i) {
      if (group_class.input_moves[idx(i)] != 0) moving_.push_back(i);
    }
    values_.set(idx(p_.one()), L::set(1));
    for (const Program::Equation& e : p_.equations) {
      for (const Program::Operand& o : part(p_.linear, e.linear)) may_vanish_ = may_vanish_ || o.reg != p_.one();
    }
  }

  template <class Source>
  HWY_INLINE void set_inputs(const Source& in) {
    for (std::int32_t i = 0; i < p_.inputs; ++i) values_.set(idx(N + i), in.input(0, i));
    for (std::size_t f = 0; f < p_.forms.size(); ++f) {
      L total = L::set(0), magnitude = total;
      for (const Program::Operand& o : part(p_.operands, {p_.forms[f].begin, p_.forms[f].unknowns})) {
        const L term = in.coefficient(o.coefficient) * values_[idx(o.reg)];
        total = total + term;
        magnitude = magnitude + abs(term);
      }
      known_.set(f, total);
      magnitudes_.set(f, magnitude);
    }
  }
  template <class Source>
  HWY_INLINE void set_rates(const Source& in) {
    derive(in, 1, by_inputs_[0]);
  }
  template <class Source>
  HWY_INLINE void set_accelerations(const Source& in) {
    derive(in, 2, by_inputs_[1]);
  }
  // True if all terms of an equation may vanish: unless each is a sum of squares and a constant.
  [[nodiscard]] bool may_vanish() const { return may_vanish_; }

  template <class Source>
  HWY_INLINE void evaluate(const Source& in, const Column& x, Values&, Column& phi) {
    for (int j = 0; j < N; ++j) values_.set(idx(j), x[j]);
    for (std::size_t f = 0; f < p_.forms.size(); ++f) {
      L total = known_[f];
      for (const Program::Operand& o : part(p_.operands, {p_.forms[f].unknowns, p_.forms[f].end})) {
        total.add_product(in.coefficient(o.coefficient), values_[idx(o.reg)]);
      }
      values_.set(idx(p_.forms[f].reg), total);
    }
    for (int i = 0; i < N; ++i) {
      const Program::Equation& e = p_.equations[idx(i)];
      phi[i] = L::set(0);
      for (const Program::Operand& o : part(p_.linear, e.linear)) {
        phi[i].add_product(in.coefficient(o.coefficient), values_[idx(o.reg)]);
      }
      for (const Program::Product& t : part(p_.products, e.products)) {
        phi[i].add_product(in.coefficient(t.coefficient) * values_[idx(t.a)], values_[idx(t.b)]);
      }
    }
  }
  template <class Source>
  HWY_INLINE void differentiate(const Source& in, const Values&, Matrix& jacobian) const {
    for (int column = 0; column < N; ++column) {
      for (int row = 0; row < N; ++row) jacobian[row][column] = L::set(0);
      for (std::int32_t k = p_.pattern.column_start[idx(column)]; k < p_.pattern.column_start[idx(column) + 1]; ++k) {
        L& entry = jacobian[p_.pattern.row[idx(k)]][column];
        for (const Program::Operand& o : part(p_.entry_operands, p_.entries[idx(k)])) {
          entry.add_product(in.coefficient(o.coefficient), values_[idx(o.reg)]);
        }
      }
    }
  }
  // sum_j |dPhi_i/dq_j| |q_j| + |constant|, over unknowns and inputs.
  template <class Source>
  HWY_INLINE L scale_of(const Source& in, int i, const Column&, const Values&) const {
    const Program::Equation& e = p_.equations[idx(i)];
    L total = L::set(0);
    for (const Program::Operand& o : part(p_.linear, e.linear)) {
      total.add_product(abs(in.coefficient(o.coefficient)), magnitude(in, o.reg));
    }
    for (const Program::Product& t : part(p_.products, e.products)) {
      L size = magnitude(in, t.a) * abs(values_[idx(t.b)]);
      size.add_product(abs(values_[idx(t.a)]), magnitude(in, t.b));
      total.add_product(abs(in.coefficient(t.coefficient)), size);
    }
    return total;
  }
  // -Phi_h h'
  template <class Source>
  HWY_INLINE void velocity_rhs(const Source& in, const Column&, const Values&, Column& rhs) const {
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      subtract_inputs(in, p_.equations[idx(i)], by_inputs_[0], rhs[i]);
    }
  }
  // -(Phi_h h'' + Phi'_q q')
  template <class Source>
  HWY_INLINE void acceleration_rhs(const Source& in, const Column&, const Values&, const Column& rate, Column& rhs) {
    for (int j = 0; j < N; ++j) rates_.set(idx(j), rate[j]);
    for (const std::int32_t i : moving_) rates_.set(idx(N + i), by_inputs_[0][idx(N + i)]);
    for (const Program::Form& f : p_.forms) {
      L total = by_inputs_[0][idx(f.reg)];
      for (const Program::Operand& o : part(p_.operands, {f.unknowns, f.end})) {
        total.add_product(in.coefficient(o.coefficient), rates_[idx(o.reg)]);
      }
      rates_.set(idx(f.reg), total);
    }
    for (int i = 0; i < N; ++i) {
      const Program::Equation& e = p_.equations[idx(i)];
      rhs[i] = L::set(0);
      for (const Program::Product& t : part(p_.curvature, e.curvature)) {
        rhs[i].subtract_product(in.coefficient(t.coefficient) * rates_[idx(t.a)], rates_[idx(t.b)]);
      }
      subtract_inputs(in, e, by_inputs_[1], rhs[i]);
    }
  }

  // After set_inputs().
  HWY_INLINE L input(std::int32_t i) const { return values_[idx(N + i)]; }

 private:
  template <class T>
  struct Part {
    const T *first, *last;
    [[nodiscard]] const T* begin() const { return first; }
    [[nodiscard]] const T* end() const { return last; }
  };
  template <class T>
  static HWY_INLINE Part<T> part(const std::vector<T>& list, const Program::Range& r) {
    return {list.data() + r.begin, list.data() + r.end};
  }
  // Sum of the magnitudes of the terms of a register.
  template <class Source>
  HWY_INLINE L magnitude(const Source& in, std::int32_t reg) const {
    if (reg <= p_.one()) return abs(values_[idx(reg)]);
    const std::size_t f = idx(reg - p_.one() - 1);
    L total = magnitudes_[f];
    for (const Program::Operand& o : part(p_.operands, {p_.forms[f].unknowns, p_.forms[f].end})) {
      total.add_product(abs(in.coefficient(o.coefficient)), abs(values_[idx(o.reg)]));
    }
    return total;
  }
  // Derivatives of the registers that come from inputs.
  template <class Source>
  HWY_INLINE void derive(const Source& in, int derivative, Array& out) {
    for (const std::int32_t i : moving_) out.set(idx(N + i), in.input(derivative, i));
    for (const Program::Form& f : p_.forms) {
      L total = L::set(0);
      for (const Program::Operand& o : part(p_.operands, {f.moving, f.unknowns})) {
        total.add_product(in.coefficient(o.coefficient), out[idx(o.reg)]);
      }
      out.set(idx(f.reg), total);
    }
  }
  template <class Source>
  HWY_INLINE void subtract_inputs(const Source& in, const Program::Equation& e, const Array& derivatives,
                                  L& from) const {
    for (const Program::Operand& o : part(p_.input_linear, e.input_linear)) {
      from.subtract_product(in.coefficient(o.coefficient), derivatives[idx(o.reg)]);
    }
    for (const Program::Product& t : part(p_.input_products, e.input_products)) {
      from.subtract_product(in.coefficient(t.coefficient) * derivatives[idx(t.a)], values_[idx(t.b)]);
    }
  }

  const Program& p_;
  std::vector<std::int32_t> moving_;  // inputs
  bool may_vanish_ = false;
  Array values_;              // registers
  Array by_inputs_[2];        // registers: rates and accelerations, as far as inputs cause them
  Array rates_;               // registers
  Array known_, magnitudes_;  // forms: parts from constants and inputs
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
