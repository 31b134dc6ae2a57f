// The equations of a small group whose unknowns are the coordinates of one point at known distances from other points:
//   Phi_i = g_i + sum_j u_ij^2,   u_ij = b_ij + sign x_j
// It has fewer kinds of terms than SmallSystem: a step of four_bar:100 takes a fifth less time, level after level.
// Included once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_DISTANCE_SYSTEM_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_DISTANCE_SYSTEM_INL
#undef ASSUR_DISTANCE_SYSTEM_INL
#else
#define ASSUR_DISTANCE_SYSTEM_INL
#endif

#include "equations/gather-inl.hpp"
#include "group/small_algebra-inl.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/structure.hpp"
#include "equations/lane_array.hpp"
#include "equations/program.hpp"
#include "equations/separable.hpp"
#include "group/pack.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// Has the functions of SmallSystem. For a Separable that measures_distances().
template <int W, int N>
class DistanceSystem : public SmallAlgebra<W, N> {
  using L = Lanes<W>;
  enum Part { kValue, kRate, kAcceleration, kParts };

 public:
  using typename SmallAlgebra<W, N>::Column;
  using typename SmallAlgebra<W, N>::Matrix;
  static constexpr bool kDistances = true;

  DistanceSystem(const GroupClass& group_class, const Program& program, const Separable& separable)
      : inputs_(program.inputs),
        sign_(separable.squares[0].a == Separable::kNone
                  ? 1
                  : program.coefficients[static_cast<std::size_t>(separable.squares[0].a)].literal),
        registers_(static_cast<std::size_t>((program.one() + 1) * kParts * W)) {
    for (std::int32_t i = 0; i < inputs_; ++i) {
      if (group_class.input_moves[static_cast<std::size_t>(i)] != 0) moving_.push_back(i);
    }
    L::set(1).store(at(kValue, program.one()));
    for (int ij = 0; ij < N * N; ++ij) {
      Sum& sum = sums_[ij];
      const std::int32_t reg = separable.squares[static_cast<std::size_t>(ij)].b;
      sum.begin = sum.moving = static_cast<std::int32_t>(addends_.size());
      if (reg > program.one()) {
        const Program::Form& f = program.forms[static_cast<std::size_t>(reg - program.one() - 1)];
        addends_.insert(addends_.end(), program.operands.begin() + f.begin, program.operands.begin() + f.unknowns);
        sum.moving += f.moving - f.begin;
      } else if (reg != Separable::kNone) {
        const bool moves = reg < program.one() && group_class.input_moves[static_cast<std::size_t>(reg - N)] != 0;
        addends_.push_back({one_coefficient(program), reg});
        sum.moving += moves ? 0 : 1;
      }
      sum.end = static_cast<std::int32_t>(addends_.size());
      const bool any = sum.end > sum.begin, any_moving = sum.end > sum.moving;
      const Program::Operand none{zero_coefficient(program), program.one()};
      first_[ij] = of(any ? addends_[static_cast<std::size_t>(sum.begin)] : none);
      first_moving_[ij] = of(any_moving ? addends_[static_cast<std::size_t>(sum.moving)] : none);
    }
    for (const Program::Operand& o : addends_) terms_.push_back(of(o));
    for (const Separable::Known& t : separable.known) known_[t.equation] = t.coefficient;
    for (double* zeros : {b_, b_magnitude_, b_rate_, b_acceleration_}) std::fill_n(zeros, N * N * W, 0.0);
  }

  // kMeasure: also the magnitudes, for scale_of().
  template <bool kMeasure = true>
  HWY_INLINE void set_inputs(const Pack& pack, const double* state) {
    turn_to(pack);
    for (std::int32_t i = 0; i < inputs_; ++i) read(kValue, i, pack.input_rows.data(), pack.inputs.data(), state);
    for (int ij = 0; ij < N * N; ++ij) {
      L total = addend(first_[ij], kValue), magnitude = abs(total);
      for (std::int32_t o = sums_[ij].begin + 1; o < sums_[ij].end; ++o) {
        const L term = addend(of(addends_[static_cast<std::size_t>(o)]), kValue);
        total = total + term;
        if (kMeasure) magnitude = magnitude + abs(term);
      }
      total.store(b_ + ij * W);
      if (kMeasure) magnitude.store(b_magnitude_ + ij * W);
    }
  }
  // The part of b_ij from inputs at rest, and its magnitude: 2 x N x N x W, for set_moving_inputs().
  static constexpr std::size_t kAtRest = 2 * N * N * W;
  void at_rest(const Pack& pack, const double* state, double* to) {
    turn_to(pack);
    for (std::int32_t i = 0; i < inputs_; ++i) read(kValue, i, pack.input_rows.data(), pack.inputs.data(), state);
    for (int ij = 0; ij < N * N; ++ij, to += W) {
      L total = L::set(0), magnitude = L::set(0);
      for (std::int32_t o = sums_[ij].begin; o < sums_[ij].moving; ++o) {
        const L term = addend(of(addends_[static_cast<std::size_t>(o)]), kValue);
        total = total + term;
        magnitude = magnitude + abs(term);
      }
      total.store(to);
      magnitude.store(to + N * N * W);
    }
  }
  // set_inputs(), if at_rest() is known.
  template <bool kMeasure>
  HWY_INLINE void set_moving_inputs(const Pack& pack, const double* at_rest, const double* state) {
    turn_to(pack);
    for (const std::int32_t i : moving_) read(kValue, i, pack.input_rows.data(), pack.inputs.data(), state);
    for (int ij = 0; ij < N * N; ++ij, at_rest += W) {
      L total = L::load(at_rest), magnitude = L::load(at_rest + N * N * W);
      for (std::int32_t o = sums_[ij].moving; o < sums_[ij].end; ++o) {
        const L term = addend(terms_[static_cast<std::size_t>(o)], kValue);
        total = total + term;
        if (kMeasure) magnitude = magnitude + abs(term);
      }
      total.store(b_ + ij * W);
      if (kMeasure) magnitude.store(b_magnitude_ + ij * W);
    }
  }
  HWY_INLINE void set_rates(const InputRow* rows, const std::int32_t* addresses, const double* state) {
    derive(kRate, rows, addresses, state, b_rate_);
  }
  HWY_INLINE void set_accelerations(const InputRow* rows, const std::int32_t* addresses, const double* state) {
    derive(kAcceleration, rows, addresses, state, b_acceleration_);
  }
  HWY_INLINE void turn_to(const Pack& pack) { k_ = pack.coefficients.data(); }
  HWY_INLINE L coefficient(std::int32_t i) const { return L::load(k_ + i * W); }
  [[nodiscard]] static constexpr bool may_vanish() { return false; }

  HWY_INLINE void evaluate(const Column& x, Matrix& u, Column& phi) const {
    const L sign = L::set(sign_);
    for (int i = 0; i < N; ++i) {
      phi[i] = coefficient(known_[i]);
      for (int j = 0; j < N; ++j) {
        u[i][j] = b(b_, i, j);
        u[i][j].add_product(sign, x[j]);
        phi[i].add_product(u[i][j], u[i][j]);
      }
    }
  }
  HWY_INLINE void differentiate(const Matrix& u, Matrix& jacobian) const {
    const L twice = L::set(2 * sign_);
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) jacobian[i][j] = twice * u[i][j];
    }
  }
  HWY_INLINE L scale_of(int i, const Column& x, const Matrix& u) const {
    L total = L::set(0);
    for (int j = 0; j < N; ++j) total.add_product(abs(u[i][j]), b(b_magnitude_, i, j) + abs(x[j]));
    return total + total + abs(coefficient(known_[i]));
  }
  HWY_INLINE void velocity_rhs(const Column&, const Matrix& u, Column& rhs) const {
    for (int i = 0; i < N; ++i) {
      L half = L::set(0);
      for (int j = 0; j < N; ++j) half.subtract_product(u[i][j], b(b_rate_, i, j));
      rhs[i] = half + half;
    }
  }
  HWY_INLINE void acceleration_rhs(const Column&, const Matrix& u, const Column& rate, Column& rhs) const {
    const L sign = L::set(sign_);
    for (int i = 0; i < N; ++i) {
      L half = L::set(0);
      for (int j = 0; j < N; ++j) {
        L u_rate = b(b_rate_, i, j);
        u_rate.add_product(sign, rate[j]);
        half.subtract_product(u_rate, u_rate);
        half.subtract_product(u[i][j], b(b_acceleration_, i, j));
      }
      rhs[i] = half + half;
    }
  }

  // omega * largest |coordinate - anchor|: see PackKernels.
  HWY_INLINE L ball_use(const Pack& pack, std::span<const std::int32_t> coordinates, const Column& x) {
    for (int j = 0; j < N; ++j) x[j].store(at(kValue, j));
    return this->part_of_ball(pack, coordinates, [&](std::int32_t c) { return get(kValue, c); });
  }

 private:
  // b_ij as a sum of addends: [begin, moving) at rest, [moving, end) moving
  struct Sum {
    std::int32_t begin, moving, end;
  };
  // Where an addend, coefficient * register, finds its factors. Most sums have one addend.
  struct Addend {
    std::ptrdiff_t coefficient, value;
  };
  static Addend of(const Program::Operand& o) { return {o.coefficient * W, o.reg * kParts * W}; }
  HWY_INLINE L addend(const Addend& a, Part part) const {
    return L::load(k_ + a.coefficient) * L::load(registers_.data() + a.value + part * W);
  }

  HWY_INLINE double* at(Part part, std::int32_t reg) { return registers_.data() + (reg * kParts + part) * W; }
  HWY_INLINE L get(Part part, std::int32_t reg) const { return L::load(registers_.data() + (reg * kParts + part) * W); }
  static HWY_INLINE L b(const double* from, int i, int j) { return L::load(from + (i * N + j) * W); }
  HWY_INLINE void read(Part part, std::int32_t i, const InputRow* rows, const std::int32_t* addresses,
                       const double* state) {
    gather_input<W>(rows[i], addresses + i * W, state).store(at(part, N + i));
  }
  HWY_INLINE void derive(Part part, const InputRow* rows, const std::int32_t* addresses, const double* state,
                         double* of_b) {
    for (const std::int32_t i : moving_) read(part, i, rows, addresses, state);
    for (int ij = 0; ij < N * N; ++ij) {
      L total = addend(first_moving_[ij], part);
      for (std::int32_t o = sums_[ij].moving + 1; o < sums_[ij].end; ++o) {
        total = total + addend(of(addends_[static_cast<std::size_t>(o)]), part);
      }
      total.store(of_b + ij * W);
    }
  }

  std::int32_t inputs_;
  double sign_;
  std::vector<std::int32_t> moving_;       // inputs
  std::vector<Program::Operand> addends_;  // of all b_ij
  std::vector<Addend> terms_;              // addends_
  Sum sums_[N * N];
  Addend first_[N * N], first_moving_[N * N];
  std::int32_t known_[N];      // coefficients g_i
  LaneArray registers_;        // (unknowns, inputs, 1) x parts x W
  const double* k_ = nullptr;  // coefficients of the current pack
  alignas(kLineBytes) double b_[N * N * W];
  alignas(kLineBytes) double b_magnitude_[N * N * W];
  alignas(kLineBytes) double b_rate_[N * N * W];
  alignas(kLineBytes) double b_acceleration_[N * N * W];
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
