// Sparse LU by KLU: block triangular form, AMD ordering, rows scaled. One analysis for all lanes; each lane is
// factorised with pivoting once and then refactorised on the same pivots, which is several times faster and allocates
// nothing, for as long as those pivots stay good.
//
// What "good" means. The computed factors are exact for a matrix A + E with |E| <= n eps |L| |U| (Higham, Accuracy and
// Stability of Numerical Algorithms, theorem 9.3), so that, column by column, the error relative to max |A_j| is at
// most a factor of n^2 eps times
//     growth = max |L| * max_j (max |U_j| / max |A_j|).
// Growth of U alone would miss a small pivot whose column of L is large. It is watched after every factorisation:
//   - refactorised, and growth above the lane's limit: factorise with pivoting again;
//   - pivoted with the relaxed tolerance, and growth above kGrowth: factorise with partial pivoting, and take twice the
//     growth of that as the lane's limit, since nothing better can be had.
// Measured in full it would cost a third of a refactorisation. Mostly a bound suffices that is cheap: max |L| max |U|
// over the smallest column of A, where a column is at least as large as that entry of it which was the largest when
// last measured.
//
// The tolerance decides more than speed: a chain of n / 2 pivots that are each a bit smaller than the entry below them
// multiplies their ratios. With KLU's own 0.001, and with 0.1 still, growth is 1e107 on the ring of 360 points.
#include <klu.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
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

// max |number| that neither NaN nor infinity escapes: as bits, both are larger than any finite size. Four at a time,
// for the sake of speed.
class Largest {
 public:
  explicit Largest(double at_least) { size_[0] = bits(at_least); }

  template <typename At>
  double of(std::size_t count, const At& at) {
    std::size_t k = 0;
    for (; k + 4 <= count; k += 4) {
      for (std::size_t i = 0; i < 4; ++i) size_[i] = std::max(size_[i], bits(at(k + i)));
    }
    for (; k < count; ++k) size_[0] = std::max(size_[0], bits(at(k)));
    return std::bit_cast<double>(std::max(std::max(size_[0], size_[1]), std::max(size_[2], size_[3])));
  }

 private:
  static std::uint64_t bits(double number) { return std::bit_cast<std::uint64_t>(number) & ~(std::uint64_t{1} << 63); }

  std::uint64_t size_[4] = {};
};

// False for NaN and infinity.
bool all_finite(std::span<const double> values) {
  double poison[4] = {};  // 0 as long as every value is finite, else NaN
  std::size_t k = 0;
  for (; k + 4 <= values.size(); k += 4) {
    for (std::size_t i = 0; i < 4; ++i) poison[i] += values[k + i] * 0;
  }
  for (; k < values.size(); ++k) poison[0] += values[k] * 0;
  return poison[0] + poison[1] + poison[2] + poison[3] == 0;
}

class KluSolver final : public LinearSolver {
 public:
  KluSolver();
  Status analyze(const Pattern& pattern, int lanes) override;
  Status factorize(std::span<const double> values) override;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override;
  Figures figures(int lane) const override;
  Effort effort() const override { return {.renewed = renewed_}; }

 private:
  struct Entry {
    std::uint32_t at, pivot;  // which nonzero, and in the row of which pivot
  };
  struct Lane {
    std::unique_ptr<klu_numeric, FreeNumeric> numeric;
    std::vector<const double*> l, u;  // values of L and U without their diagonals; they move with new pivots only
    std::vector<Entry> witness;       // n: the largest of its column, rows scaled, when growth was last measured
    Code code = Code::singular;       // until factorised
    double limit = kGrowth;           // of growth, for a refactorisation
    double largest_u = 0;             // rows scaled: the largest of A is 1
    int permutation_sign = 0;         // of rows and columns together
  };

  Code factorize_lane(std::span<const double> values, Lane& lane);
  bool refactorize(std::span<const double> values, Lane& lane);
  Code factorize_with_pivoting(std::span<const double> values, Lane& lane);
  double pivot(std::span<const double> values, Lane& lane, double tolerance);
  void find_factors(Lane& lane) const;
  void find_witnesses(std::span<const double> values, Lane& lane) const;
  bool surely_good(std::span<const double> values, Lane& lane) const;
  double growth(std::span<const double> values, Lane& lane);

  klu_common common_;
  std::int64_t renewed_ = 0;
  std::unique_ptr<klu_symbolic, FreeSymbolic> symbolic_;
  std::size_t n_ = 0;
  std::vector<int> column_start_, row_;  // n + 1, nnz
  std::vector<double> values_;           // nnz, of one lane
  std::vector<double> right_;            // n x kRightSides, of one lane
  std::vector<bool> seen_;               // n
  std::vector<Lane> lanes_;
  std::vector<Code> code_;  // lanes
};

KluSolver::KluSolver() { klu_defaults(&common_); }

Status KluSolver::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  lanes_.clear();  // before the analysis that they share
  renewed_ = 0;
  symbolic_.reset();
  n_ = static_cast<std::size_t>(pattern.n);
  column_start_ = pattern.column_start;
  row_ = pattern.row;
  values_.resize(row_.size());
  right_.resize(n_ * kRightSides);
  seen_.resize(n_);
  for (int lane = 0; lane < lanes; ++lane) {
    Lane& added = lanes_.emplace_back();
    added.numeric = {nullptr, FreeNumeric{&common_}};
    added.witness.resize(n_);
  }
  code_.assign(lanes_.size(), Code::singular);
  if (row_.empty()) return {};  // KLU knows no empty matrix

  symbolic_ = {klu_analyze(pattern.n, column_start_.data(), row_.data(), &common_), FreeSymbolic{&common_}};
  if (!symbolic_ && common_.status != KLU_SINGULAR) throw std::bad_alloc();
  return {};
}

Status KluSolver::factorize(std::span<const double> values) {
  check_size("values", values.size(), row_.size() * lanes_.size());
  const int w = static_cast<int>(lanes_.size());
  for (std::size_t i = 0; i < lanes_.size(); ++i) {
    Lane& lane = lanes_[i];
    if (w == 1) {
      lane.code = all_finite(values) ? factorize_lane(values, lane) : Code::not_finite;
    } else {
      const double largest = take_lane(values, w, static_cast<int>(i), values_);
      lane.code = std::isfinite(largest) ? factorize_lane(values_, lane) : Code::not_finite;
    }
    code_[i] = lane.code;
  }
  return worst(code_);
}

Code KluSolver::factorize_lane(std::span<const double> values, Lane& lane) {
  if (n_ == 0) return Code::ok;
  if (!symbolic_ || symbolic_->structural_rank < symbolic_->n) return Code::singular;
  return refactorize(values, lane) ? Code::ok : factorize_with_pivoting(values, lane);
}

// False if there are no pivots yet, or they have become bad for these values.
bool KluSolver::refactorize(std::span<const double> values, Lane& lane) {
  if (!lane.numeric) return false;
  if (!klu_refactor(column_start_.data(), row_.data(), const_cast<double*>(values.data()), symbolic_.get(),
                    lane.numeric.get(), &common_) ||
      common_.status != KLU_OK) {
    return false;
  }
  return surely_good(values, lane) || growth(values, lane) <= lane.limit;  // false for NaN
}

Code KluSolver::factorize_with_pivoting(std::span<const double> values, Lane& lane) {
  if (lane.numeric) ++renewed_;
  lane.limit = kGrowth;
  double reached = pivot(values, lane, kRelaxed);
  if (!(reached <= kGrowth)) {
    reached = pivot(values, lane, kPartial);
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
double KluSolver::pivot(std::span<const double> values, Lane& lane, double tolerance) {
  common_.tol = tolerance;
  lane.numeric.reset(
      klu_factor(column_start_.data(), row_.data(), const_cast<double*>(values.data()), symbolic_.get(), &common_));
  if (!lane.numeric) {
    if (common_.status != KLU_SINGULAR) throw std::bad_alloc();
    return std::numeric_limits<double>::quiet_NaN();
  }
  find_factors(lane);
  return growth(values, lane);
}

// A column in LUbx is its row indices, rounded up to whole doubles, and then its values; U without the diagonal, and
// nothing for blocks of one unknown.
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

// Columns are those of the diagonal blocks.
void KluSolver::find_witnesses(std::span<const double> values, Lane& lane) const {
  const klu_numeric& numeric = *lane.numeric;
  for (int block = 0; block < symbolic_->nblocks; ++block) {
    for (int j = symbolic_->R[block]; j < symbolic_->R[block + 1]; ++j) {
      const auto column = static_cast<std::size_t>(symbolic_->Q[j]);
      const auto end = static_cast<std::size_t>(column_start_[column + 1]);
      double largest = -1;
      for (auto k = static_cast<std::size_t>(column_start_[column]); k < end; ++k) {
        const int pivot = numeric.Pinv[row_[k]];
        const double size = std::abs(values[k]) / numeric.Rs[pivot];
        if (pivot < symbolic_->R[block] || size <= largest) continue;
        largest = size;
        lane.witness[static_cast<std::size_t>(j)] = {static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(pivot)};
      }
    }
  }
}

// True only if growth is within the limit of the lane.
bool KluSolver::surely_good(std::span<const double> values, Lane& lane) const {
  const auto* diagonal = static_cast<const double*>(lane.numeric->Udiag);
  const double* const scale = lane.numeric->Rs;  // of rows, in the order of the pivots
  Largest u(0);
  u.of(n_, [&](std::size_t i) { return diagonal[i]; });
  lane.largest_u = u.of(lane.u.size(), [&](std::size_t i) { return *lane.u[i]; });
  const double largest_l = Largest(1).of(lane.l.size(), [&](std::size_t i) { return *lane.l[i]; });
  const double least = largest_l * lane.largest_u / lane.limit;  // of a column
  bool good = least >= 0;
  for (const Entry& entry : lane.witness) good &= std::abs(values[entry.at]) >= least * scale[entry.pivot];
  return good;
}

// NaN or infinite where factors are.
double KluSolver::growth(std::span<const double> values, Lane& lane) {
  find_witnesses(values, lane);
  (void)surely_good(values, lane);
  if (!std::isfinite(lane.largest_u)) return lane.largest_u;
  klu_rgrowth(column_start_.data(), row_.data(), const_cast<double*>(values.data()), symbolic_.get(),
              lane.numeric.get(), &common_);
  return Largest(1).of(lane.l.size(), [&](std::size_t i) { return *lane.l[i]; }) / common_.rgrowth;
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
  return {true, lane.largest_u, smallest / largest, sign};
}

}  // namespace

std::string why_not(const Shape&, ThreadBudget) { return ""; }

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision) { return std::make_unique<KluSolver>(); }

std::string version() {
  return std::to_string(KLU_MAIN_VERSION) + "." + std::to_string(KLU_SUB_VERSION) + "." +
         std::to_string(KLU_SUBSUB_VERSION);
}

}  // namespace assur::klu
