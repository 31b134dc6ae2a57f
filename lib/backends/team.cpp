// Dense LU by the solver's own team of threads: the only dense backend whose threads do not interfere with those of
// other solvers.
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "backends/backends.hpp"
#include "backends/blas.hpp"
#include "backends/dense_solver.hpp"
#include "backends/team_lu.hpp"
#include "parallel/thread_state.hpp"

namespace assur::team {
namespace {

template <class T>
class Solver final : public DenseLu<T> {
 public:
  explicit Solver(int threads) : team_(threads) {}

  void prepare(DenseIndex n) override { lu_.emplace(n); }

  bool factorize(const Block<T>& a, std::int32_t* pivot) override { return lu_->factorize(a, pivot, team_); }

  // One thread: the solution reads each factor once, which more threads would not do faster.
  void solve(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
             DenseIndex) override {
    const BlasThreads one(1);
    blas::getrs(lu, pivot, x, transpose);
  }

 private:
  Team team_;
  std::optional<TeamLu<T>> lu_;
};

}  // namespace

std::string why_not(const Shape& shape, ThreadBudget) {
  const std::string too_large = why_not_dense(shape);
  if (!too_large.empty()) return too_large;
  return why_not_blas_threads(1);  // in each thread
}

std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision) {
  if (precision == Precision::binary32) {
    return make_dense_solver<float>(std::make_unique<Solver<float>>(budget.threads));
  }
  return make_dense_solver<double>(std::make_unique<Solver<double>>(budget.threads));
}

std::string version() { return blas_version(); }

}  // namespace assur::team
