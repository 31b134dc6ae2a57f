// The equations of a small group whose unknowns are the coordinates of one point at known distances from other points:
//   Phi_i = g_i + sum_j u_ij^2,   u_ij = b_ij + sign x_j
// It has fewer kinds of terms than SeparableEquations: by kernels, a step of four_bar:100 takes a fifth less time.
// Included once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_DISTANCE_EQUATIONS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_DISTANCE_EQUATIONS_INL
#undef ASSUR_DISTANCE_EQUATIONS_INL
#else
#define ASSUR_DISTANCE_EQUATIONS_INL
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

// For a Separable that measures_distances(). L, Source: see SmallGroup.
template <class L, int N>
class DistanceEquations {
 public:
  using Column = L[N];
  using Matrix = L[N][N];
  using Values = Matrix;  // u
  using Array = typename L::Array;
  static constexpr bool kDistances = true;

  DistanceEquations(const GroupClass& group_class, const Separable& separable)
      : inputs_(group_class.inputs),
        sign_(separable.squares[0].a == Separable::kNone
                  ? 1
                  : group_class.coefficients[idx(separable.squares[0].a)].literal),
        numbers_{Array(idx(group_class.inputs) + 1), Array(idx(group_class.inputs) + 1),
                 Array(idx(group_class.inputs) + 1)} {
    const auto moves = [&](std::int32_t input) { return group_class.input_moves[idx(input)] != 0; };
    for (std::int32_t i = 0; i < inputs_; ++i) {
      if (moves(i)) moving_.push_back(i);
    }
    numbers_[0].set(idx(inputs_), L::set(1));
    for (int ij = 0; ij < N * N; ++ij) {
      Sum& sum = sums_[ij];
      const std::int32_t reg = separable.squares[idx(ij)].b;
      sum.begin = sum.moving = static_cast<std::int32_t>(addends_.size());
      const auto add = [&](std::int32_t coefficient, std::int32_t of) { addends_.push_back({coefficient, of - N}); };
      if (reg > group_class.one()) {
        const GroupClass::Form& f = group_class.forms[idx(reg - group_class.one() - 1)];
        for (std::int32_t o = f.begin; o < f.unknowns; ++o) {
          add(group_class.operands[idx(o)].coefficient, group_class.operands[idx(o)].reg);
        }
        sum.moving += f.moving - f.begin;
      } else if (reg != Separable::kNone) {
        add(one_coefficient(group_class), reg);
        sum.moving += reg < group_class.one() && moves(reg - N) ? 0 : 1;
      }
      sum.end = static_cast<std::int32_t>(addends_.size());
      const Addend none{zero_coefficient(group_class), inputs_};
      first_[ij] = sum.end > sum.begin ? addends_[idx(sum.begin)] : none;
      first_moving_[ij] = sum.end > sum.moving ? addends_[idx(sum.moving)] : none;
    }
    for (const Separable::Known& t : separable.known) known_[t.equation] = t.coefficient;
  }

  // kMeasure: also the magnitudes, for scale().
  template <bool kMeasure = true, class Source>
  HWY_INLINE void set_inputs(const Source& in) {
    for (std::int32_t i = 0; i < inputs_; ++i) numbers_[0].set(idx(i), in.input(0, i));
    for (int ij = 0; ij < N * N; ++ij) {
      L total = addend(in, first_[ij], 0), magnitude = abs(total);
      for (std::int32_t o = sums_[ij].begin + 1; o < sums_[ij].end; ++o) {
        const L term = addend(in, addends_[idx(o)], 0);
        total = total + term;
        if (kMeasure) magnitude = magnitude + abs(term);
      }
      b_[0].set(idx(ij), total);
      if (kMeasure) magnitude_.set(idx(ij), magnitude);
    }
  }
  template <class Source>
  HWY_INLINE void set_rates(const Source& in) {
    derive(in, 1);
  }
  template <class Source>
  HWY_INLINE void set_accelerations(const Source& in) {
    derive(in, 2);
  }
  [[nodiscard]] static constexpr bool has_gears() { return false; }
  [[nodiscard]] static constexpr bool may_vanish() { return false; }

  template <class Source>
  HWY_INLINE void evaluate(const Source& in, const Column& x, Values& u, Column& phi) const {
    const L sign = L::set(sign_);
    for (int i = 0; i < N; ++i) {
      phi[i] = in.coefficient(known_[i]);
      for (int j = 0; j < N; ++j) {
        u[i][j] = b(0, i, j);
        u[i][j].add_product(sign, x[j]);
        phi[i].add_product(u[i][j], u[i][j]);
      }
    }
  }
  template <class Source>
  HWY_INLINE void differentiate(const Source&, const Values& u, Matrix& jacobian) const {
    const L twice = L::set(2 * sign_);
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) jacobian[i][j] = twice * u[i][j];
    }
  }
  template <class Source>
  HWY_INLINE void scale(const Source& in, const Column& x, const Values& u, Column& out) const {
    for (int i = 0; i < N; ++i) {
      L total = abs(u[i][0]) * (magnitude_[idx(i * N)] + abs(x[0]));
      for (int j = 1; j < N; ++j) total.add_product(abs(u[i][j]), magnitude_[idx(i * N + j)] + abs(x[j]));
      out[i] = total + total + abs(in.coefficient(known_[i]));
    }
  }
  template <class Source>
  HWY_INLINE void velocity_rhs(const Source&, const Column&, const Values& u, Column& rhs) const {
    for (int i = 0; i < N; ++i) {
      L half = L::set(0);
      for (int j = 0; j < N; ++j) half.subtract_product(u[i][j], b(1, i, j));
      rhs[i] = half + half;
    }
  }
  template <class Source>
  HWY_INLINE void acceleration_rhs(const Source&, const Column&, const Values& u, const Column& rate,
                                   Column& rhs) const {
    const L sign = L::set(sign_);
    for (int i = 0; i < N; ++i) {
      L half = L::set(0);
      for (int j = 0; j < N; ++j) {
        L u_rate = b(1, i, j);
        u_rate.add_product(sign, rate[j]);
        half.subtract_product(u_rate, u_rate);
        half.subtract_product(u[i][j], b(2, i, j));
      }
      rhs[i] = half + half;
    }
  }

  // After set_inputs().
  HWY_INLINE L input(std::int32_t i) const { return numbers_[0][idx(i)]; }

 private:
  // b_ij as a sum of addends: [begin, moving) at rest, [moving, end) moving
  struct Sum {
    std::int32_t begin, moving, end;
  };
  // coefficient * input; the last input is 1. Most sums have one addend.
  struct Addend {
    std::int32_t coefficient, input;
  };
  template <class Source>
  HWY_INLINE L addend(const Source& in, const Addend& a, int derivative) const {
    return in.coefficient(a.coefficient) * numbers_[derivative][idx(a.input)];
  }
  HWY_INLINE L b(int derivative, int i, int j) const { return b_[derivative][idx(i * N + j)]; }
  template <class Source>
  HWY_INLINE void derive(const Source& in, int derivative) {
    for (const std::int32_t i : moving_) numbers_[derivative].set(idx(i), in.input(derivative, i));
    for (int ij = 0; ij < N * N; ++ij) {
      L total = addend(in, first_moving_[ij], derivative);
      for (std::int32_t o = sums_[ij].moving + 1; o < sums_[ij].end; ++o) {
        const Addend& next = addends_[idx(o)];
        total.add_product(in.coefficient(next.coefficient), numbers_[derivative][idx(next.input)]);
      }
      b_[derivative].set(idx(ij), total);
    }
  }

  std::int32_t inputs_;
  double sign_;
  std::vector<std::int32_t> moving_;  // inputs
  std::vector<Addend> addends_;       // of all b_ij
  Sum sums_[N * N];
  Addend first_[N * N], first_moving_[N * N];
  std::int32_t known_[N];  // coefficients g_i
  Array numbers_[3];       // [d]: d-th derivatives of the inputs, and of 1
  typename L::template Fixed<N * N> b_[3], magnitude_;
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
