#include "dispatch/prior.hpp"

#include <algorithm>
#include <cmath>

#include "backends/backends.hpp"
#include "backends/small_steps.hpp"

namespace assur {
namespace {

// Constants are in ns. Each function names the command that measured its constants: `--kernel K` stands for `assur db
// samples --kernel K` after `assur tune --budget 30`, on one core of an AMD EPYC (Zen 5, AVX-512).

// Wider lanes cost more, but less than in proportion. more: relative cost of each lane beyond the first.
double width(const Strategy& s, double more) { return 1 + more * (s.solver.lanes - 1); }

// Threads inside one factorisation gain little if unknowns are few: `team_bench`.
double threads_at_work(const Shape& shape, const Strategy& s) {
  return s.solver.threads == 1 ? 1 : 1 + (s.solver.threads - 1) * std::min(1.0, shape.n / 600.0);
}

struct Counts {
  explicit Counts(const Shape& s)
      : n(s.n),
        nnz(s.nnz),
        fill(static_cast<double>(std::max<std::int64_t>(s.fill, s.nnz))),
        operations(std::max(static_cast<double>(s.operations), fill)) {}
  double n, nnz, fill, operations;
};

bool refines(const Strategy& s) { return s.solver.single || s.solver.refine; }

// The matrix is kept for residuals. Difference of float and double: `--kernel factor` of +float.
double keeping_seconds(const Shape& shape, const Strategy& s) {
  return refines(s) ? 1e-9 * (60 + 7.0 * shape.n + 2.0 * shape.nnz) * width(s, 0.75) : 0;
}
// Residuals, norms and tests of two corrections: `--kernel solve` of +float.
double correcting_seconds(const Shape& shape, const Strategy& s) {
  return refines(s) ? 1e-9 * (60 + 25.0 * shape.n + 1.5 * shape.nnz) * width(s, 0.37) : 0;
}

// An estimate, not measured: launches and copies begin after tens of microseconds, columns are eliminated one after
// another in a microsecond each, copies move 10 GB/s, and products run at 1 TFLOP/s. `auto` needs samples beside it.
double device_seconds(double start, double columns, double work) { return 1e-9 * (start + columns + work); }

// `--kernel factor`, and `solvers_bench --benchmark_filter='/factor$'`.
double plain_factor_seconds(const Shape& shape, const Strategy& s) {
  const auto [n, nnz, fill, operations] = Counts(shape);
  const Backend& backend = properties_of(s.solver.backend);
  if (backend.device) return device_seconds(50'000, 1'000 * n, s.solver.lanes * (0.8 * n * n + 0.0007 * n * n * n));
  if (backend.fills_lanes) return 1e-9 * (3 + (1.2 * n + 0.6 * operations) * width(s, 0.075));
  if (backend.dense) {
    const double elimination =
        backend.threads ? 30 + 40 * n + 1.8 * n * n + 0.015 * n * n * n : 5 + 6 * n + n * n + 0.04 * n * n * n;
    const double meetings = 2000.0 * (s.solver.threads - 1);
    return 1e-9 * s.solver.lanes * (elimination * (s.solver.single ? 0.8 : 1) / threads_at_work(shape, s) + meetings);
  }
  if (backend.keeps_pivots) return 1e-9 * s.solver.lanes * (20 + 3 * n + fill + 0.7 * operations);
  return 1e-9 * s.solver.lanes * (20'000 + 600 * n + 0.7 * operations);  // these compute a new order each time
}

double factor_seconds(const Shape& shape, const Strategy& s) {
  return plain_factor_seconds(shape, s) + keeping_seconds(shape, s);
}

// `--kernel solve`, and `solvers_bench --benchmark_filter='/solve$'`.
double plain_solve_seconds(const Shape& shape, const Strategy& s) {
  const auto [n, nnz, fill, operations] = Counts(shape);
  const Backend& backend = properties_of(s.solver.backend);
  if (backend.device) return device_seconds(40'000, 500 * n, s.solver.lanes * 0.01 * n * n);
  if (backend.fills_lanes) return 1e-9 * (5 + (0.9 * n + 0.9 * fill) * width(s, 0.07));
  if (backend.dense) {
    return 1e-9 * s.solver.lanes * (backend.threads ? 25 + 14 * n + 0.2 * n * n : 10 + 8 * n + 0.2 * n * n);
  }
  if (backend.keeps_pivots) return 1e-9 * s.solver.lanes * (10 + 3.3 * n + 1.5 * fill);
  return 1e-9 * s.solver.lanes * (35'000 + 180 * n + 5 * fill);
}

double solve_seconds(const Shape& shape, const Strategy& s) {
  return (refines(s) ? 3 : 1) * plain_solve_seconds(shape, s) + correcting_seconds(shape, s);
}

// Gathering of inputs, norms and the branch check; factors of another posture also need residuals. `--kernel pack`
// minus `--kernel evaluate`, `factor` and `solve` of the same shape.
double rest_seconds(const Shape& shape, const Strategy& s) {
  return 1e-9 * (120 + (6.0 * shape.n + (s.solver.once ? 7 : 3.3) * shape.nnz) * width(s, 0.2));
}

// `--kernel evaluate`.
double evaluate_seconds(const Shape& shape, const Strategy& s) {
  const auto terms = static_cast<double>(std::max<std::int64_t>(shape.terms, std::int64_t{2} * shape.nnz));
  return 1e-9 * (5 + 0.8 * terms * width(s, 0.13));
}

// `--kernel pack` by `lanes` at n = 2 and 3.
double in_registers_seconds(const Shape& shape, const Strategy& s) {
  return 1e-9 * (17 + 4.6 * shape.n * shape.n * shape.n) * width(s, 0.08);
}

// `--kernel pack` by +together. The packs share the beginnings of the passes.
double together_seconds(const Shape& shape, const Strategy& s) {
  const double packs = std::ceil(static_cast<double>(shape.groups) / s.solver.lanes);
  return 1e-9 * ((30 + 11.0 * shape.n * shape.n) * width(s, 0.2) + 70 / std::max(packs, 1.0));
}

double pack_seconds(const Shape& shape, const Strategy& s) {
  if (s.run.together) return together_seconds(shape, s);
  if (path_of(shape, s) == StepPath::in_registers) return in_registers_seconds(shape, s);
  const StepCounts counts = step_counts(s, shape.rhs - 1);
  return rest_seconds(shape, s) + counts.evaluations * evaluate_seconds(shape, s) +
         counts.factorizations * factor_seconds(shape, s) + counts.solutions * solve_seconds(shape, s);
}

}  // namespace

double prior_seconds(Kernel kernel, const Shape& shape, const Strategy& strategy) {
  switch (kernel) {
    case Kernel::evaluate:
      return evaluate_seconds(shape, strategy);
    case Kernel::factor:
      return factor_seconds(shape, strategy);
    case Kernel::solve:
      return solve_seconds(shape, strategy);
    case Kernel::pack:
      return pack_seconds(shape, strategy);
    case Kernel::meeting:
      return kAloneBeforeMeeting + prior_meeting_seconds(strategy.run.threads) + kPriorHandover * shape.n;
    case Kernel::step:
      return prior_around_seconds(std::int64_t{shape.n} * shape.groups) +
             std::ceil(static_cast<double>(shape.groups) / strategy.solver.lanes) * pack_seconds(shape, strategy);
    case Kernel::around:
      return prior_around_seconds(shape.n, shape.terms);
  }
  return 0;
}

// `--kernel around`.
double prior_around_seconds(std::int64_t unknowns, std::int64_t pieces) {
  return 1e-9 * (300 + 2 * static_cast<double>(unknowns) + 0.6 * static_cast<double>(pieces));
}

// `--kernel meeting`, minus 5 us of the clock.
double prior_meeting_seconds(std::int32_t p) { return p < 2 ? 0 : 1e-9 * (700 + 50.0 * p); }

StepCounts step_counts(const Strategy& s, int derivatives) {
  // Factors from the prediction also serve the derivatives, with one refinement each.
  const bool borrowed = s.solver.once && derivatives > 0;
  StepCounts counts{2, 1, 1.0 + derivatives};
  if (borrowed) counts.solutions += derivatives;
  if (!borrowed && derivatives > 0) counts.factorizations += 1;
  if (s.solver.separate && derivatives > 1) counts.factorizations += 1;
  if (s.solver.reuse == Reuse::run) counts.factorizations -= 1;
  return counts;
}

StepPath path_of(const Shape& shape, const Strategy& s) {
  if (!shape.one_program || !has_small_steps(s.solver)) return StepPath::composed;
  const bool small = shape.n == 2 || shape.n == 3;
  if (small) return s.solver.lanes <= 8 || s.run.together ? StepPath::in_registers : StepPath::composed;
  return s.run.together ? StepPath::composed : StepPath::one_program;
}

bool is_dense(const Strategy& s) { return properties_of(s.solver.backend).dense; }

}  // namespace assur
