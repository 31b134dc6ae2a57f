#include "groups/jacobian_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "backends/refined.hpp"
#include "backends/residual.hpp"
#include "program/step_rules.hpp"

namespace assur {

JacobianSolver::JacobianSolver(const Workspace& work, const Plan::Choice& choice, std::span<const Backend> table)
    : work_(work),
      settings_(choice.solver),
      backend_(find_backend(table, settings_.backend)),
      own_solvers_(backend_.keeps_pivots || settings_.reuse == Reuse::run) {
  const std::string why_not = backend_.why_not(choice.shape, ThreadBudget{settings_.threads});
  if (!why_not.empty()) throw Error(Error::Kind::environment, "backend " + settings_.backend + ": " + why_not);
  jacobian_norm_.resize(idx(work_.lanes));
  for (LaneArray* v : {&residual_, &row_scale_, &column_size_}) v->resize(work_.size());
  sort_by_rows();
}

void JacobianSolver::sort_by_rows() {
  const Pattern& p = work_.group_class.pattern;
  row_start_.assign(idx(p.n) + 1, 0);
  for (const std::int32_t r : p.row) ++row_start_[idx(r) + 1];
  for (std::size_t r = 0; r < idx(p.n); ++r) row_start_[r + 1] += row_start_[r];
  row_entries_.resize(p.row.size());
  std::vector<std::int32_t> next(row_start_.begin(), row_start_.end() - 1);
  for (std::int32_t c = 0; c < p.n; ++c) {
    for (std::int32_t k = p.column_start[idx(c)]; k < p.column_start[idx(c) + 1]; ++k) {
      row_entries_[idx(next[idx(p.row[idx(k)])]++)] = {k, c};
    }
  }
}

std::unique_ptr<LinearSolver> JacobianSolver::make() const {
  auto solver = make_solver(backend_, ThreadBudget{settings_.threads},
                            settings_.single ? Precision::binary32 : Precision::binary64, settings_.refine);
  if (!solver->analyze(work_.group_class.pattern, work_.lanes).ok()) {
    throw Error(Error::Kind::environment, "backend " + settings_.backend + " cannot analyse the pattern of a group");
  }
  return solver;
}

void JacobianSolver::restart(bool alike) {
  first_ = nullptr;
  alike_ = alike;
  refined_ = 0;
  if (!own_solvers_) shared_ = make();
}

void JacobianSolver::choose(Pack& pack) {
  solver_ = shared_.get();
  if (!own_solvers_) return;
  if (!pack.solver || pack.restarts) {
    const LinearSolver* const like = pack.pivots ? pack.pivots.get() : alike_ ? first_ : nullptr;
    if (like != nullptr) pack.solver = like->clone();
    if (!pack.solver || (like == nullptr && !pack.solver->restart())) pack.solver = make();
    pack.restarts = false;
    if (first_ == nullptr) first_ = pack.solver.get();
  }
  solver_ = pack.solver.get();
}

Effort JacobianSolver::effort() const {
  Effort sum = shared_ ? shared_->effort() : Effort{};
  sum.refined += refined_;
  sum.unplanned += refined_;
  return sum;
}

Status JacobianSolver::factorize(Pack& pack, Factors from, Counters& counters) {
  if (factors_ == Factors::program) {
    lanes::count_factorizations(*solver_, -1);
  } else {
    counters.factorizations += pack.used;
    counters.factorized_unknowns += std::int64_t{pack.used} * work_.group_class.n;
  }
  const Status s = solver_->factorize(work_.jacobian);
  pack.factored = s.ok();
  factors_ = s.ok() ? from : Factors::earlier;
  return s.ok() ? s : pack.failed(s);
}

bool JacobianSolver::factorize(Pack& pack) {
  pack.factored = solver_->factorize(work_.jacobian).ok();
  return pack.factored;
}

// Adds corrections to x until its residual is small enough, or no longer halves. residual: normwise residual of x,
// whose vector is residual_. rounds: more than kMostRefinements if that many corrections were not enough.
[[gnu::always_inline]] inline Status JacobianSolver::refine(const Pack& pack, const LaneArray& b, double* x,
                                                            const Goal& goal, Counters& counters, double& residual,
                                                            int& rounds) {
  const auto measured = [&] { return goal.scaled ? std::max(residual, scaled_residual(x, b)) : residual; };
  double left = measured();
  for (rounds = 0; left > goal.enough;) {
    if (++rounds > kMostRefinements) return {};
    if (const Status s = solver_->solve(residual_, 1); !s.ok()) return pack.failed(s);
    counters.solved_unknowns += std::int64_t{pack.used} * work_.group_class.n;
    for (std::size_t i = 0; i < b.size(); ++i) x[i] += residual_[i];
    residual = residual_of(x, b);
    const double before = std::exchange(left, measured());
    if (!(left < before / 2) && left <= goal.tolerated) return {};
  }
  return {};
}

// Refines if pivot growth spoiled the factors of J itself.
[[gnu::always_inline]] inline Status JacobianSolver::refine_grown(const Pack& pack, const LaneArray& b, double* x,
                                                                  Counters& counters, double& residual) {
  if (!(residual > kPivotsGrew)) return {};
  int rounds = 0;
  const Status s = refine(pack, b, x, {kPivotsGrew, kInfinity, false}, counters, residual, rounds);
  refined_ += std::int64_t{pack.used} * std::min(rounds, kMostRefinements);
  return s;
}

Status JacobianSolver::correction(Pack& pack, const LaneArray& b, double* x, bool checked, Counters& counters) {
  std::copy(b.begin(), b.end(), x);
  if (const Status s = solver_->solve({x, b.size()}, 1); !s.ok()) return pack.failed(s);
  counters.solved_unknowns += std::int64_t{pack.used} * work_.group_class.n;
  if (!checked) return {};
  double residual = residual_of(x, b);
  return refine_grown(pack, b, x, counters, residual);
}

Status JacobianSolver::solve(Pack& pack, const LaneArray& b, double* x, int first_wanted, double converged,
                             Counters& counters, double& error) {
  const bool own_factors = factors_ == Factors::solution;
  std::copy(b.begin(), b.end(), x);
  // Refinement with factors of another posture needs the whole solution.
  const int first = own_factors ? first_wanted : 0;
  if (const Status s = solver_->solve({x, b.size()}, 1, Transpose::no, first); !s.ok()) return pack.failed(s);
  counters.solved_unknowns += std::int64_t{pack.used} * (work_.group_class.n - first);
  if (first > 0) {  // the other unknowns are unspecified; set to zero
    std::fill_n(x, idx(first * work_.lanes), 0.0);
    return {};
  }
  double residual = residual_of(x, b);
  if (own_factors) {
    if (const Status s = refine_grown(pack, b, x, counters, residual); !s.ok()) return s;
  } else {
    const double enough = std::max(kLinear, converged);
    int rounds = 0;
    if (const Status s = refine(pack, b, x, {enough, 4 * enough, true}, counters, residual, rounds); !s.ok()) return s;
    if (rounds > kMostRefinements) {
      // The posture is too far from the posture of the factorisation: factorise here.
      if (const Status s = factorize(pack, Factors::solution, counters); !s.ok()) return s;
      return solve(pack, b, x, first_wanted, converged, counters, error);
    }
  }
  if (!std::isfinite(residual)) return pack.failed(Code::not_finite, residual, work_.lane_with_most(pack, residual_));
  error = std::max(error, residual);
  return {};
}

// residual_ = b - J x; returns |residual| / (|J| |x| + |b|), maximum norms, of the worst lane.
double JacobianSolver::residual_of(const double* x, const LaneArray& b) {
  const bool measure = !std::exchange(jacobian_measured_, true);
  return work_.kernels.residual(row_start_.data(), row_entries_.data(), work_.group_class.n, work_.jacobian.data(), x,
                                b.data(), residual_.data(), jacobian_norm_.data(), measure);
}

// The residual of the worst lane after scaling of rows and columns to size 1: large rows and columns hide errors of the
// others in the maximum norms. residual_ must be that of x.
double JacobianSolver::scaled_residual(const double* x, const LaneArray& b) {
  if (!std::exchange(scales_measured_, true)) {
    equilibrate({work_.group_class.pattern, work_.jacobian, work_.lanes, Transpose::no}, row_scale_, column_size_);
    for (double& c : column_size_) c = 1 / c;
  }
  std::array<double, kMostLanes> left{}, right{}, size{};
  const std::size_t w = idx(work_.lanes);
  norms(residual_, row_scale_, std::span(left).first(w));
  norms(b, row_scale_, std::span(right).first(w));
  norms({x, b.size()}, column_size_, std::span(size).first(w));
  double worst = 0;
  for (std::size_t l = 0; l < w; ++l) {
    if (!(left[l] <= 0)) worst = std::max(worst, left[l] / (size[l] + right[l]));
  }
  return worst;
}

}  // namespace assur
