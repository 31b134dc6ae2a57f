// Sparse LU by KLU: block triangular form, AMD ordering, rows scaled. One analysis for all lanes; each lane is
// factorised with pivoting once and then refactorised on the same pivots, which is several times faster and allocates
// nothing, for as long as those pivots stay good.
//
// What "good" means. The computed factors are exact for a matrix A + E with |E| <= n eps |L| |U| (Higham, Accuracy and
// Stability of Numerical Algorithms, theorem 9.3), so that, column by column, the error relative to max |A_j| is at
// most a factor of n^2 eps times
//     growth = max |L| * max_j (max |U_j| / max |A_j|).
// Growth of U alone would miss a small pivot whose column of L is large. It is measured after every factorisation:
//   - refactorised, and growth above the lane's limit: factorise with pivoting again;
//   - pivoted with the relaxed tolerance, and growth above kGrowth: factorise with partial pivoting, and take twice the
//     growth of that as the lane's limit, since nothing better can be had.
// The tolerance decides more than speed: a chain of n / 2 pivots that are each a bit smaller than the entry below them
// multiplies their ratios. With KLU's own 0.001, and with 0.1 still, growth is 1e107 on the ring of 360 points.
#include <klu.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "backends/backends.hpp"

namespace assur::klu {
namespace {

constexpr double kRelaxed = 0.5;        // keep a pivot on the diagonal if no entry below is more than twice as large:
                                        // half the fill of partial pivoting on rings, the same on random matrices
constexpr double kPartial = 1;          // partial pivoting
constexpr double kGrowth = 64;          // backward errors measured up to a growth of 300: at most 5 n eps
constexpr std::size_t kRightSides = 4;  // KLU solves up to 4 at once

struct FreeSymbolic {
  klu_common* common;
  void operator()(klu_symbolic* symbolic) const { klu_free_symbolic(&symbolic, common); }
};
struct FreeNumeric {
  klu_common* common;
  void operator()(klu_numeric* numeric) const { klu_free_numeric(&numeric, common); }
};

// -1 for an odd permutation, else +1; `seen` is workspace.
int parity(const int* permutation, std::vector<bool>& seen) {
  int sign = 1;
  std::fill(seen.begin(), seen.end(), false);
  for (std::size_t start = 0; start < seen.size(); ++start) {
    for (std::size_t i = start; !seen[i]; i = static_cast<std::size_t>(permutation[i])) {
      seen[i] = true;
      if (static_cast<std::size_t>(permutation[i]) != start) sign = -sign;  // a cycle of k is k - 1 swaps
    }
  }
  return sign;
}

class KluSolver final : public LinearSolver {
 public:
  KluSolver();
  Status analyze(const Pattern& pattern, int lanes) override;
  Status factorize(std::span<const double> values) override;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override;
  Figures figures(int lane) const override;

 private:
  struct Lane {
    std::unique_ptr<klu_numeric, FreeNumeric> numeric;
    Code code = Code::singular;  // until factorised
    double limit = kGrowth;      // of growth, for a refactorisation
    double growth_of_u = 0;      // max_j max |U_j| / max |A_j|
    int permutation_sign = 0;    // of rows and columns together
  };

  Code factorize_lane(std::span<const double> values, int lane);
  bool refactorize(Lane& lane);
  Code factorize_with_pivoting(Lane& lane);
  double pivot(Lane& lane, double tolerance);
  double growth(Lane& lane);

  klu_common common_;
  std::unique_ptr<klu_symbolic, FreeSymbolic> symbolic_;
  std::size_t n_ = 0;
  std::vector<int> column_start_, row_;  // n + 1, nnz
  std::vector<double> values_;           // nnz, of one lane
  std::vector<double> right_;            // n x kRightSides, of one lane
  std::vector<bool> seen_;               // n
  std::vector<int> l_start_, l_row_;  // n + 1, nonzeros of L: where klu_extract puts the L whose values are asked for
  std::vector<double> l_values_;
  std::vector<Lane> lanes_;
  std::vector<Code> code_;  // lanes
};

KluSolver::KluSolver() { klu_defaults(&common_); }

Status KluSolver::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  lanes_.clear();  // before the analysis that they share
  symbolic_.reset();
  n_ = static_cast<std::size_t>(pattern.n);
  column_start_ = pattern.column_start;
  row_ = pattern.row;
  values_.resize(row_.size());
  right_.resize(n_ * kRightSides);
  seen_.resize(n_);
  l_start_.resize(n_ + 1);
  for (int lane = 0; lane < lanes; ++lane) {
    lanes_.emplace_back().numeric = {nullptr, FreeNumeric{&common_}};
  }
  code_.assign(lanes_.size(), Code::singular);
  if (row_.empty()) return {};  // KLU knows no empty matrix

  symbolic_ = {klu_analyze(pattern.n, column_start_.data(), row_.data(), &common_), FreeSymbolic{&common_}};
  if (!symbolic_ && common_.status != KLU_SINGULAR) throw std::bad_alloc();
  return {};
}

Status KluSolver::factorize(std::span<const double> values) {
  check_size("values", values.size(), row_.size() * lanes_.size());
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    lanes_[i].code = factorize_lane(values, static_cast<int>(i));
    code_[i] = lanes_[i].code;
  }
  return worst(code_);
}

Code KluSolver::factorize_lane(std::span<const double> values, int index) {
  if (!std::isfinite(take_lane(values, static_cast<int>(lanes_.size()), index, values_))) return Code::not_finite;
  if (n_ == 0) return Code::ok;
  if (!symbolic_ || symbolic_->structural_rank < symbolic_->n) return Code::singular;
  Lane& lane = lanes_[static_cast<std::size_t>(index)];
  return refactorize(lane) ? Code::ok : factorize_with_pivoting(lane);
}

// False if there are no pivots yet, or they have become bad for values_.
bool KluSolver::refactorize(Lane& lane) {
  if (!lane.numeric) return false;
  if (!klu_refactor(column_start_.data(), row_.data(), values_.data(), symbolic_.get(), lane.numeric.get(), &common_) ||
      common_.status != KLU_OK) {
    return false;
  }
  return growth(lane) <= lane.limit;  // false for NaN
}

Code KluSolver::factorize_with_pivoting(Lane& lane) {
  lane.limit = kGrowth;
  double reached = pivot(lane, kRelaxed);
  if (!(reached <= kGrowth)) {
    reached = pivot(lane, kPartial);
    lane.limit = std::max(kGrowth, 2 * reached);
  }
  if (!std::isfinite(reached)) {
    lane.numeric.reset();
    return Code::singular;
  }
  lane.permutation_sign = parity(lane.numeric->Pnum, seen_) * parity(symbolic_->Q, seen_);
  return Code::ok;
}

// Growth of a factorisation with new pivots; NaN if there is none.
double KluSolver::pivot(Lane& lane, double tolerance) {
  common_.tol = tolerance;
  lane.numeric.reset(klu_factor(column_start_.data(), row_.data(), values_.data(), symbolic_.get(), &common_));
  if (!lane.numeric) {
    if (common_.status != KLU_SINGULAR) throw std::bad_alloc();
    return std::numeric_limits<double>::quiet_NaN();
  }
  const auto nonzeros = static_cast<std::size_t>(lane.numeric->lnz);
  if (l_row_.size() < nonzeros) {
    l_row_.resize(nonzeros);
    l_values_.resize(nonzeros);
  }
  return growth(lane);
}

double KluSolver::growth(Lane& lane) {
  klu_numeric* numeric = lane.numeric.get();
  klu_rgrowth(column_start_.data(), row_.data(), values_.data(), symbolic_.get(), numeric, &common_);
  lane.growth_of_u = 1 / common_.rgrowth;
  klu_extract(numeric, symbolic_.get(), l_start_.data(), l_row_.data(), l_values_.data(), nullptr, nullptr, nullptr,
              nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr, &common_);
  double largest = 0, poison = 0;  // poison: 0 as long as every value is finite, else NaN
  for (std::size_t k = 0; k < static_cast<std::size_t>(numeric->lnz); ++k) {
    largest = std::max(largest, std::abs(l_values_[k]));
    poison += l_values_[k] * 0;
  }
  return (largest + poison) * lane.growth_of_u;
}

Status KluSolver::solve(std::span<double> b_to_x, int rhs, Transpose transpose, int) {
  const std::size_t w = lanes_.size(), columns = static_cast<std::size_t>(rhs);
  check_size("numbers on the right-hand side", b_to_x.size(), n_ * columns * w);
  if (n_ == 0) return worst(code_);
  const auto solve = [&](const Lane& lane, double* b, std::size_t count) {
    auto* function = transpose == Transpose::no ? klu_solve : klu_tsolve;
    function(symbolic_.get(), lane.numeric.get(), static_cast<int>(n_), static_cast<int>(count), b, &common_);
  };
  for (std::size_t l = 0; l < w; ++l) {
    if (lanes_[l].code != Code::ok) {
      fill_with_nan(b_to_x, static_cast<int>(w), static_cast<int>(l));
      continue;
    }
    if (w == 1) {
      solve(lanes_[l], b_to_x.data(), columns);
      continue;
    }
    for (std::size_t r = 0; r < columns; r += kRightSides) {
      const std::size_t count = std::min(kRightSides, columns - r);
      double* const given = b_to_x.data() + r * n_ * w + l;
      for (std::size_t i = 0; i < n_ * count; ++i) right_[i] = given[i * w];
      solve(lanes_[l], right_.data(), count);
      for (std::size_t i = 0; i < n_ * count; ++i) given[i * w] = right_[i];
    }
  }
  return worst(code_);
}

Figures KluSolver::figures(int index) const {
  const Lane& lane = lanes_[static_cast<std::size_t>(index)];
  if (lane.code != Code::ok) return {};
  if (n_ == 0) return {true, 1, 1, 1};
  // P R^-1 A Q = L U + blocks above: row scales are positive, L has a unit diagonal.
  const auto* diagonal = static_cast<const double*>(lane.numeric->Udiag);
  double smallest = std::abs(diagonal[0]), largest = 0;
  int sign = lane.permutation_sign;
  for (std::size_t i = 0; i < n_; ++i) {
    smallest = std::min(smallest, std::abs(diagonal[i]));
    largest = std::max(largest, std::abs(diagonal[i]));
    if (diagonal[i] < 0) sign = -sign;
  }
  return {true, lane.growth_of_u, smallest / largest, sign};
}

}  // namespace

std::string why_not(const Shape&, ThreadBudget) { return ""; }

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision) { return std::make_unique<KluSolver>(); }

std::string version() {
  return std::to_string(KLU_MAIN_VERSION) + "." + std::to_string(KLU_SUB_VERSION) + "." +
         std::to_string(KLU_SUBSUB_VERSION);
}

}  // namespace assur::klu
