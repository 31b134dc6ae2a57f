// Dense LU by LAPACK's dgetrf and dgetrs (sgetrf, sgetrs), one lane after the other, with the threads of the budget.
#include "backends/backends.hpp"
#include "backends/blas.hpp"
#include "backends/dense_solver.hpp"
#include "parallel/thread_state.hpp"

namespace assur::lapack {
namespace {

template <class T>
class LapackLu final : public DenseLu<T> {
 public:
  explicit LapackLu(int threads) : threads_(threads) {}

  bool factorize(const Block<T>& a, std::int32_t* pivot) override {
    const BlasThreads threads(threads_);
    return blas::getrf(a, pivot);
  }

  void solve(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
             DenseIndex) override {
    const BlasThreads threads(threads_);
    blas::getrs(lu, pivot, x, transpose);
  }

 private:
  int threads_;
};

}  // namespace

std::string why_not(const Shape& shape, ThreadBudget budget) {
  const std::string too_large = why_not_dense(shape);
  return too_large.empty() ? why_not_blas_threads(budget.threads) : too_large;
}

std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision) {
  if (precision == Precision::binary32) {
    return make_dense_solver<float>(std::make_unique<LapackLu<float>>(budget.threads));
  }
  return make_dense_solver<double>(std::make_unique<LapackLu<double>>(budget.threads));
}

std::string version() { return blas_version(); }

}  // namespace assur::lapack
