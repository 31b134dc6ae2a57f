// Sparse LU by UMFPACK, which is under the GPL and is built only with ASSUR_WITH_GPL. One analysis for all lanes; each
// factorisation chooses new pivots and takes its memory from the heap.
#include <umfpack.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "backends/backends.hpp"
#include "backends/lane_by_lane.hpp"
#include "parallel/thread_state.hpp"

namespace assur::umfpack {
namespace {

// As for KLU: smaller values let the chain of pivots of a ring multiply their ratios.
constexpr double kPivotTolerance = 0.5;

struct FreeSymbolic {
  void operator()(void* symbolic) const { umfpack_di_free_symbolic(&symbolic); }
};
struct FreeNumeric {
  void operator()(void* numeric) const { umfpack_di_free_numeric(&numeric); }
};

// Other failures than singular matrices are a lack of memory, or an error in this file.
void check(int status, const char* call) {
  if (status >= UMFPACK_OK) return;
  if (status == UMFPACK_ERROR_out_of_memory) throw std::bad_alloc();
  throw Error(Error::Kind::environment, std::string(call) + " of UMFPACK failed with status " + std::to_string(status));
}

class UmfpackSolver final : public LaneByLane {
 public:
  UmfpackSolver();

 private:
  struct Lane {
    std::unique_ptr<void, FreeNumeric> numeric;
    double reciprocal_condition = 0;
    std::vector<double> values;  // nnz: umfpack_di_wsolve needs the matrix
  };

  void analyze_lanes(const Pattern& pattern, int lanes) override;
  Code factorize_lane(std::span<const double> values, int lane) override;
  void solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int lane) override;
  [[nodiscard]] Figures lane_figures(int lane) const override;

  std::array<double, UMFPACK_CONTROL> control_{};
  std::unique_ptr<void, FreeSymbolic> symbolic_;
  std::size_t n_ = 0;
  std::vector<int> column_start_, row_;  // n + 1, nnz
  std::vector<double> solution_;         // n
  std::vector<double> real_work_;        // n
  std::vector<int> integer_work_;        // n
  std::vector<Lane> lanes_;
};

UmfpackSolver::UmfpackSolver() {
  umfpack_di_defaults(control_.data());
  control_[UMFPACK_PIVOT_TOLERANCE] = kPivotTolerance;
  control_[UMFPACK_SYM_PIVOT_TOLERANCE] = kPivotTolerance;
  control_[UMFPACK_IRSTEP] = 0;  // only +refine asks for refinement
}

void UmfpackSolver::analyze_lanes(const Pattern& pattern, int lanes) {
  n_ = static_cast<std::size_t>(pattern.n);
  column_start_ = pattern.column_start;
  row_ = pattern.row;
  for (auto* vector : {&solution_, &real_work_}) vector->resize(n_);
  integer_work_.resize(n_);
  lanes_.clear();
  lanes_.resize(static_cast<std::size_t>(lanes));
  for (Lane& lane : lanes_) lane.values.resize(row_.size());
  const BlasThreads one(1);
  void* symbolic = nullptr;
  const int status = umfpack_di_symbolic(pattern.n, pattern.n, column_start_.data(), row_.data(), nullptr, &symbolic,
                                         control_.data(), nullptr);
  symbolic_.reset(symbolic);
  check(status, "the analysis");
}

Code UmfpackSolver::factorize_lane(std::span<const double> values, int index) {
  Lane& lane = lanes_[static_cast<std::size_t>(index)];
  std::copy(values.begin(), values.end(), lane.values.begin());
  std::array<double, UMFPACK_INFO> info{};
  const BlasThreads one(1);  // BLAS would use those of the caller
  void* numeric = nullptr;
  lane.numeric.reset();
  const int status = umfpack_di_numeric(column_start_.data(), row_.data(), lane.values.data(), symbolic_.get(),
                                        &numeric, control_.data(), info.data());
  lane.numeric.reset(numeric);
  check(status, "the factorisation");
  lane.reciprocal_condition = info[UMFPACK_RCOND];
  return status == UMFPACK_OK ? Code::ok : Code::singular;
}

void UmfpackSolver::solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int index) {
  const Lane& lane = lanes_[static_cast<std::size_t>(index)];
  for (std::size_t r = 0; r < static_cast<std::size_t>(rhs); ++r) {
    double* const b = b_to_x.data() + r * n_;
    check(umfpack_di_wsolve(transpose == Transpose::no ? UMFPACK_A : UMFPACK_At, column_start_.data(), row_.data(),
                            lane.values.data(), solution_.data(), b, lane.numeric.get(), control_.data(), nullptr,
                            integer_work_.data(), real_work_.data()),
          "the solution");
    std::copy(solution_.begin(), solution_.end(), b);
  }
}

Figures UmfpackSolver::lane_figures(int index) const {
  const Lane& lane = lanes_[static_cast<std::size_t>(index)];
  double mantissa = 0, exponent = 0;
  check(umfpack_di_get_determinant(&mantissa, &exponent, lane.numeric.get(), nullptr), "the determinant");

  int in_l = 0, in_u = 0, rows = 0, columns = 0, in_diagonal = 0;
  check(umfpack_di_get_lunz(&in_l, &in_u, &rows, &columns, &in_diagonal, lane.numeric.get()), "the size of U");
  std::vector<int> u_start(n_ + 1), u_row(static_cast<std::size_t>(in_u));
  std::vector<double> u(u_row.size()), scale(n_);
  int multiplied = 0;  // 1: rows were multiplied by their scales; 0: divided
  check(umfpack_di_get_numeric(nullptr, nullptr, nullptr, u_start.data(), u_row.data(), u.data(), nullptr, nullptr,
                               nullptr, &multiplied, scale.data(), lane.numeric.get()),
        "reading U");
  double largest_a = 0, largest_u = 0;
  for (std::size_t k = 0; k < row_.size(); ++k) {
    const double row_scale = scale[static_cast<std::size_t>(row_[k])];
    largest_a = std::max(largest_a, std::abs(multiplied ? lane.values[k] * row_scale : lane.values[k] / row_scale));
  }
  for (double element : u) largest_u = std::max(largest_u, std::abs(element));
  return {true, largest_u / largest_a, lane.reciprocal_condition, mantissa < 0 ? -1 : 1};
}

}  // namespace

std::string why_not(const Shape&, ThreadBudget budget) {
  return budget.threads > 1 ? "it runs on one thread" : why_not_blas_memory();
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision) { return std::make_unique<UmfpackSolver>(); }

std::string version() {
  return std::to_string(UMFPACK_MAIN_VERSION) + "." + std::to_string(UMFPACK_SUB_VERSION) + "." +
         std::to_string(UMFPACK_SUBSUB_VERSION);
}

}  // namespace assur::umfpack
