// Compiled once for each SIMD target; the one that serves is chosen when a step is made.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simulation/small_step.cpp"
#include <hwy/foreach_target.h>  // before what is compiled once for each target

#include "simulation/small_step.hpp"

#include "equations/program_run-inl.hpp"
#include "simulation/gather-inl.hpp"
#include "simulation/small_lu-inl.hpp"

#include <cmath>
#include <vector>

#include "simulation/tolerances.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W, int N>
class SmallStepOf final : public SmallStep {
  using L = Lanes<W>;
  using Column = L[N];
  using Matrix = L[N][N];

 public:
  SmallStepOf(const GroupClass& group_class, const Program& program, const BlockConditions& blocks)
      : p_(program), derivatives_(group_class.derivatives), reads_(blocks.reads(0)), run_(program) {
    for (std::int32_t i = 0; i < p_.inputs; ++i) {
      if (group_class.input_moves[static_cast<std::size_t>(i)] != 0) moving_.push_back(i);
    }
    for (std::int32_t c = 0; c < N; ++c) {
      for (auto k = program.pattern.column_start[static_cast<std::size_t>(c)];
           k < program.pattern.column_start[static_cast<std::size_t>(c) + 1]; ++k) {
        entries_[program.pattern.row[static_cast<std::size_t>(k)]][c] = program.entries[static_cast<std::size_t>(k)];
      }
    }
  }

  bool run(const Pack& pack, double* const (&state)[3], int most_iterations, SmallStepFigures& figures) override {
    run_.set_coefficients(pack.coefficients.data());
    gather_inputs(pack, state[0]);
    run_.forms_of_inputs();
    Column x;
    load(state[0] + pack.unknowns, x);
    if (!newton(pack, x, most_iterations, figures)) return false;
    if (derivatives_ > 0) {
      Matrix jacobian;
      differentiate(jacobian);
      if (!lu_.factorize(jacobian)) return false;
      const L norm = norm_of(jacobian);
      Column rhs, rate;
      gather_rates(pack, state[1]);
      run_.forms_of_input_rates();
      for (int i = 0; i < N; ++i) rhs[i] = run_.velocity_rhs(equation(i));
      lu_.solve(rhs, rate);
      store(rate, state[1] + pack.unknowns);
      figures.velocity = residual(jacobian, norm, rate, rhs);
      if (derivatives_ > 1) {
        store(rate, run_.rates());
        run_.forms_of_rates();
        gather_accelerations(pack, state[2]);
        run_.forms_of_input_accelerations();
        Column acceleration;
        for (int i = 0; i < N; ++i) rhs[i] = run_.acceleration_rhs(equation(i));
        lu_.solve(rhs, acceleration);
        store(acceleration, state[2] + pack.unknowns);
        figures.acceleration = residual(jacobian, norm, acceleration, rhs);
      }
      if (!std::isfinite(figures.velocity + figures.acceleration)) return false;
    }
    figures.ball_used = ball_use(pack);
    store(x, state[0] + pack.unknowns);
    return true;
  }

 private:
  HWY_INLINE bool newton(const Pack& pack, Column& x, int most_iterations, SmallStepFigures& figures) {
    Column phi, inverse_scale;
    evaluate(x, phi);
    run_.forms_of_magnitudes();
    const L one = L::set(1);
    for (int i = 0; i < N; ++i) {
      const L scale = run_.scale(equation(i));
      inverse_scale[i] = one / if_positive(scale, scale, one);
    }
    double relative = largest_ratio(phi, inverse_scale), before = 0;
    int iteration = 0;
    for (; !(relative <= kConverged); ++iteration) {
      if (!std::isfinite(relative) || iteration == most_iterations) return false;
      if (iteration > 0 && only_rounding_is_left(relative, before)) break;
      Matrix jacobian;
      differentiate(jacobian);
      if (!lu_.factorize(jacobian)) return false;
      Column correction;
      lu_.solve(phi, correction);
      L largest = L::set(0), poison = L::set(0);
      for (int i = 0; i < N; ++i) {
        x[i] = x[i] - correction[i];
        largest = max(largest, abs(correction[i]));
        poison.add_product(correction[i], L::set(0));
      }
      if (iteration == 0 && !is_near(pack, largest + poison)) return false;
      before = relative;
      evaluate(x, phi);
      relative = largest_ratio(phi, inverse_scale);
    }
    figures.iterations = iteration;
    figures.position = relative;
    return true;
  }

  // omega |first correction| <= kKantorovich, in what is left of the ball; 0 <= everything.
  HWY_INLINE bool is_near(const Pack& pack, const L& largest) const {
    const L used = if_positive(largest, largest * L::load(pack.omega.data()), largest);
    return used.largest() <= kKantorovich * (1 - pack.ball_used[0]);
  }

  HWY_INLINE void evaluate(const Column& x, Column& phi) {
    store(x, run_.values());
    run_.forms_of_unknowns();
    for (int i = 0; i < N; ++i) phi[i] = run_.residual(equation(i));
  }
  HWY_INLINE void differentiate(Matrix& jacobian) const {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) jacobian[i][j] = run_.entry(entries_[i][j]);
    }
  }

  static HWY_INLINE double largest_ratio(const Column& phi, const Column& inverse_scale) {
    L largest = L::set(0), poison = L::set(0);
    for (int i = 0; i < N; ++i) {
      const L ratio = phi[i] * inverse_scale[i];
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

  // |b - J x| / (|J| |x| + |b|), maximum norms, of the worst lane.
  static HWY_INLINE double residual(const Matrix& jacobian, const L& norm, const Column& x, const Column& b) {
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
    return (norm_r / if_positive(norm_b, norm_b, L::set(1)) + poison).largest();
  }

  // Largest over the lanes of omega * largest |coordinate - anchor|: see LaneKernels.
  HWY_INLINE double ball_use(const Pack& pack) const {
    L moved = L::set(0), poison = L::set(0);
    const double* anchor = pack.anchor.data();
    for (const std::int32_t c : reads_) {
      const L by = L::load(run_.values() + c * W) - L::load(anchor);
      moved = max(moved, abs(by));
      poison.add_product(by, L::set(0));
      anchor += W;
    }
    return (if_positive(moved, moved * L::load(pack.omega.data()), moved) + poison).largest();
  }

  HWY_INLINE L input(const Pack& pack, std::int32_t i, const double* state) const {
    return gather_input<W>(pack.input_rows[static_cast<std::size_t>(i)], pack.inputs.data() + i * W, state);
  }
  HWY_INLINE void gather_inputs(const Pack& pack, const double* state) {
    for (std::int32_t i = 0; i < p_.inputs; ++i) input(pack, i, state).store(run_.values() + (N + i) * W);
  }
  HWY_INLINE void gather_rates(const Pack& pack, const double* state) {
    for (const std::int32_t i : moving_) {
      const L rate = input(pack, i, state);
      rate.store(run_.input_rates() + (N + i) * W);
      rate.store(run_.rates() + (N + i) * W);
    }
  }
  HWY_INLINE void gather_accelerations(const Pack& pack, const double* state) {
    for (const std::int32_t i : moving_) input(pack, i, state).store(run_.input_accelerations() + (N + i) * W);
  }

  HWY_INLINE const Program::Equation& equation(int i) const { return p_.equations[static_cast<std::size_t>(i)]; }
  static HWY_INLINE void load(const double* from, Column& to) {
    for (int i = 0; i < N; ++i) to[i] = L::load(from + i * W);
  }
  static HWY_INLINE void store(const Column& from, double* to) {
    for (int i = 0; i < N; ++i) from[i].store(to + i * W);
  }

  const Program& p_;
  int derivatives_;
  std::span<const std::int32_t> reads_;  // coordinates that the branch check looks at
  std::vector<std::int32_t> moving_;     // inputs with a rate; those of the others stay zero
  Program::Range entries_[N][N] = {};    // of the Jacobian
  ProgramRun<W> run_;
  SmallLu<W, N> lu_;
};

template <int W>
SmallStep* of_size(const GroupClass& group_class, const Program& program, const BlockConditions& blocks) {
  switch (program.n) {
    case 1:
      return new SmallStepOf<W, 1>(group_class, program, blocks);
    case 2:
      return new SmallStepOf<W, 2>(group_class, program, blocks);
    case 3:
      return new SmallStepOf<W, 3>(group_class, program, blocks);
    case 4:
      return new SmallStepOf<W, 4>(group_class, program, blocks);
    default:
      return nullptr;
  }
}

SmallStep* make(const GroupClass& group_class, const Program& program, const BlockConditions& blocks, int lanes) {
  switch (lanes) {
    case 1:
      return of_size<1>(group_class, program, blocks);
    case 2:
      return of_size<2>(group_class, program, blocks);
    case 4:
      return of_size<4>(group_class, program, blocks);
    case 8:
      return of_size<8>(group_class, program, blocks);
    case 16:
      return of_size<16>(group_class, program, blocks);
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
  if (!group_class.quadratic || !program.callbacks.empty() || program.blocks != 1) return nullptr;
  if (group_class.first_wanted != 0) return nullptr;  // it would compute more than is wanted
  return std::unique_ptr<SmallStep>(HWY_DYNAMIC_DISPATCH(make)(group_class, program, blocks, lanes));
}

}  // namespace assur
#endif
