#include "groups/singularity.hpp"

#include <algorithm>
#include <cmath>

#include "decompositions.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr double kFold = 30;  // a larger ratio of velocity to input velocity near a singularity indicates a fold
constexpr std::int32_t kLargestBlock = 400;  // unknowns; larger blocks would take minutes
constexpr int kInverseIterations = 32;       // a choice: each one divides the other directions by (sigma_1 / sigma_2)^2

using DenseVector = Eigen::Map<Eigen::VectorXd>;

DenseVector vector_of(std::vector<double>& memory, Eigen::Index n) { return {memory.data(), n}; }

// The largest and the smallest singular value of a square matrix A = U B V', which is overwritten. B has a diagonal and
// a row of entries above it.
class SingularValues {
 public:
  SingularValues(DiagnosisMemory& memory, Eigen::Index n)
      : n_(n),
        a_(memory.matrix.data(), n, n),
        diagonal_(vector_of(memory.diagonal, n)),
        above_(vector_of(memory.beside, n)),
        left_(vector_of(memory.vector, n)),
        image_(vector_of(memory.image, n)),
        spare_(memory.spare.data()) {
    make_bidiagonal();
    if (!diagonal_.allFinite() || !above_.allFinite()) return;
    largest = value(n, diagonal_.lpNorm<Eigen::Infinity>() + above_.lpNorm<Eigen::Infinity>());
    smallest = value(1, largest);
  }

  double largest = kNan, smallest = kNan;

  // Part of g, which is overwritten, along the left singular vector of the smallest value.
  [[nodiscard]] double along_smallest(DenseVector g) {
    for (Eigen::Index k = 0; k < n_; ++k) {
      g.tail(n_ - k).applyHouseholderOnTheLeft(a_.col(k).tail(n_ - k - 1), a_(k, k), spare_);
    }
    find_left_vector();
    return left_.dot(g);
  }

 private:
  // Householder's reflections (Golub and Van Loan, Matrix Computations, 5.4.8). Those from the left stay below the
  // diagonal, their factors on it.
  void make_bidiagonal() {
    above_[n_ - 1] = 0;
    for (Eigen::Index k = 0; k < n_; ++k) {
      const Eigen::Index more = n_ - k - 1;
      a_.col(k).tail(more + 1).makeHouseholderInPlace(a_(k, k), diagonal_[k]);
      if (more == 0) break;
      a_.bottomRightCorner(more + 1, more).applyHouseholderOnTheLeft(a_.col(k).tail(more), a_(k, k), spare_);
      a_.row(k).tail(more).makeHouseholderInPlace(a_(k, k + 1), above_[k]);
      a_.bottomRightCorner(more, more)
          .applyHouseholderOnTheRight(a_.row(k).tail(more - 1).transpose(), a_(k, k + 1), spare_);
    }
  }

  // The number of singular values below x: by the pivots of [0 B; B' 0] - x, whose rows can be ordered so that the
  // entries of B lie beside a diagonal of zeros (Golub and Kahan 1965).
  [[nodiscard]] Eigen::Index below(double x) const {
    Eigen::Index negative = 0;
    double pivot = -x;
    for (Eigen::Index i = 0;; ++i) {
      if (std::abs(pivot) < kLeastPivot) pivot = -kLeastPivot;
      if (pivot < 0) ++negative;
      if (i == 2 * n_ - 1) return negative - n_;
      const double entry = i % 2 == 0 ? diagonal_[i / 2] : above_[i / 2];
      pivot = -x - entry * entry / pivot;
    }
  }

  // The k-th singular value, counted from the smallest one, by bisection.
  [[nodiscard]] double value(Eigen::Index k, double most) const {
    double least = 0;
    while (most - least > kEps * most && most > kLeastPivot) {
      const double middle = least + (most - least) / 2;
      if (middle == least || middle == most) break;
      (below(middle) >= k ? most : least) = middle;
    }
    return most;
  }

  // Inverse iteration with B B'.
  void find_left_vector() {
    const double least = kEps * kEps * largest;
    const auto pivot = [&](Eigen::Index i) { return std::abs(diagonal_[i]) > least ? diagonal_[i] : least; };
    left_.setConstant(1);
    for (int k = 0; k < kInverseIterations; ++k) {
      left_.normalize();
      for (Eigen::Index i = n_ - 1; i >= 0; --i) {
        image_[i] = (left_[i] - (i + 1 < n_ ? above_[i] * image_[i + 1] : 0)) / pivot(i);
      }
      image_.normalize();
      for (Eigen::Index i = 0; i < n_; ++i) {
        left_[i] = (image_[i] - (i > 0 ? above_[i - 1] * left_[i - 1] : 0)) / pivot(i);
      }
    }
    left_.normalize();
  }

  static constexpr double kLeastPivot = 1e-290;  // squares of entries up to 1e9 divided by it do not overflow

  Eigen::Index n_;
  Eigen::Map<Eigen::MatrixXd> a_;
  DenseVector diagonal_, above_, left_, image_;
  double* spare_;
};

// Norm of the gradient of an equation in one lane, over the unknowns and the inputs that its block reads. A block of
// one unknown has only one singular value, which is small or large against this norm.
double norm_of_gradient(Workspace& work, std::int32_t equation, std::span<const std::int32_t> reads, int lane,
                        DiagnosisMemory& memory) {
  const std::size_t w = idx(work.lanes), at = idx(equation) * w + idx(lane);
  const Pattern& pattern = work.group_class.pattern;
  double norm = 0;
  for (std::size_t k = 0; k < pattern.row.size(); ++k) {
    if (pattern.row[k] == equation) norm = std::hypot(norm, work.jacobian[k * w + idx(lane)]);
  }
  memory.rates.assign(work.input_rates.size(), 0.0);
  memory.rhs.assign(work.rhs.size(), 0.0);
  for (const std::int32_t read : reads) {
    if (read < work.group_class.n) continue;
    const auto input = memory.rates.begin() + static_cast<std::ptrdiff_t>(idx(read - work.group_class.n) * w);
    std::fill_n(input, w, 1.0);
    work.evaluator->velocity_rhs(memory.rates.data(), memory.rhs.data());
    std::fill_n(input, w, 0.0);
    norm = std::hypot(norm, memory.rhs[at]);
  }
  return norm;
}

}  // namespace

void DiagnosisMemory::reserve(const Workspace& work, const BlockConditions& blocks) {
  for (std::int32_t b = 0; b < work.group_class.blocks; ++b) {
    const std::size_t n = blocks.size(b) > kLargestBlock ? 0 : idx(blocks.size(b));
    matrix.resize(std::max(matrix.size(), n * n));
    for (auto* v : {&diagonal, &beside, &right_side, &vector, &image, &spare}) v->resize(std::max(v->size(), n));
    most_read = std::max(most_read, blocks.reads(b).size());
  }
  rates.reserve(work.input_rates.size());
  rhs.reserve(work.rhs.size());
}

void nearest_singularity(Workspace& work, const BlockConditions& blocks, const Pack& pack, double* const (&state)[3],
                         DiagnosisMemory& memory, Singularity& into) {
  const std::size_t w = idx(work.lanes);
  work.set_inputs(pack, state[0]);
  work.evaluate(state[0] + pack.unknowns);
  work.gather(pack, state[1], work.input_rates);
  work.evaluator->velocity_rhs(work.input_rates.data(), work.rhs.data());
  // The right-hand side of each block, by the inputs and by the group's other blocks: rhs - J v over the unknowns of
  // other blocks.
  const Pattern& pattern = work.group_class.pattern;
  const double* rate = state[1] + pack.unknowns;
  for (std::int32_t c = 0; c < work.group_class.n; ++c) {
    for (std::int32_t k = pattern.column_start[idx(c)]; k < pattern.column_start[idx(c) + 1]; ++k) {
      const std::int32_t row = pattern.row[idx(k)];
      if (work.group_class.equation_block[idx(row)] == work.group_class.unknown_block[idx(c)]) continue;
      for (std::size_t l = 0; l < w; ++l)
        work.rhs[idx(row) * w + l] -= work.jacobian[idx(k) * w + l] * rate[idx(c) * w + l];
    }
  }
  const auto input_rate = [&](std::size_t lane) {
    double largest = 0;
    for (std::size_t i = lane; i < work.input_rates.size(); i += w)
      largest = std::max(largest, std::abs(work.input_rates[i]));
    return largest;
  };
  Status& worst = into.status = pack.failed(Code::branch_unknown, 1.0, 0);
  into.block = -1;
  into.lane = 0;
  into.smallest = 0;
  into.reads.clear();
  for (int lane = 0; lane < pack.used; ++lane) {
    for (std::int32_t b = 0; b < work.group_class.blocks; ++b) {
      const Eigen::Index n = blocks.size(b);
      if (n > kLargestBlock) continue;
      blocks.extract(work.jacobian.data(), b, lane, memory.matrix);
      SingularValues values(memory, n);
      const double largest =
          n > 1 ? values.largest : norm_of_gradient(work, blocks.equations(b)[0], blocks.reads(b), lane, memory);
      const double ratio = values.smallest / largest;
      if (!(ratio < worst.figure)) continue;
      worst = pack.failed(Code::branch_unknown, ratio, lane);
      into.block = b;
      into.lane = lane;
      into.smallest = values.smallest;
      if (ratio > 0.05) continue;
      // Towards a fold the velocity along the null vector grows like 1/sigma; at a change point it stays bounded.
      DenseVector g = vector_of(memory.right_side, n);
      for (Eigen::Index i = 0; i < n; ++i)
        g[i] = work.rhs[idx(blocks.equations(b)[static_cast<std::size_t>(i)]) * w + idx(lane)];
      const double velocity = std::abs(values.along_smallest(g)) / values.smallest;
      worst.code = velocity > kFold * input_rate(idx(lane)) ? Code::fold : Code::change_point_passed;
    }
  }
  if (into.block < 0) return;
  for (const std::int32_t c : blocks.reads(into.block)) {
    const bool unknown = c < work.group_class.n;
    if (unknown && work.group_class.unknown_block[idx(c)] == into.block) continue;
    const std::size_t at = idx(unknown ? c : c - work.group_class.n) * w + idx(into.lane);
    into.reads.push_back(unknown ? state[0][pack.unknowns + at] : work.inputs[at]);
  }
}

}  // namespace assur
