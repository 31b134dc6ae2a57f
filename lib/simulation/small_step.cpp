// Compiled once for each SIMD target; the one that serves is chosen when a step is made.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simulation/small_step.cpp"
#include <hwy/foreach_target.h>  // before what is compiled once for each target

#include "simulation/small_step.hpp"

#include "equations/lane_vector-inl.hpp"
#include "simulation/gather-inl.hpp"
#include "simulation/small_lu-inl.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "equations/separable.hpp"
#include "simulation/tolerances.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

// The numbers of a Separable at one time, from the inputs of a pack. Registers as in Program, and a last one of zeros.
template <int W, int N>
class Coefficients {
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
    // What is not there is a slot, too, so that nothing has to be asked for each use.
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

  HWY_INLINE void set_inputs(const Pack& pack, const double* state) {
    k_ = pack.coefficients.data();
    for (std::int32_t i = 0; i < p_.inputs; ++i) input(pack, i, state).store(at(kValue, N + i));
    for (const Program::Form& f : p_.forms) {
      L total = L::set(0), magnitude = L::set(0);
      const Program::Operand* const end = p_.operands.data() + f.unknowns;
      for (const Program::Operand* o = p_.operands.data() + f.begin; o != end; ++o) {
        const L term = k(o->coefficient) * get(kValue, o->reg);
        total = total + term;
        magnitude = magnitude + abs(term);
      }
      total.store(at(kValue, f.reg));
      magnitude.store(at(kMagnitude, f.reg));
    }
    set_known();
    if (!e_.linear.empty()) set_linear();
  }
  HWY_INLINE void set_rates(const Pack& pack, const double* state) { derive<kRate>(pack, state); }
  HWY_INLINE void set_accelerations(const Pack& pack, const double* state) { derive<kAcceleration>(pack, state); }

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

  // Largest over the lanes of omega * largest |coordinate - anchor|: see LaneKernels.
  HWY_INLINE double ball_use(const Pack& pack, std::span<const std::int32_t> coordinates, const L (&x)[N]) {
    for (int j = 0; j < N; ++j) x[j].store(at(kValue, j));
    L moved = L::set(0), poison = L::set(0);
    const double* anchor = pack.anchor.data();
    for (const std::int32_t c : coordinates) {
      const L by = get(kValue, c) - L::load(anchor);
      moved = max(moved, abs(by));
      poison.add_product(by, L::set(0));
      anchor += W;
    }
    return (if_positive(moved, moved * L::load(pack.omega.data()), moved) + poison).largest();
  }

 private:
  HWY_INLINE double* at(Part part, std::int32_t reg) { return registers_.data() + (reg * kParts + part) * W; }
  HWY_INLINE L get(Part part, std::int32_t reg) const { return L::load(registers_.data() + (reg * kParts + part) * W); }
  HWY_INLINE L k(std::int32_t i) const { return L::load(k_ + i * W); }
  static HWY_INLINE void add(const L& term, double* to) { (L::load(to) + term).store(to); }
  HWY_INLINE const Separable::Square& square(int i, int j) const {
    return e_.squares[static_cast<std::size_t>(i * N + j)];
  }
  HWY_INLINE L input(const Pack& pack, std::int32_t i, const double* state) const {
    return gather_input<W>(pack.input_rows[static_cast<std::size_t>(i)], pack.inputs.data() + i * W, state);
  }
  // Of a coordinate it is its size.
  HWY_INLINE L magnitude(std::int32_t reg) const {
    return reg > p_.one() ? get(kMagnitude, reg) : abs(get(kValue, reg));
  }

  HWY_INLINE void set_known() {
    for (int i = 0; i < N; ++i) {
      L::set(0).store(known_ + i * W);
      L::set(0).store(known_magnitude_ + i * W);
    }
    for (const Separable::Known& t : e_.known) {
      add(k(t.coefficient) * get(kValue, t.reg), known_ + t.equation * W);
      add(abs(k(t.coefficient)) * magnitude(t.reg), known_magnitude_ + t.equation * W);
    }
  }
  void set_linear() {
    for (const Separable::Linear& t : e_.linear) {
      const int slot = t.equation * N + t.unknown;
      L::set(0).store(linear_ + slot * W);
      L::set(0).store(linear_magnitude_ + slot * W);
    }
    for (const Separable::Linear& t : e_.linear) {
      const int slot = t.equation * N + t.unknown;
      const L factor = k(t.coefficient) * k(t.slope), value = get(kValue, t.reg);
      add(factor * value, linear_ + slot * W);
      // A factor that is no number is a coordinate, too.
      L size = abs(value);
      if (t.reg != p_.one()) size = size + magnitude(t.reg);
      add(abs(factor) * size, linear_magnitude_ + slot * W);
    }
  }

  // Derivatives of what moves; those of everything else stay zero.
  template <Part kPart>
  HWY_INLINE void derive(const Pack& pack, const double* state) {
    for (const std::int32_t i : moving_) input(pack, i, state).store(at(kPart, N + i));
    for (const Program::Form& f : p_.forms) {
      if (f.moving == f.unknowns) continue;
      L total = L::set(0);
      const Program::Operand* const end = p_.operands.data() + f.unknowns;
      for (const Program::Operand* o = p_.operands.data() + f.moving; o != end; ++o) {
        total.add_product(k(o->coefficient), get(kPart, o->reg));
      }
      total.store(at(kPart, f.reg));
    }
  }

  const Program& p_;
  Separable e_;
  std::vector<std::int32_t> moving_;  // inputs
  std::vector<double> registers_;     // registers x parts x W
  const double* k_ = nullptr;         // coefficients of the pack at hand
  double known_[N * W], known_magnitude_[N * W], linear_[N * N * W], linear_magnitude_[N * N * W];
};

template <int W, int N>
class SmallStepOf final : public SmallStep {
  using L = Lanes<W>;
  using Column = L[N];
  using Matrix = L[N][N];

 public:
  SmallStepOf(const GroupClass& group_class, const Program& program, const BlockConditions& blocks, Separable separable)
      : derivatives_(group_class.derivatives),
        reads_(blocks.reads(0)),
        c_(group_class, program, std::move(separable)) {}

  void choose_pivots(Pack& pack, const double* state) override {
    Column x, phi;
    Matrix u, jacobian;
    load(state + pack.unknowns, x);
    c_.set_inputs(pack, state);
    evaluate(x, u, phi);
    differentiate(u, jacobian);
    pack.swaps.resize(SmallLu<W, N>::kSwaps * W);
    SmallLu<W, N>::choose_swaps(jacobian, pack.swaps.data());
  }

  bool run(const Pack& pack, double* const (&state)[3], int most_iterations, SmallStepFigures& figures) override {
    Column x;
    Matrix u;  // a_ij x_j + b_ij
    load(state[0] + pack.unknowns, x);
    c_.set_inputs(pack, state[0]);
    if (!newton(pack, x, u, most_iterations, figures)) return false;
    if (derivatives_ > 0 && !derivatives(pack, x, u, state, figures)) return false;
    figures.ball_used = c_.ball_use(pack, reads_, x);
    store(x, state[0] + pack.unknowns);
    return true;
  }

 private:
  HWY_INLINE bool newton(const Pack& pack, Column& x, Matrix& u, int most_iterations, SmallStepFigures& figures) {
    Column phi, scale;
    evaluate(x, u, phi);
    for (int i = 0; i < N; ++i) {
      scale[i] = scale_of(i, x, u);
      scale[i] = if_positive(scale[i], scale[i], L::set(1));
    }
    Column phi_before;
    for (int i = 0; i < N; ++i) phi_before[i] = L::set(0);
    int iteration = 0;
    for (; !at_most(phi, scale, kConverged); ++iteration) {
      if (iteration == most_iterations) return false;
      if (iteration > 0) {
        const double relative = largest_ratio(phi, scale);
        if (!std::isfinite(relative)) return false;
        if (only_rounding_is_left(relative, largest_ratio(phi_before, scale))) break;
      }
      for (int i = 0; i < N; ++i) phi_before[i] = phi[i];
      Matrix jacobian;
      differentiate(u, jacobian);
      if (!lu_.factorize(jacobian, pack.swaps.data())) return false;
      Column correction;
      lu_.solve(phi, correction);
      L largest = L::set(0), poison = L::set(0);
      for (int i = 0; i < N; ++i) {
        x[i] = x[i] - correction[i];
        largest = max(largest, abs(correction[i]));
        poison.add_product(correction[i], L::set(0));
      }
      if (iteration == 0 && !is_near(pack, largest + poison)) return false;
      evaluate(x, u, phi);
    }
    figures.iterations = iteration;
    if (!at_most(phi, scale, figures.position)) figures.position = largest_ratio(phi, scale);
    return true;
  }

  HWY_INLINE bool derivatives(const Pack& pack, const Column& x, const Matrix& u, double* const (&state)[3],
                              SmallStepFigures& figures) {
    Matrix jacobian;
    differentiate(u, jacobian);
    if (!lu_.factorize(jacobian, pack.swaps.data())) return false;
    const L norm = norm_of(jacobian);
    c_.set_rates(pack, state[1]);
    Column rhs, rate;
    for (int i = 0; i < N; ++i) {
      rhs[i] = L::set(0);
      for (int j = 0; j < N; ++j) rhs[i].subtract_product(twice_s(i, j) * u[i][j], c_.b_rate(i, j));
    }
    c_.subtract_rates(x, rhs);
    lu_.solve(rhs, rate);
    figures.velocity = residual(jacobian, norm, rate, rhs, figures.velocity);
    store(rate, state[1] + pack.unknowns);
    if (derivatives_ > 1) {
      c_.set_accelerations(pack, state[2]);
      for (int i = 0; i < N; ++i) {
        rhs[i] = L::set(0);
        for (int j = 0; j < N; ++j) {
          L u_rate = c_.b_rate(i, j);
          u_rate.add_product(c_.a(i, j), rate[j]);
          L half = u_rate * u_rate;
          half.add_product(u[i][j], c_.b_acceleration(i, j));
          rhs[i].subtract_product(twice_s(i, j), half);
        }
      }
      c_.subtract_accelerations(x, rate, rhs);
      Column acceleration;
      lu_.solve(rhs, acceleration);
      figures.acceleration = residual(jacobian, norm, acceleration, rhs, figures.acceleration);
      store(acceleration, state[2] + pack.unknowns);
    }
    return std::isfinite(figures.velocity + figures.acceleration);
  }

  HWY_INLINE L twice_s(int i, int j) const {
    const L s = c_.s(i, j);
    return s + s;
  }

  HWY_INLINE void evaluate(const Column& x, Matrix& u, Column& phi) const {
    for (int i = 0; i < N; ++i) {
      phi[i] = c_.g(i);
      for (int j = 0; j < N; ++j) {
        u[i][j] = c_.b(i, j);
        u[i][j].add_product(c_.a(i, j), x[j]);
        phi[i].add_product(c_.s(i, j) * u[i][j], u[i][j]);
        phi[i].add_product(c_.l(i, j), x[j]);
      }
    }
  }
  HWY_INLINE void differentiate(const Matrix& u, Matrix& jacobian) const {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        jacobian[i][j] = c_.l(i, j);
        jacobian[i][j].add_product(twice_s(i, j) * c_.a(i, j), u[i][j]);
      }
    }
  }
  // sum_j |dPhi_i/dq_j| |q_j| + |constant|, over inputs, too
  HWY_INLINE L scale_of(int i, const Column& x, const Matrix& u) const {
    L total = c_.g_magnitude(i);
    for (int j = 0; j < N; ++j) {
      L size = c_.b_magnitude(i, j);
      size.add_product(abs(c_.a(i, j)), abs(x[j]));
      total.add_product(abs(twice_s(i, j) * u[i][j]), size);
      total.add_product(c_.l_magnitude(i, j), abs(x[j]));
    }
    return total;
  }

  // omega |first correction| <= kKantorovich, in what is left of the ball; 0 is within any.
  static HWY_INLINE bool is_near(const Pack& pack, const L& largest) {
    const L used = if_positive(largest, largest * L::load(pack.omega.data()), largest);
    return used.largest() <= kKantorovich * (1 - pack.ball_used[0]);
  }

  // |phi| <= bound * scale everywhere: no division, and false for NaN.
  static HWY_INLINE bool at_most(const Column& phi, const Column& scale, double bound) {
    bool all = true;
    for (int i = 0; i < N; ++i) all = all_at_most(abs(phi[i]), L::set(bound) * scale[i]) && all;
    return all;
  }
  static HWY_INLINE double largest_ratio(const Column& phi, const Column& scale) {
    L largest = L::set(0), poison = L::set(0);
    for (int i = 0; i < N; ++i) {
      const L ratio = phi[i] / scale[i];
      largest = max(largest, abs(ratio));
      poison.add_product(ratio, L::set(0));
    }
    return (largest + poison).largest();
  }

  // Maximum norm.
  static HWY_INLINE L norm_of(const Matrix& matrix) {
    L largest = L::set(0);
    for (int i = 0; i < N; ++i) {
      L sum = abs(matrix[i][0]);
      for (int j = 1; j < N; ++j) sum = sum + abs(matrix[i][j]);
      largest = max(largest, sum);
    }
    return largest;
  }

  // The larger of `worst` and |b - J x| / (|J| |x| + |b|), maximum norms, in every lane.
  static HWY_INLINE double residual(const Matrix& jacobian, const L& norm, const Column& x, const Column& b,
                                    double worst) {
    L norm_r = L::set(0), norm_x = L::set(0), norm_b = L::set(0), poison = L::set(0);
    for (int i = 0; i < N; ++i) {
      L rest = b[i];
      for (int j = 0; j < N; ++j) rest.subtract_product(jacobian[i][j], x[j]);
      norm_r = max(norm_r, abs(rest));
      norm_x = max(norm_x, abs(x[i]));
      norm_b = max(norm_b, abs(b[i]));
      poison.add_product(rest, L::set(0));
    }
    norm_b.add_product(norm, norm_x);
    norm_r = norm_r + poison;
    norm_b = if_positive(norm_b, norm_b, L::set(1));
    if (HWY_LIKELY(all_at_most(norm_r, L::set(worst) * norm_b))) return worst;
    return (norm_r / norm_b).largest();
  }

  static HWY_INLINE void load(const double* from, Column& to) {
    for (int i = 0; i < N; ++i) to[i] = L::load(from + i * W);
  }
  static HWY_INLINE void store(const Column& from, double* to) {
    for (int i = 0; i < N; ++i) from[i].store(to + i * W);
  }

  int derivatives_;
  std::span<const std::int32_t> reads_;  // coordinates that the branch check looks at
  Coefficients<W, N> c_;
  SmallLu<W, N> lu_;
};

template <int W>
SmallStep* of_size(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                   Separable separable) {
  switch (program.n) {
    case 2:
      return new SmallStepOf<W, 2>(group_class, program, blocks, std::move(separable));
    case 3:
      return new SmallStepOf<W, 3>(group_class, program, blocks, std::move(separable));
    default:
      return nullptr;
  }
}

SmallStep* make(const GroupClass& group_class, const Program& program, const BlockConditions& blocks,
                Separable separable, int lanes) {
  switch (lanes) {
    case 1:
      return of_size<1>(group_class, program, blocks, std::move(separable));
    case 2:
      return of_size<2>(group_class, program, blocks, std::move(separable));
    case 4:
      return of_size<4>(group_class, program, blocks, std::move(separable));
    case 8:
      return of_size<8>(group_class, program, blocks, std::move(separable));
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

std::unique_ptr<SmallStep> make_small_step(const GroupClass& group_class, const Program& program,
                                           const BlockConditions& blocks, int lanes) {
  // With first_wanted it would compute more than is wanted.
  if (!group_class.quadratic || program.blocks != 1 || group_class.first_wanted != 0) return nullptr;
  auto separable = separate(program, group_class.input_moves);
  if (!separable) return nullptr;
  return std::unique_ptr<SmallStep>(
      HWY_DYNAMIC_DISPATCH(make)(group_class, program, blocks, std::move(*separable), lanes));
}

}  // namespace assur
#endif
