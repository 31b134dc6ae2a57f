// One matrix in MUMPS, sequential version: unsymmetric, or symmetric indefinite by one triangle.
#pragma once

#include <dmumps_c.h>

#include <memory>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "backends/augmented.hpp"

namespace assur::mumps {

enum class Symmetry : int { none = 0, indefinite = 2 };  // values of MUMPS's own SYM

// A matrix. MUMPS 5.5 crashes if two threads are inside it, even with different matrices, so that calls take turns.
class Matrix final : public SymmetricSolver {
 public:
  explicit Matrix(Symmetry symmetry);
  Matrix(const Matrix&) = delete;
  Matrix& operator=(const Matrix&) = delete;
  ~Matrix() override;

  void analyze(int order, std::span<int> row, std::span<int> column) override;
  Code factorize(std::span<const double> values) override;
  void solve(std::span<double> b_to_x, int rhs) override { solve(b_to_x, rhs, Transpose::no); }
  void solve(std::span<double> b_to_x, int rhs, Transpose transpose);
  [[nodiscard]] Figures figures() const;        // of the last factorisation, which must be ok; pivot_growth is 0
  [[nodiscard]] double reciprocal_condition();  // an estimate from three solutions, unsymmetric only

 private:
  void call(int job);

  DMUMPS_STRUC_C data_{};
  std::vector<double> values_;  // nnz: MUMPS keeps no copy of the values
  bool structurally_singular_ = false;
};

// Symmetric indefinite, for make_augmented.
[[nodiscard]] std::unique_ptr<SymmetricSolver> make_symmetric();

}  // namespace assur::mumps
