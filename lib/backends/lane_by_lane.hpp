// Base of solvers that treat one lane after the other.
#pragma once

#include <span>
#include <vector>

#include "assur/backend.hpp"

namespace assur {

// Copies each lane out of the pack, calls the library, and copies the result back.
class LaneByLane : public LinearSolver {
 public:
  Status analyze(const Pattern& pattern, int lanes) final;
  Status factorize(std::span<const double> values) final;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) final;
  [[nodiscard]] Figures figures(int lane) const final;

 protected:
  // Calls of the library. The pattern then has nonzeros, all values are finite, and the lane has factors. A single lane
  // is not copied: the spans are those of the caller.
  virtual void analyze_lanes(const Pattern& pattern, int lanes) = 0;
  virtual Code factorize_lane(std::span<const double> values, int lane) = 0;                      // values: nnz
  virtual void solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int lane) = 0;  // n x rhs
  [[nodiscard]] virtual Figures lane_figures(int lane) const = 0;

 private:
  [[nodiscard]] Code take_and_factorize(std::span<const double> values, int lane);

  std::size_t n_ = 0;
  std::vector<double> values_;  // nnz, of one lane
  std::vector<double> right_;   // n x some right-hand sides, of one lane
  std::vector<Code> code_;      // lanes
  Status status_;               // status of the worst lane
};

}  // namespace assur
