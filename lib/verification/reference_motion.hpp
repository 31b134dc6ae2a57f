// The motion of a scene in quadruple precision (113 bits), by continuation from the assembled start: the reference for
// forward errors. It shares the equations of the scene with the simulator, but no programs, groups, presolve or
// solvers.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "equations/system.hpp"
#include "graph/blocks.hpp"
#include "plan/preparation.hpp"
#include "verification/quad.hpp"

namespace assur {

// LU in double of a block's Jacobian: dense up to 96 unknowns, sparse beyond.
class ReferenceLu {
 public:
  void compute(const DenseBlock& block, const std::vector<double>& q);
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;  // NaN if singular
  [[nodiscard]] int determinant_sign() const;                           // 0 if singular

 private:
  bool is_dense_ = true;
  Eigen::PartialPivLU<Eigen::MatrixXd> dense_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> sparse_;
};

// The reference of one scene.
class ReferenceMotion {
 public:
  struct State {
    double time = 0;
    std::array<std::vector<Quad>, 3> q;  // value and two derivatives of every coordinate, internal units
    std::vector<int> determinant_sign;   // blocks; 0: not known yet
  };

  // Begins at the start of the scene. Solves only the unknowns that the outputs need. Throws Error (numerical) if the
  // start does not converge.
  explicit ReferenceMotion(const Prepared& prepared);

  // Follows the motion to time t in steps of at most 1/pieces of the way, halved where Newton does not contract or a
  // determinant changes its sign. Throws Error (numerical) that names time and unknowns if the posture is lost.
  void advance(double t, int pieces = 1);

  [[nodiscard]] const System& system() const { return system_; }  // without presolve
  [[nodiscard]] const State& state() const { return state_; }
  void restore(State state) { state_ = std::move(state); }

  // Least divisor of the error of a d-th derivative at the current time, in internal units: 1 for values; for rates the
  // fastest rate w of the driven coordinates; for accelerations the larger one of w^2 and their largest acceleration.
  [[nodiscard]] double scale(int d) const { return scale_[static_cast<std::size_t>(d)]; }

 private:
  struct Block {
    std::span<const Index> equations, unknowns;
    std::vector<Index> forms;  // each once
    bool moves = true;
    double tolerance = 0;  // size of the last correction of the position at which Newton ends
    std::size_t index = 0;
  };

  void find_blocks(const GroupedSystem& structure);
  [[nodiscard]] Block block_of(Index b) const;
  void drive(double t);
  void predict(double t);
  [[nodiscard]] bool step(double t, bool any_sign);
  [[nodiscard]] bool solve(const Block& block, bool any_sign);
  [[nodiscard]] bool approach(const Block& block, const DenseBlock& jacobian);
  void evaluate_forms(const Block& block, int d);
  [[nodiscard]] bool refine(const Block& block, int d);
  [[nodiscard]] Quad equation(Index e, int d) const;
  [[nodiscard]] Quad callback(Index e, int d) const;
  [[noreturn]] void refuse(double t) const;

  System system_;
  Driven driven_;  // inputs that the needed blocks and the outputs read
  Blocks decomposition_;
  std::vector<Block> blocks_;  // those that the outputs need, in solving order
  std::vector<Quad> constants_;
  State state_;
  std::array<std::vector<Quad>, 3> form_;  // derivatives of the forms of the current block
  std::array<double, 3> scale_{1, 0, 0};
  std::vector<double> rounded_;  // state_.q[0] in double
  std::vector<Index> column_;    // scratch of DenseBlock
  ReferenceLu lu_;
  Index lost_ = -1;  // an unknown of the block that failed last
};

}  // namespace assur
