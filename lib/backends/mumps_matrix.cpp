#include "backends/mumps_matrix.hpp"

#include <pthread.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <new>
#include <numeric>
#include <string>

#include "parallel/thread_state.hpp"

namespace assur::mumps {
namespace {

// Jobs, controls and results by the numbers of the MUMPS users' guide, which counts from 1.
enum Job : int { kStart = -1, kEnd = -2, kAnalyze = 1, kFactorize = 2, kSolve = 3 };
constexpr int kUseWorld = -987654;     // communicator of the sequential version
constexpr int kMostWorkspace = 10000;  // per cent beyond MUMPS's estimate

// Held while a thread is inside MUMPS. fork() waits for it, so that the first call in the child does not wait forever.
std::mutex turn;
const int kForks = pthread_atfork([] { turn.lock(); }, [] { turn.unlock(); }, [] { turn.unlock(); });

[[noreturn]] void fail(int code, int detail) {
  if (code == -5 || code == -7 || code == -13) throw std::bad_alloc();
  throw Error(Error::Kind::environment,
              "MUMPS failed with INFO(1) = " + std::to_string(code) + ", INFO(2) = " + std::to_string(detail));
}

}  // namespace

Matrix::Matrix(Symmetry symmetry) {
  data_.sym = static_cast<int>(symmetry);
  data_.par = 1;
  data_.comm_fortran = kUseWorld;
  call(kStart);
  if (data_.infog[0] < 0) fail(data_.infog[0], data_.infog[1]);
  const auto control = [&](int number) -> MUMPS_INT& { return data_.icntl[number - 1]; };
  for (int stream : {1, 2, 3, 4}) control(stream) = 0;  // print nothing
  control(6) = symmetry == Symmetry::none ? 1 : 0;      // a transversal by pattern, because values are not known yet
  control(12) = 1;                                      // no compressed ordering, which also needs values
  control(16) = 1;                                      // one thread
  control(33) = 1;                                      // compute the determinant
  data_.cntl[0] = 0.5;  // as for KLU: smaller values let the chain of pivots of a ring multiply their ratios
}

Matrix::~Matrix() { call(kEnd); }

void Matrix::call(int job) {
  const std::scoped_lock lock(turn);
  const BlasThreads one(1);  // BLAS would use those of the caller
  data_.job = job;
  dmumps_c(&data_);
}

void Matrix::analyze(int order, std::span<int> row, std::span<int> column) {
  values_.resize(row.size());
  data_.n = order;
  data_.nnz = static_cast<MUMPS_INT8>(row.size());
  data_.irn = row.data();
  data_.jcn = column.data();
  data_.a = values_.data();
  call(kAnalyze);
  structurally_singular_ = data_.infog[0] == -6;
  if (data_.infog[0] < 0 && !structurally_singular_) fail(data_.infog[0], data_.infog[1]);
}

Code Matrix::factorize(std::span<const double> values) {
  if (structurally_singular_) return Code::singular;
  std::copy(values.begin(), values.end(), values_.begin());
  call(kFactorize);
  while (data_.infog[0] == -8 || data_.infog[0] == -9) {  // the workspace was too small for the pivots of these values
    if (data_.icntl[13] >= kMostWorkspace) throw std::bad_alloc();
    data_.icntl[13] *= 2;
    call(kFactorize);
  }
  if (data_.infog[0] == -10) return Code::singular;
  if (data_.infog[0] < 0) fail(data_.infog[0], data_.infog[1]);
  return Code::ok;
}

void Matrix::solve(std::span<double> b_to_x, int rhs, Transpose transpose) {
  data_.rhs = b_to_x.data();
  data_.nrhs = rhs;
  data_.lrhs = data_.n;
  data_.icntl[8] = transpose == Transpose::no ? 1 : 0;
  call(kSolve);
  if (data_.infog[0] < 0) fail(data_.infog[0], data_.infog[1]);
}

Figures Matrix::figures() const {
  const double smallest = data_.rinfog[18],
               largest = data_.rinfog[20];  // RINFOG(19), (21): pivots of the scaled matrix
  return {true, 0, smallest / largest, data_.rinfog[11] < 0 ? -1 : 1};
}

// 1 / (|A|_1 |A^-1|_1), the second norm by one round of Hager's power method (Higham 1988).
double Matrix::reciprocal_condition() {
  const auto n = static_cast<std::size_t>(data_.n);
  std::vector<double> x(n, 0.0);
  for (std::size_t k = 0; k < values_.size(); ++k)
    x[static_cast<std::size_t>(data_.jcn[k] - 1)] += std::abs(values_[k]);
  const double norm = *std::max_element(x.begin(), x.end());
  const auto sum = [&] {
    return std::accumulate(x.begin(), x.end(), 0.0, [](double s, double v) { return s + std::abs(v); });
  };
  std::fill(x.begin(), x.end(), 1 / static_cast<double>(n));
  solve(x, 1, Transpose::no);
  const double first = sum();
  for (double& v : x) v = std::copysign(1.0, v);
  solve(x, 1, Transpose::yes);
  const auto largest =
      std::max_element(x.begin(), x.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }) - x.begin();
  std::fill(x.begin(), x.end(), 0.0);
  x[static_cast<std::size_t>(largest)] = 1;
  solve(x, 1, Transpose::no);
  return 1 / (norm * std::max(first, sum()));
}

std::unique_ptr<SymmetricSolver> make_symmetric() { return std::make_unique<Matrix>(Symmetry::indefinite); }

}  // namespace assur::mumps
