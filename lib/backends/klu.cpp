// Sparse LU by KLU: block triangular form, AMD ordering. One analysis for all lanes. Each lane is factorised with
// pivoting once, and then refactorised with the same pivots as long as these are good: that is several times faster and
// allocates nothing.
//
// Rows are scaled here, by powers of two that are kept as long as every row's largest entry is in [1/4, 2]. KLU would
// search for it and divide by it in every factorisation and solution, a fifth of their time at n = 15.
//
// Definition of good pivots: the computed factors are exact for a matrix A + E with |E| <= n eps |L| |U| (Higham,
// Accuracy and Stability of Numerical Algorithms, theorem 9.3), so that, column by column, the error relative to max
// |A_j| is at most a factor of n^2 eps times
//     growth = max |L| * max_j (max |U_j| / max |A_j|).
// Growth of U alone would miss a small pivot whose column of L is large. Growth is checked after every factorisation:
//   - growth above the lane's limit after a refactorisation: factorise with pivoting again;
//   - growth above kTrustedGrowth with the relaxed tolerance: factorise with partial pivoting, and take twice its
//     growth as the lane's limit, because no better factors are available.
// Measuring growth in full would cost a third of a refactorisation. Usually a cheap bound is enough: max |L| max |U|
// over the smallest column of A, where a column is at least as large as the entry that was its largest when growth was
// last measured.
//
// The tolerance also decides about accuracy: a chain of n / 2 pivots, each a bit smaller than the entry below it,
// multiplies their ratios. With KLU's own 0.001, and even with 0.1, growth is 1e107 on the ring of 360 points.
#include <klu.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "backends/backends.hpp"
#include "backends/lane_by_lane.hpp"
#include "numbers.hpp"

namespace assur::klu {
namespace {

constexpr double kRelaxed = 0.5;       // keep a pivot on the diagonal if no entry below is more than twice as large:
                                       // half the fill of partial pivoting on rings, the same on random matrices
constexpr double kPartial = 1;         // partial pivoting
constexpr double kTrustedGrowth = 64;  // backward errors measured up to a growth of 300: at most 5 n eps
// Largest entry of a row times its scale; at first it is in [1/2, 1).
constexpr double kSmallestRow = 0.25;
constexpr double kLargestRow = 2;  // beyond these, scales are computed anew

struct FreeSymbolic {
  klu_common* common;
  void operator()(klu_symbolic* symbolic) const { klu_free_symbolic(&symbolic, common); }
};
struct FreeNumeric {
  klu_common* common;
  void operator()(klu_numeric* numeric) const { klu_free_numeric(&numeric, common); }
};

// Magnitudes as integers, which compare fast: infinity and NaN are larger than any finite number.
constexpr auto kMagnitude = ~std::uint64_t{0} >> 1;
constexpr std::uint64_t magnitude(double number) { return std::bit_cast<std::uint64_t>(number) & kMagnitude; }

// max |number|; NaN and infinity are treated as larger than any number. Four at a time, for speed.
class Largest {
 public:
  explicit Largest(double at_least) { size_[0] = magnitude(at_least); }

  template <typename At>
  double of(std::size_t count, const At& at) {
    std::size_t k = 0;
    for (; k + 4 <= count; k += 4) {
      for (std::size_t i = 0; i < 4; ++i) size_[i] = std::max(size_[i], magnitude(at(k + i)));
    }
    for (; k < count; ++k) size_[0] = std::max(size_[0], magnitude(at(k)));
    return std::bit_cast<double>(std::max(std::max(size_[0], size_[1]), std::max(size_[2], size_[3])));
  }

 private:
  std::uint64_t size_[4] = {};
};

class KluSolver final : public LaneByLane {
 public:
  KluSolver();
  [[nodiscard]] Effort effort() const override { return {.renewed = renewed_}; }

 private:
  struct Lane {
    std::unique_ptr<klu_numeric, FreeNumeric> numeric;
    std::vector<double> scale, entry_scale;  // n rows; nnz: scale of the row of each entry
    std::vector<const double*> l, u;         // values of L and U without their diagonals; new pivots move them
    // n: the largest nonzero of each row when scales were chosen, and of each column when growth was measured
    std::vector<std::uint32_t> of_row, of_column;
    double limit = kTrustedGrowth;  // largest accepted growth of a refactorisation
    double largest_u = 0;           // of U; rows are scaled, so that the largest entry of A is in [1/4, 2]
    int permutation_sign = 0;       // of the row order times that of the column order
  };

  void analyze_lanes(const Pattern& pattern, int lanes) override;
  Code factorize_lane(std::span<const double> values, int lane) override;
  void solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int lane) override;
  [[nodiscard]] Figures lane_figures(int lane) const override;

  bool scale(std::span<const double> values, const Lane& lane);
  void choose_scales(std::span<const double> values, Lane& lane) const;
  bool refactorize(Lane& lane);
  Code factorize_with_pivoting(Lane& lane);
  double pivot(Lane& lane, double tolerance);
  void find_factors(Lane& lane) const;
  void find_largest_of_columns(Lane& lane) const;
  bool surely_good(Lane& lane) const;
  double growth(Lane& lane);

  klu_common common_;
  std::int64_t renewed_ = 0;
  std::unique_ptr<klu_symbolic, FreeSymbolic> symbolic_;
  std::size_t n_ = 0;
  std::vector<int> column_start_, row_;  // n + 1, nnz
  std::vector<double> scaled_;           // nnz: values of the current lane, rows scaled
  std::vector<Lane> lanes_;
};

KluSolver::KluSolver() {
  klu_defaults(&common_);
  common_.scale = -1;  // KLU then also skips its check of the pattern
}

void KluSolver::analyze_lanes(const Pattern& pattern, int lanes) {
  lanes_.clear();  // these refer to the analysis, so they go first
  renewed_ = 0;
  symbolic_.reset();
  n_ = static_cast<std::size_t>(pattern.n);
  column_start_ = pattern.column_start;
  row_ = pattern.row;
  scaled_.resize(row_.size());
  for (int lane = 0; lane < lanes; ++lane) {
    Lane& added = lanes_.emplace_back();
    added.numeric = {nullptr, FreeNumeric{&common_}};
    added.scale.resize(n_);
    added.entry_scale.resize(row_.size());
    added.of_row.resize(n_);
    added.of_column.resize(n_);
  }
  symbolic_ = {klu_analyze(pattern.n, column_start_.data(), row_.data(), &common_), FreeSymbolic{&common_}};
  if (!symbolic_ && common_.status != KLU_SINGULAR) throw std::bad_alloc();
}

Code KluSolver::factorize_lane(std::span<const double> values, int index) {
  if (!symbolic_ || symbolic_->structural_rank < symbolic_->n) return Code::singular;
  Lane& lane = lanes_[static_cast<std::size_t>(index)];
  if (!scale(values, lane)) {
    choose_scales(values, lane);
    (void)scale(values, lane);
  }
  return refactorize(lane) ? Code::ok : factorize_with_pivoting(lane);
}

// False if there are no scales yet, or they no longer fit.
bool KluSolver::scale(std::span<const double> values, const Lane& lane) {
  const double* __restrict const from = values.data();
  const double* __restrict const by = lane.entry_scale.data();
  double* __restrict const to = scaled_.data();
  std::uint64_t above = 0;  // its highest bit is set if some difference was negative
  for (std::size_t k = 0; k < values.size(); ++k) {
    to[k] = from[k] * by[k];
    above |= magnitude(kLargestRow) - magnitude(to[k]);
  }
  bool large = true;
  for (const std::uint32_t k : lane.of_row) large &= std::abs(to[k]) >= kSmallestRow;
  return large && above <= kMagnitude;
}

void KluSolver::choose_scales(std::span<const double> values, Lane& lane) const {
  std::fill(lane.scale.begin(), lane.scale.end(), -1.0);  // the largest of each row, until all are known
  for (std::size_t k = 0; k < row_.size(); ++k) {
    const auto row = static_cast<std::size_t>(row_[k]);
    if (!(std::abs(values[k]) > lane.scale[row])) continue;
    lane.scale[row] = std::abs(values[k]);
    lane.of_row[row] = static_cast<std::uint32_t>(k);
  }
  for (double& scale : lane.scale) {
    int exponent = 0;
    (void)std::frexp(scale, &exponent);
    scale = std::ldexp(1, -std::clamp(exponent, -1022, 1022));  // 1 for a row of zeros
  }
  for (std::size_t k = 0; k < row_.size(); ++k) lane.entry_scale[k] = lane.scale[static_cast<std::size_t>(row_[k])];
}

// False if there are no pivots yet, or if they are bad for these values.
bool KluSolver::refactorize(Lane& lane) {
  if (!lane.numeric) return false;
  if (!klu_refactor(column_start_.data(), row_.data(), scaled_.data(), symbolic_.get(), lane.numeric.get(), &common_) ||
      common_.status != KLU_OK) {
    return false;
  }
  return surely_good(lane) || growth(lane) <= lane.limit;  // false for NaN
}

Code KluSolver::factorize_with_pivoting(Lane& lane) {
  if (lane.numeric) ++renewed_;
  lane.limit = kTrustedGrowth;
  double reached = pivot(lane, kRelaxed);
  if (!(reached <= kTrustedGrowth)) {
    reached = pivot(lane, kPartial);
    lane.limit = std::max(kTrustedGrowth, 2 * reached);
  }
  if (!std::isfinite(reached)) {
    lane.numeric.reset();
    return Code::singular;
  }
  lane.permutation_sign = parity({lane.numeric->Pnum, n_}) * parity({symbolic_->Q, n_});
  return Code::ok;
}

// Growth of a factorisation with new pivots; NaN if there is none.
double KluSolver::pivot(Lane& lane, double tolerance) {
  common_.tol = tolerance;
  lane.numeric.reset(klu_factor(column_start_.data(), row_.data(), scaled_.data(), symbolic_.get(), &common_));
  if (!lane.numeric) {
    if (common_.status != KLU_SINGULAR) throw std::bad_alloc();
    return kNan;
  }
  find_factors(lane);
  return growth(lane);
}

// A column in LUbx has its row indices, rounded up to whole doubles, and then its values. U lacks the diagonal; blocks
// of one unknown have no entry.
void KluSolver::find_factors(Lane& lane) const {
  const klu_numeric& numeric = *lane.numeric;
  lane.l.clear();
  lane.u.clear();
  for (int block = 0; block < symbolic_->nblocks; ++block) {
    const int first = symbolic_->R[block], end = symbolic_->R[block + 1];
    if (end - first == 1) continue;
    const auto* units = static_cast<const double*>(numeric.LUbx[block]);
    const auto add = [units](std::vector<const double*>& all, int start, int length) {
      const int indices = (length * static_cast<int>(sizeof(int)) + 7) / 8;
      for (int i = 0; i < length; ++i) all.push_back(units + start + indices + i);
    };
    for (int k = first; k < end; ++k) {
      add(lane.l, numeric.Lip[k], numeric.Llen[k]);
      add(lane.u, numeric.Uip[k], numeric.Ulen[k]);
    }
  }
}

// Columns are those of the diagonal blocks, without the entries above them.
void KluSolver::find_largest_of_columns(Lane& lane) const {
  for (int block = 0; block < symbolic_->nblocks; ++block) {
    for (int j = symbolic_->R[block]; j < symbolic_->R[block + 1]; ++j) {
      const auto column = static_cast<std::size_t>(symbolic_->Q[j]);
      const auto end = static_cast<std::size_t>(column_start_[column + 1]);
      double largest = -1;
      for (auto k = static_cast<std::size_t>(column_start_[column]); k < end; ++k) {
        if (lane.numeric->Pinv[row_[k]] < symbolic_->R[block] || std::abs(scaled_[k]) <= largest) continue;
        largest = std::abs(scaled_[k]);
        lane.of_column[static_cast<std::size_t>(j)] = static_cast<std::uint32_t>(k);
      }
    }
  }
}

// True only if growth is within the limit of the lane.
bool KluSolver::surely_good(Lane& lane) const {
  const auto* diagonal = static_cast<const double*>(lane.numeric->Udiag);
  Largest u(0);
  u.of(n_, [&](std::size_t i) { return diagonal[i]; });
  lane.largest_u = u.of(lane.u.size(), [&](std::size_t i) { return *lane.u[i]; });
  const double largest_l = Largest(1).of(lane.l.size(), [&](std::size_t i) { return *lane.l[i]; });
  const double least = largest_l * lane.largest_u / lane.limit;  // lower bound for the columns
  bool good = least >= 0;
  for (const std::uint32_t k : lane.of_column) good &= std::abs(scaled_[k]) >= least;
  return good;
}

// Growth; NaN or infinite if the factors are.
double KluSolver::growth(Lane& lane) {
  find_largest_of_columns(lane);
  (void)surely_good(lane);
  if (!std::isfinite(lane.largest_u)) return lane.largest_u;
  klu_rgrowth(column_start_.data(), row_.data(), scaled_.data(), symbolic_.get(), lane.numeric.get(), &common_);
  return Largest(1).of(lane.l.size(), [&](std::size_t i) { return *lane.l[i]; }) / common_.rgrowth;
}

// (S A) x = S b; (S A)' y = b, x = S y.
void KluSolver::solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int index) {
  const Lane& lane = lanes_[static_cast<std::size_t>(index)];
  const auto scale = [&] {
    for (std::size_t r = 0; r < b_to_x.size(); r += n_) {
      for (std::size_t i = 0; i < n_; ++i) b_to_x[r + i] *= lane.scale[i];
    }
  };
  const int n = static_cast<int>(n_);
  if (transpose == Transpose::no) {
    scale();
    klu_solve(symbolic_.get(), lane.numeric.get(), n, rhs, b_to_x.data(), &common_);
  } else {
    klu_tsolve(symbolic_.get(), lane.numeric.get(), n, rhs, b_to_x.data(), &common_);
    scale();
  }
}

Figures KluSolver::lane_figures(int index) const {
  const Lane& lane = lanes_[static_cast<std::size_t>(index)];
  // P S A Q = L U + blocks above: scales are positive, L has a unit diagonal.
  const auto* diagonal = static_cast<const double*>(lane.numeric->Udiag);
  double smallest = std::abs(diagonal[0]), largest = 0;
  int sign = lane.permutation_sign;
  for (std::size_t i = 0; i < n_; ++i) {
    smallest = std::min(smallest, std::abs(diagonal[i]));
    largest = std::max(largest, std::abs(diagonal[i]));
    if (diagonal[i] < 0) sign = -sign;
  }
  return {true, lane.largest_u, smallest / largest, sign};
}

}  // namespace

std::string why_not(const Shape&, ThreadBudget budget) { return budget.threads > 1 ? "it runs on one thread" : ""; }

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision) { return std::make_unique<KluSolver>(); }

std::string version() {
  return std::to_string(KLU_MAIN_VERSION) + "." + std::to_string(KLU_SUB_VERSION) + "." +
         std::to_string(KLU_SUBSUB_VERSION);
}

}  // namespace assur::klu
