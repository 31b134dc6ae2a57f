// Dense LU by Eigen's products, one lane after the other.
#include <Eigen/Core>
#include <string>

#include "backends/backends.hpp"
#include "backends/dense_lu.hpp"
#include "backends/dense_solver.hpp"

namespace assur::eigen {
namespace {

template <class T>
class EigenLu final : public DenseLu<T> {
 public:
  bool factorize(const Block<T>& a, std::int32_t* pivot) override {
    if (!eliminate(a, pivot)) return false;
    for (DenseIndex k = 0; k < a.columns; ++k) ++pivot[k];  // counted from 1
    return true;
  }

  void solve(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
             DenseIndex first_wanted) override {
    solve_factored(lu, pivot, x, transpose, first_wanted);
  }
};

}  // namespace

std::string why_not(const Shape& shape, ThreadBudget budget) {
  return budget.threads > 1 ? "it runs on one thread" : why_not_dense(shape);
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision precision) {
  if (precision == Precision::binary32) return make_dense_solver<float>(std::make_unique<EigenLu<float>>());
  return make_dense_solver<double>(std::make_unique<EigenLu<double>>());
}

std::string version() {
  return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
         std::to_string(EIGEN_MINOR_VERSION);
}

}  // namespace assur::eigen
