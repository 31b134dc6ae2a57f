// Separable equations of a small group. Included once for each target, inside its HWY_NAMESPACE (see Highway,
// "foreach_target.h").
#if defined(ASSUR_SEPARABLE_EQUATIONS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SEPARABLE_EQUATIONS_INL
#undef ASSUR_SEPARABLE_EQUATIONS_INL
#else
#define ASSUR_SEPARABLE_EQUATIONS_INL
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "assur/structure.hpp"
#include "equations/coefficients.hpp"
#include "equations/separable.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Has the functions of DistanceEquations. It has fewer loops than GeneralEquations: by kernels, a step of the platform
// takes 0.8 of the time. L, Source: see SmallGroup.
template <class L, int N>
class SeparableEquations {
  enum Part { kValue, kMagnitude, kRate, kAcceleration, kParts };

 public:
  using Column = L[N];
  using Matrix = L[N][N];
  using Values = Matrix;  // u_ij = a_ij x_j + b_ij
  using Array = typename L::Array;
  static constexpr bool kDistances = false;

  SeparableEquations(const GroupClass& group_class, const Separable& separable)
      : class_(group_class), e_(separable), registers_(idx((group_class.registers() + 1) * kParts)) {
    for (std::int32_t i = 0; i < class_.inputs; ++i) {
      if (group_class.input_moves[idx(i)] != 0) moving_.push_back(i);
    }
    set(kValue, class_.one(), L::set(1));
    // Missing numbers have a slot, too, so that their uses need no test. The last register is 0.
    const auto or_else = [](std::int32_t& slot, std::int32_t other) {
      if (slot == Separable::kNone) slot = other;
    };
    for (Separable::Square& q : e_.squares) {
      or_else(q.s, zero_coefficient(class_));
      or_else(q.a, one_coefficient(class_));
      or_else(q.b, class_.registers());
    }
    for (std::vector<Separable::Linear>* list : {&e_.linear, &e_.moving_linear}) {
      for (Separable::Linear& t : *list) or_else(t.slope, one_coefficient(class_));
    }
  }

  // kMeasure: also the magnitudes, for scale().
  template <bool kMeasure = true, class Source>
  HWY_INLINE void set_inputs(const Source& in) {
    for (std::int32_t i = 0; i < class_.inputs; ++i) set(kValue, N + i, in.input(0, i));
    for (const GroupClass::Form& f : class_.forms) {
      L total = L::set(0), magnitude = total;
      for (std::int32_t o = f.begin; o < f.unknowns; ++o) {
        const GroupClass::Operand& operand = class_.operands[idx(o)];
        const L term = in.coefficient(operand.coefficient) * get(kValue, operand.reg);
        total = total + term;
        if (kMeasure) magnitude = magnitude + abs(term);
      }
      set(kValue, f.reg, total);
      if (kMeasure) set(kMagnitude, f.reg, magnitude);
    }
    set_known<kMeasure>(in);
    if (!e_.linear.empty()) set_linear<kMeasure>(in);
  }
  template <class Source>
  HWY_INLINE void set_rates(const Source& in) {
    derive<kRate>(in, 1);
  }
  template <class Source>
  HWY_INLINE void set_accelerations(const Source& in) {
    derive<kAcceleration>(in, 2);
  }
  [[nodiscard]] static constexpr bool has_gears() { return false; }
  [[nodiscard]] bool may_vanish() const { return !e_.linear.empty(); }

  template <class Source>
  HWY_INLINE void evaluate(const Source& in, const Column& x, Values& u, Column& phi) const {
    for (int i = 0; i < N; ++i) {
      phi[i] = known_[idx(i)];
      for (int j = 0; j < N; ++j) {
        u[i][j] = get(kValue, square(i, j).b);
        u[i][j].add_product(in.coefficient(square(i, j).a), x[j]);
        phi[i].add_product(in.coefficient(square(i, j).s) * u[i][j], u[i][j]);
        phi[i].add_product(l(i, j), x[j]);
      }
    }
  }
  template <class Source>
  HWY_INLINE void differentiate(const Source& in, const Values& u, Matrix& jacobian) const {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        jacobian[i][j] = l(i, j);
        jacobian[i][j].add_product(twice_s(in, i, j) * in.coefficient(square(i, j).a), u[i][j]);
      }
    }
  }
  // sum_j |dPhi_i/dq_j| |q_j| + |constant|, over unknowns and inputs.
  template <class Source>
  HWY_INLINE void scale(const Source& in, const Column& x, const Values& u, Column& out) const {
    for (int i = 0; i < N; ++i) {
      out[i] = known_magnitude_[idx(i)];
      for (int j = 0; j < N; ++j) {
        L size = get(kMagnitude, square(i, j).b);
        size.add_product(abs(in.coefficient(square(i, j).a)), abs(x[j]));
        out[i].add_product(abs(twice_s(in, i, j) * u[i][j]), size);
        out[i].add_product(linear_magnitude_[idx(i * N + j)], abs(x[j]));
      }
    }
  }

  // -Phi_h h': -(g_i' + sum_j 2 s u_ij b_ij' + l_ij' x_j)
  template <class Source>
  HWY_INLINE void velocity_rhs(const Source& in, const Column& x, const Values& u, Column& rhs) const {
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) {
        rhs[i].subtract_product(twice_s(in, i, j) * u[i][j], get(kRate, square(i, j).b));
      }
    }
    for (const Separable::Known& t : e_.moving_known) {
      rhs[t.equation].subtract_product(in.coefficient(t.coefficient), get(kRate, t.reg));
    }
    for (const Separable::Linear& t : e_.moving_linear) {
      rhs[t.equation].subtract_product(in.coefficient(t.coefficient) * get(kRate, t.reg), x[t.unknown]);
    }
  }
  // -(Phi_h h'' + Phi'_q q')
  template <class Source>
  HWY_INLINE void acceleration_rhs(const Source& in, const Column& x, const Values& u, const Column& rate,
                                   Column& rhs) const {
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) {
        L u_rate = get(kRate, square(i, j).b);
        u_rate.add_product(in.coefficient(square(i, j).a), rate[j]);
        L half = u_rate * u_rate;
        half.add_product(u[i][j], get(kAcceleration, square(i, j).b));
        rhs[i].subtract_product(twice_s(in, i, j), half);
      }
    }
    for (const Separable::Known& t : e_.moving_known) {
      rhs[t.equation].subtract_product(in.coefficient(t.coefficient), get(kAcceleration, t.reg));
    }
    for (const Separable::Linear& t : e_.moving_linear) {
      L terms = get(kAcceleration, t.reg) * x[t.unknown];
      terms.add_product(get(kRate, t.reg), rate[t.unknown] + rate[t.unknown]);
      rhs[t.equation].subtract_product(in.coefficient(t.coefficient), terms);
    }
  }

  // After set_inputs().
  HWY_INLINE L input(std::int32_t i) const { return get(kValue, N + i); }

 private:
  HWY_INLINE L get(Part part, std::int32_t reg) const { return registers_[idx(reg * kParts + part)]; }
  HWY_INLINE void set(Part part, std::int32_t reg, const L& v) { registers_.set(idx(reg * kParts + part), v); }
  HWY_INLINE L l(int i, int j) const { return linear_[idx(i * N + j)]; }
  HWY_INLINE const Separable::Square& square(int i, int j) const { return e_.squares[idx(i * N + j)]; }
  template <class Source>
  HWY_INLINE L twice_s(const Source& in, int i, int j) const {
    const L s = in.coefficient(square(i, j).s);
    return s + s;
  }
  template <class Numbers>
  static HWY_INLINE void add(const L& term, Numbers& to, std::size_t i) {
    to.set(i, to[i] + term);
  }
  // Sum of the magnitudes of the terms of a register; of a coordinate, its magnitude.
  HWY_INLINE L magnitude(std::int32_t reg) const {
    return reg > class_.one() ? get(kMagnitude, reg) : abs(get(kValue, reg));
  }

  template <bool kMeasure, class Source>
  HWY_INLINE void set_known(const Source& in) {
    for (std::size_t i = 0; i < N; ++i) {
      known_.set(i, L::set(0));
      if (kMeasure) known_magnitude_.set(i, L::set(0));
    }
    for (const Separable::Known& t : e_.known) {
      const L factor = in.coefficient(t.coefficient);
      add(factor * get(kValue, t.reg), known_, idx(t.equation));
      if (kMeasure) add(abs(factor) * magnitude(t.reg), known_magnitude_, idx(t.equation));
    }
  }
  template <bool kMeasure, class Source>
  HWY_INLINE void set_linear(const Source& in) {
    const auto slot = [](const Separable::Linear& t) { return idx(t.equation * N + t.unknown); };
    for (const Separable::Linear& t : e_.linear) {
      linear_.set(slot(t), L::set(0));
      if (kMeasure) linear_magnitude_.set(slot(t), L::set(0));
    }
    for (const Separable::Linear& t : e_.linear) {
      const L factor = in.coefficient(t.coefficient) * in.coefficient(t.slope), value = get(kValue, t.reg);
      add(factor * value, linear_, slot(t));
      if (!kMeasure) continue;
      // For a factor that is not constant, its own magnitude is added.
      L size = abs(value);
      if (t.reg != class_.one()) size = size + magnitude(t.reg);
      add(abs(factor) * size, linear_magnitude_, slot(t));
    }
  }

  // Derivatives of the moving inputs; those of the others stay zero.
  template <Part kPart, class Source>
  HWY_INLINE void derive(const Source& in, int derivative) {
    for (const std::int32_t i : moving_) set(kPart, N + i, in.input(derivative, i));
    for (const GroupClass::Form& f : class_.forms) {
      if (f.moving == f.unknowns) continue;
      L total = L::set(0);
      for (std::int32_t o = f.moving; o < f.unknowns; ++o) {
        const GroupClass::Operand& operand = class_.operands[idx(o)];
        total.add_product(in.coefficient(operand.coefficient), get(kPart, operand.reg));
      }
      set(kPart, f.reg, total);
    }
  }

  const GroupClass& class_;
  Separable e_;
  std::vector<std::int32_t> moving_;                             // inputs
  Array registers_;                                              // registers x parts
  typename L::template Fixed<N> known_, known_magnitude_;        // g, and the sizes of its terms
  typename L::template Fixed<N * N> linear_, linear_magnitude_;  // l, and the sizes of its terms
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
