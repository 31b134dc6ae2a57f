// Coefficients of the separable equations of a small group, which depend on its inputs. Included once for each target,
// inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_SMALL_COEFFICIENTS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_SMALL_COEFFICIENTS_INL
#undef ASSUR_SMALL_COEFFICIENTS_INL
#else
#define ASSUR_SMALL_COEFFICIENTS_INL
#endif

#include "equations/gather-inl.hpp"
#include "group/small_algebra-inl.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "assur/structure.hpp"
#include "equations/lane_array.hpp"
#include "equations/program.hpp"
#include "equations/separable.hpp"
#include "group/pack.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// The numbers of a Separable at one time, from the inputs of a pack. Registers as in Program, and a last one of zeros.
template <int W, int N>
class Coefficients : public SmallAlgebra<W, N> {
  using L = Lanes<W>;
  enum Part { kValue, kMagnitude, kRate, kAcceleration, kParts };

 public:
  Coefficients(const GroupClass& group_class, const Program& program, Separable separable)
      : p_(program),
        e_(std::move(separable)),
        registers_(static_cast<std::size_t>((program.registers + 1) * kParts * W)) {
    for (std::int32_t i = 0; i < p_.inputs; ++i) {
      if (group_class.input_moves[static_cast<std::size_t>(i)] != 0) moving_.push_back(i);
    }
    L::set(1).store(at(kValue, p_.one()));
    for (const Program::Operand& o : p_.operands) addends_.push_back({o.coefficient * W, o.reg * kParts * W});
    // Missing numbers have a slot, too, so that their uses need no test.
    const auto or_else = [](std::int32_t& slot, std::int32_t other) {
      if (slot == Separable::kNone) slot = other;
    };
    for (Separable::Square& q : e_.squares) {
      or_else(q.s, zero_coefficient(p_));
      or_else(q.a, one_coefficient(p_));
      or_else(q.b, p_.registers);
    }
    for (std::vector<Separable::Linear>* list : {&e_.linear, &e_.moving_linear}) {
      for (Separable::Linear& t : *list) or_else(t.slope, one_coefficient(p_));
    }
    for (double* zeros : {linear_, linear_magnitude_}) std::fill_n(zeros, N * N * W, 0.0);
  }

  // kMeasure: also the magnitudes, for scales of equations.
  template <bool kMeasure = true>
  HWY_INLINE void set_inputs(const Pack& pack, const double* state) {
    turn_to(pack);
    for (std::int32_t i = 0; i < p_.inputs; ++i) {
      input(pack.input_rows.data(), pack.inputs.data(), i, state).store(at(kValue, N + i));
    }
    for (const Program::Form& f : p_.forms) {
      L total = L::set(0), magnitude = L::set(0);
      const Addend* const end = addends_.data() + f.unknowns;
      for (const Addend* a = addends_.data() + f.begin; a != end; ++a) {
        const L term = L::load(k_ + a->coefficient) * L::load(registers_.data() + a->value);
        total = total + term;
        if (kMeasure) magnitude = magnitude + abs(term);
      }
      total.store(at(kValue, f.reg));
      if (kMeasure) magnitude.store(at(kMagnitude, f.reg));
    }
    set_known<kMeasure>();
    if (!e_.linear.empty()) set_linear<kMeasure>();
  }
  HWY_INLINE void set_rates(const InputRow* rows, const std::int32_t* addresses, const double* state) {
    derive<kRate>(rows, addresses, state);
  }
  HWY_INLINE void set_accelerations(const InputRow* rows, const std::int32_t* addresses, const double* state) {
    derive<kAcceleration>(rows, addresses, state);
  }
  // The next calls are about this pack. set_inputs() includes it.
  HWY_INLINE void turn_to(const Pack& pack) { k_ = pack.coefficients.data(); }
  // A coefficient of the program in all lanes.
  HWY_INLINE L coefficient(std::int32_t i) const { return k(i); }

  [[nodiscard]] bool may_vanish() const { return !e_.linear.empty(); }
  HWY_INLINE L s(int i, int j) const { return k(square(i, j).s); }
  HWY_INLINE L a(int i, int j) const { return k(square(i, j).a); }
  HWY_INLINE L b(int i, int j) const { return get(kValue, square(i, j).b); }
  HWY_INLINE L b_magnitude(int i, int j) const { return get(kMagnitude, square(i, j).b); }
  HWY_INLINE L b_rate(int i, int j) const { return get(kRate, square(i, j).b); }
  HWY_INLINE L b_acceleration(int i, int j) const { return get(kAcceleration, square(i, j).b); }
  HWY_INLINE L l(int i, int j) const { return L::load(linear_ + (i * N + j) * W); }
  HWY_INLINE L l_magnitude(int i, int j) const { return L::load(linear_magnitude_ + (i * N + j) * W); }
  HWY_INLINE L g(int i) const { return L::load(known_ + i * W); }
  HWY_INLINE L g_magnitude(int i) const { return L::load(known_magnitude_ + i * W); }

  // rhs_i -= g_i' + sum_j l_ij' x_j
  HWY_INLINE void subtract_rates(const L (&x)[N], L (&rhs)[N]) {
    if (e_.moving_known.empty() && e_.moving_linear.empty()) return;
    double sum[N * W] = {}, unknowns[N * W];
    for (int j = 0; j < N; ++j) x[j].store(unknowns + j * W);
    for (const Separable::Known& t : e_.moving_known) add(k(t.coefficient) * get(kRate, t.reg), sum + t.equation * W);
    for (const Separable::Linear& t : e_.moving_linear) {
      add(k(t.coefficient) * get(kRate, t.reg) * L::load(unknowns + t.unknown * W), sum + t.equation * W);
    }
    for (int i = 0; i < N; ++i) rhs[i] = rhs[i] - L::load(sum + i * W);
  }
  // rhs_i -= g_i'' + sum_j l_ij'' x_j + 2 l_ij' x_j'
  HWY_INLINE void subtract_accelerations(const L (&x)[N], const L (&rate)[N], L (&rhs)[N]) {
    if (e_.moving_known.empty() && e_.moving_linear.empty()) return;
    double sum[N * W] = {}, unknowns[N * W], twice_rates[N * W];
    for (int j = 0; j < N; ++j) {
      x[j].store(unknowns + j * W);
      (rate[j] + rate[j]).store(twice_rates + j * W);
    }
    for (const Separable::Known& t : e_.moving_known) {
      add(k(t.coefficient) * get(kAcceleration, t.reg), sum + t.equation * W);
    }
    for (const Separable::Linear& t : e_.moving_linear) {
      L terms = get(kAcceleration, t.reg) * L::load(unknowns + t.unknown * W);
      terms.add_product(get(kRate, t.reg), L::load(twice_rates + t.unknown * W));
      add(k(t.coefficient) * terms, sum + t.equation * W);
    }
    for (int i = 0; i < N; ++i) rhs[i] = rhs[i] - L::load(sum + i * W);
  }

  // omega * largest |coordinate - anchor|: see PackKernels.
  HWY_INLINE L ball_use(const Pack& pack, std::span<const std::int32_t> coordinates, const L (&x)[N]) {
    for (int j = 0; j < N; ++j) x[j].store(at(kValue, j));
    return this->part_of_ball(pack, coordinates, [&](std::int32_t c) { return get(kValue, c); });
  }

 private:
  // Where an operand of a form finds its factors.
  struct Addend {
    std::ptrdiff_t coefficient, value;
  };

  HWY_INLINE double* at(Part part, std::int32_t reg) { return registers_.data() + (reg * kParts + part) * W; }
  HWY_INLINE L get(Part part, std::int32_t reg) const { return L::load(registers_.data() + (reg * kParts + part) * W); }
  HWY_INLINE L k(std::int32_t i) const { return L::load(k_ + i * W); }
  static HWY_INLINE void add(const L& term, double* to) { (L::load(to) + term).store(to); }
  HWY_INLINE const Separable::Square& square(int i, int j) const {
    return e_.squares[static_cast<std::size_t>(i * N + j)];
  }
  static HWY_INLINE L input(const InputRow* rows, const std::int32_t* addresses, std::int32_t i, const double* state) {
    return gather_input<W>(rows[i], addresses + i * W, state);
  }
  // Sum of the magnitudes of the terms of a register; of a coordinate, its magnitude.
  HWY_INLINE L magnitude(std::int32_t reg) const {
    return reg > p_.one() ? get(kMagnitude, reg) : abs(get(kValue, reg));
  }

  template <bool kMeasure>
  HWY_INLINE void set_known() {
    for (int i = 0; i < N; ++i) {
      L::set(0).store(known_ + i * W);
      if (kMeasure) L::set(0).store(known_magnitude_ + i * W);
    }
    for (const Separable::Known& t : e_.known) {
      add(k(t.coefficient) * get(kValue, t.reg), known_ + t.equation * W);
      if (kMeasure) add(abs(k(t.coefficient)) * magnitude(t.reg), known_magnitude_ + t.equation * W);
    }
  }
  template <bool kMeasure>
  void set_linear() {
    for (const Separable::Linear& t : e_.linear) {
      const int slot = t.equation * N + t.unknown;
      L::set(0).store(linear_ + slot * W);
      if (kMeasure) L::set(0).store(linear_magnitude_ + slot * W);
    }
    for (const Separable::Linear& t : e_.linear) {
      const int slot = t.equation * N + t.unknown;
      const L factor = k(t.coefficient) * k(t.slope), value = get(kValue, t.reg);
      add(factor * value, linear_ + slot * W);
      if (!kMeasure) continue;
      // For a factor that is not constant, its own magnitude is added.
      L size = abs(value);
      if (t.reg != p_.one()) size = size + magnitude(t.reg);
      add(abs(factor) * size, linear_magnitude_ + slot * W);
    }
  }

  // Derivatives of the moving inputs; those of the others stay zero.
  template <Part kPart>
  HWY_INLINE void derive(const InputRow* rows, const std::int32_t* addresses, const double* state) {
    for (const std::int32_t i : moving_) input(rows, addresses, i, state).store(at(kPart, N + i));
    for (const Program::Form& f : p_.forms) {
      if (f.moving == f.unknowns) continue;
      L total = L::set(0);
      const Addend* const end = addends_.data() + f.unknowns;
      for (const Addend* a = addends_.data() + f.moving; a != end; ++a) {
        total.add_product(L::load(k_ + a->coefficient), L::load(registers_.data() + a->value + kPart * W));
      }
      total.store(at(kPart, f.reg));
    }
  }

  const Program& p_;
  Separable e_;
  std::vector<std::int32_t> moving_;  // inputs
  std::vector<Addend> addends_;       // operands of forms
  LaneArray registers_;               // registers x parts x W
  const double* k_ = nullptr;         // coefficients of the current pack
  alignas(kLineBytes) double known_[N * W];
  alignas(kLineBytes) double known_magnitude_[N * W];
  alignas(kLineBytes) double linear_[N * N * W];
  alignas(kLineBytes) double linear_magnitude_[N * N * W];
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
