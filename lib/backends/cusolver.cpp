// Dense LU on an NVIDIA device: one call of cuBLAS factorises the small matrices of all lanes, cuSOLVER one large
// matrix after another. Matrices and right-hand sides travel to the device, solutions back, and factors stay there.
// Each solver has its own stream, so that callers do not wait for each other.
#include "backends/cusolver.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "backends/backends.hpp"
#include "backends/cuda.hpp"
#include "backends/dense_solver.hpp"
#include "median.hpp"

namespace assur::cusolver {
namespace {

constexpr std::int32_t kMostBatched = 128;  // unknowns up to which cuBLAS factorises all lanes; not measured yet
constexpr double kSmallMemory = 64 << 20;   // bytes that every device has

using cuda::check;
using cuda::check_cuda;
using cuda::Marks;
using cuda::mebibytes;
using cuda::Memory;
using cuda::Queue;
using cuda::Where;

template <class T>
class CusolverSolver final : public LinearSolver {
 public:
  Status analyze(const Pattern& pattern, int lanes) override;
  Status factorize(std::span<const double> values) override;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override;
  [[nodiscard]] Figures figures(int lane) const override;

  // Marks points in time in each further call.
  void mark(const Marks* marks) { marks_ = marks; }

 private:
  void allocate();
  void eliminate();
  void substitute(DenseIndex columns, Transpose transpose);
  void set_mark(std::size_t mark) const {
    if (marks_) marks_->set(mark, *queue_);
  }
  // From lane to lane: one column more than the matrix has, so that the diagonal elements of all lanes are evenly
  // spaced, by n + 1 numbers.
  [[nodiscard]] DenseIndex step() const { return n_ * (n_ + 1); }
  [[nodiscard]] T* matrix(DenseIndex lane) const { return device_.matrices.data() + lane * step(); }
  [[nodiscard]] int order() const { return static_cast<int>(n_); }

  const cuda::Library& cuda_ = cuda::library();
  const cuda::Dense<T>& dense_ = [this]() -> const cuda::Dense<T>& {
    if constexpr (std::is_same_v<T, double>) {
      return cuda_.in_double;
    } else {
      return cuda_.in_float;
    }
  }();
  const Marks* marks_ = nullptr;
  DenseIndex n_ = 0, lanes_ = 0;
  bool batched_ = false;
  std::vector<DenseIndex> place_;  // nnz: place of each nonzero in a matrix
  std::vector<double> largest_;    // lanes: max |A|
  std::vector<Code> code_;         // lanes
  struct {
    Memory<T, Where::device> matrices;             // lanes x step(), then factors
    Memory<T, Where::device> right;                // lanes x kRightSides x n
    Memory<T, Where::device> diagonal;             // lanes x n
    Memory<T, Where::device> work;                 // of cuSOLVER
    Memory<T*, Where::device> matrix, right_side;  // lanes: pointers for cuBLAS
    Memory<int, Where::device> pivot;              // lanes x n
    Memory<int, Where::device> info;               // lanes
  } device_;
  struct {
    Memory<T, Where::host> matrices;  // as on the device; elements without a nonzero stay 0
    Memory<T, Where::host> right;
    Memory<T, Where::host> diagonal;
    Memory<int, Where::host> info;
  } host_;
  std::unique_ptr<Queue> queue_;  // its destruction comes first
};

template <class T>
Status CusolverSolver<T>::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  n_ = pattern.n;
  lanes_ = lanes;
  batched_ = pattern.n <= kMostBatched;
  place_ = dense_places(pattern, n_);
  largest_.assign(static_cast<std::size_t>(lanes), 0.0);
  code_.assign(static_cast<std::size_t>(lanes), Code::singular);  // until factorize()
  if (n_ > 0) allocate();
  return {};
}

template <class T>
void CusolverSolver<T>::allocate() {
  queue_ = std::make_unique<Queue>();
  device_.matrices = Memory<T, Where::device>(lanes_ * step());
  device_.right = Memory<T, Where::device>(lanes_ * kRightSides * n_);
  device_.diagonal = Memory<T, Where::device>(lanes_ * n_);
  device_.pivot = Memory<int, Where::device>(lanes_ * n_);
  device_.info = Memory<int, Where::device>(lanes_);
  host_.matrices = Memory<T, Where::host>(lanes_ * step());
  host_.right = Memory<T, Where::host>(lanes_ * kRightSides * n_);
  host_.diagonal = Memory<T, Where::host>(lanes_ * n_);
  host_.info = Memory<int, Where::host>(lanes_);
  std::fill_n(host_.matrices.data(), lanes_ * step(), T{0});
  if (batched_) {
    const Memory<T*, Where::host> pointers(2 * lanes_);
    for (DenseIndex lane = 0; lane < lanes_; ++lane) {
      pointers.data()[lane] = matrix(lane);
      pointers.data()[lanes_ + lane] = device_.right.data() + lane * kRightSides * n_;
    }
    device_.matrix = Memory<T*, Where::device>(lanes_);
    device_.right_side = Memory<T*, Where::device>(lanes_);
    queue_->upload(device_.matrix.data(), pointers.data(), lanes_);
    queue_->upload(device_.right_side.data(), pointers.data() + lanes_, lanes_);
    queue_->wait();
  } else {
    int size = 0;
    check(dense_.getrf_size(queue_->solver(), order(), order(), matrix(0), order(), &size),
          "cusolverDnXgetrf_bufferSize");
    device_.work = Memory<T, Where::device>(size);
  }
}

template <class T>
Status CusolverSolver<T>::factorize(std::span<const double> values) {
  check_size("values", values.size(), place_.size() * static_cast<std::size_t>(lanes_));
  if (n_ == 0) {
    std::fill(code_.begin(), code_.end(), Code::ok);
    return {};
  }
  std::fill(code_.begin(), code_.end(), Code::singular);  // if the device fails below, there are no factors
  for (DenseIndex lane = 0; lane < lanes_; ++lane) {
    const double* const first = values.empty() ? nullptr : values.data() + lane;
    largest_[static_cast<std::size_t>(lane)] = spread(first, lanes_, place_, host_.matrices.data() + lane * step());
  }
  set_mark(0);
  queue_->upload(device_.matrices.data(), host_.matrices.data(), lanes_ * step());
  set_mark(1);
  eliminate();
  check(dense_.copy(queue_->blas(), static_cast<int>(lanes_ * n_), matrix(0), order() + 1, device_.diagonal.data(), 1),
        "cublasXcopy");
  set_mark(2);
  queue_->download(host_.diagonal.data(), device_.diagonal.data(), lanes_ * n_);
  queue_->download(host_.info.data(), device_.info.data(), lanes_);
  set_mark(3);
  queue_->wait();
  for (DenseIndex lane = 0; lane < lanes_; ++lane) {
    T poison = 0;  // an overflow during the elimination reaches the diagonal
    for (DenseIndex j = 0; j < n_; ++j) poison += host_.diagonal.data()[lane * n_ + j] * 0;
    const bool regular = host_.info.data()[lane] == 0 && poison == 0;
    const bool finite = std::isfinite(largest_[static_cast<std::size_t>(lane)]);
    code_[static_cast<std::size_t>(lane)] = !finite ? Code::not_finite : regular ? Code::ok : Code::singular;
  }
  return worst(code_);
}

template <class T>
void CusolverSolver<T>::eliminate() {
  if (batched_) {
    check(dense_.getrf_batched(queue_->blas(), order(), device_.matrix.data(), order(), device_.pivot.data(),
                               device_.info.data(), static_cast<int>(lanes_)),
          "cublasXgetrfBatched");
    return;
  }
  for (DenseIndex lane = 0; lane < lanes_; ++lane) {
    check(dense_.getrf(queue_->solver(), order(), order(), matrix(lane), order(), device_.work.data(),
                       device_.pivot.data() + lane * n_, device_.info.data() + lane),
          "cusolverDnXgetrf");
  }
}

template <class T>
Status CusolverSolver<T>::solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) {
  check_size("numbers on the right-hand side", b_to_x.size(),
             static_cast<std::size_t>(n_ * rhs) * static_cast<std::size_t>(lanes_));
  const DenseIndex row = kRightSides * n_;  // right-hand sides of a lane
  for (DenseIndex first = 0; first < rhs && n_ > 0; first += kRightSides) {
    const DenseIndex columns = std::min<DenseIndex>(kRightSides, rhs - first);
    std::array<std::array<int, kRightSides>, kMostLanes> exponent{};
    const auto each = [&](const auto& visit) {
      for (DenseIndex lane = 0; lane < lanes_; ++lane) {
        for (DenseIndex r = 0; r < columns; ++r) {
          visit(b_to_x.data() + (first + r) * n_ * lanes_ + lane, host_.right.data() + lane * row + r * n_,
                exponent[static_cast<std::size_t>(lane)][static_cast<std::size_t>(r)]);
        }
      }
    };
    each([&](const double* b, T* x, int& e) { e = take_right_side(b, lanes_, n_, x); });
    set_mark(0);
    queue_->copy_rows(device_.right.data(), host_.right.data(), columns * n_, row, lanes_, cuda::kToDevice);
    set_mark(1);
    substitute(columns, transpose);
    set_mark(2);
    queue_->copy_rows(host_.right.data(), device_.right.data(), columns * n_, row, lanes_, cuda::kToHost);
    set_mark(3);
    queue_->wait();
    const DenseIndex wanted = transpose == Transpose::yes ? 0 : first_wanted;
    each([&](double* b, const T* x, int e) { give_solution(x, n_, e, wanted, b, lanes_); });
  }
  for (int lane = 0; lane < static_cast<int>(lanes_); ++lane) {
    if (code_[static_cast<std::size_t>(lane)] != Code::ok) fill_with_nan(b_to_x, static_cast<int>(lanes_), lane);
  }
  return worst(code_);
}

template <class T>
void CusolverSolver<T>::substitute(DenseIndex columns, Transpose transpose) {
  const int operation = transpose == Transpose::yes ? cuda::kTransposed : cuda::kPlain;
  const int rhs = static_cast<int>(columns);
  if (batched_) {
    int info = 0;
    check(
        dense_.getrs_batched(queue_->blas(), operation, order(), rhs, device_.matrix.data(), order(),
                             device_.pivot.data(), device_.right_side.data(), order(), &info, static_cast<int>(lanes_)),
        "cublasXgetrsBatched");
    return;
  }
  for (DenseIndex lane = 0; lane < lanes_; ++lane) {
    check(
        dense_.getrs(queue_->solver(), operation, order(), rhs, matrix(lane), order(), device_.pivot.data() + lane * n_,
                     device_.right.data() + lane * kRightSides * n_, order(), device_.info.data() + lane),
        "cusolverDnXgetrs");
  }
}

// Fetches the factors, which is slow; no step asks for these figures.
template <class T>
Figures CusolverSolver<T>::figures(int lane) const {
  if (code_[static_cast<std::size_t>(lane)] != Code::ok) return {};
  if (n_ == 0) return {true, 1, 1, 1};
  std::vector<T> factors(static_cast<std::size_t>(n_ * n_));
  std::vector<int> pivot(static_cast<std::size_t>(n_));
  queue_->download(factors.data(), static_cast<const T*>(matrix(lane)), n_ * n_);
  queue_->download(pivot.data(), static_cast<const int*>(device_.pivot.data() + lane * n_), n_);
  queue_->wait();
  return dense_figures(Block<T>{factors.data(), n_, n_, n_}, pivot.data(), largest_[static_cast<std::size_t>(lane)]);
}

}  // namespace

std::string why_not(const Shape& shape, ThreadBudget budget) {
  if (std::string why = cuda::library().why_not; !why.empty()) return why;
  if (budget.threads > 1) return "it runs on one thread";
  if (std::string why = why_not_dense(shape); !why.empty()) return why;
  const double lanes = std::bit_ceil(static_cast<unsigned>(std::clamp(shape.groups, 1, kMostLanes)));
  const double needed = 8.0 * lanes * shape.n * (shape.n + 1.0);
  std::size_t free = 0, total = 0;
  if (needed <= kSmallMemory || cuda::library().cudaMemGetInfo(&free, &total) != 0) return "";
  if (needed <= static_cast<double>(total)) return "";
  return "dense factors of " + std::to_string(static_cast<int>(lanes)) + " x " + std::to_string(shape.n) +
         " unknowns need " + mebibytes(needed) + ", and the GPU has " + mebibytes(static_cast<double>(total));
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision precision) {
  if (!cuda::library().why_not.empty()) return nullptr;
  if (precision == Precision::binary32) return std::make_unique<CusolverSolver<float>>();
  return std::make_unique<CusolverSolver<double>>();
}

std::string version() { return cuda::library().version; }

namespace {

// |1 - A x| / (|A| |x| + 1) in maximum norms.
double backward_error(const Pattern& pattern, std::span<const double> values, std::span<const double> x) {
  const auto n = static_cast<std::size_t>(pattern.n);
  std::vector<double> residual(n, 1.0), sum(n, 0.0);  // sum: of the sizes in a row of A
  for (std::size_t j = 0; j < n; ++j) {
    for (auto k = pattern.column_start[j]; k < pattern.column_start[j + 1]; ++k) {
      const auto i = static_cast<std::size_t>(pattern.row[static_cast<std::size_t>(k)]);
      const double value = values[static_cast<std::size_t>(k)];
      residual[i] -= value * x[j];
      sum[i] += std::abs(value);
    }
  }
  const auto largest = [](std::span<const double> of) {
    double most = 0;
    for (const double value : of) most = std::max(most, std::abs(value));
    return most;
  };
  return largest(residual) / (largest(sum) * largest(x) + 1);
}

}  // namespace

Breakdown break_down(const Pattern& pattern, std::span<const double> values, int calls) {
  const Marks marks;
  CusolverSolver<double> solver;
  (void)solver.analyze(pattern, 1);
  std::vector<double> x(static_cast<std::size_t>(pattern.n));
  const auto call = [&](bool factorize) {
    std::fill(x.begin(), x.end(), 1.0);
    if (!(factorize ? solver.factorize(values) : solver.solve(x, 1, Transpose::no, 0)).ok()) {
      throw Error(Error::Kind::numerical, "cusolver cannot factorise the matrix");
    }
  };
  // Each column: a part of the time of all calls.
  const auto times = [&](bool factorize) {
    std::array<std::vector<double>, 4> parts;
    for (int i = 0; i < calls; ++i) {
      const auto start = std::chrono::steady_clock::now();
      call(factorize);
      const std::chrono::duration<double> whole = std::chrono::steady_clock::now() - start;
      for (std::size_t p = 0; p < 3; ++p) parts[p].push_back(marks.seconds(p));
      parts[3].push_back(whole.count());
    }
    const auto of = [&](std::size_t p) { return median(std::move(parts[p])); };
    return CallTimes{of(0), of(1), of(2), of(3)};
  };
  solver.mark(&marks);
  call(true);
  call(false);
  const CallTimes factorize = times(true), solve = times(false);
  return {factorize, solve, backward_error(pattern, values, x)};
}

}  // namespace assur::cusolver
