// Proves computed postures, block after block in solving order (newton_kantorovich.hpp). The radii of a block bound the
// inputs of later blocks. The equations are those of the scene before presolve; drivers are evaluated in quadruple
// precision with error bounds, residuals in quadruple precision.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assur/simulator.hpp"
#include "equations/system.hpp"
#include "graph/blocks.hpp"
#include "groups/ball.hpp"
#include "groups/newton_kantorovich.hpp"
#include "verification/quad.hpp"

namespace assur {

// Proofs for one plan.
class Certifier {
 public:
  // Throws Error (input) if the plan was loaded: the scene is needed.
  explicit Certifier(const Preparation& prepared);

  // posture: all coordinates of Preparation::structure->system, internal units, computed for time t.
  [[nodiscard]] Certificate certify(std::span<const double> posture, double t);

  // Balls that contain the true value of each coordinate at the last posture; the radius is infinite if nothing is
  // proven. Middles of unknowns are their values in the posture, middles of driven coordinates the rounded true values.
  [[nodiscard]] const std::vector<Ball<double>>& coordinates() const { return at_; }
  [[nodiscard]] const System& system() const { return system_; }

 private:
  void find_blocks(const GroupedSystem& structure);
  void drive(double t);
  void take_unknowns(std::span<const double> posture);
  // Encloses the unknowns of a block. If there is no proof and first_reason is empty, it becomes the reason.
  SolutionProof enclose(Index block, std::string& first_reason);
  [[nodiscard]] std::string why_out_of_reach(Index block) const;
  void number_columns(Index block);
  [[nodiscard]] ProofEquations equations_of(Index block) const;
  [[nodiscard]] Eigen::VectorXd curvature(Index block, const Eigen::VectorXd& radius) const;

  std::shared_ptr<const GroupedSystem> structure_;
  std::vector<std::string> controlled_;
  System system_;  // without presolve
  Blocks blocks_;
  std::vector<Index> needed_;  // blocks, in solving order
  Driven driven_;
  std::vector<Ball<double>> at_;    // coordinates
  std::vector<Ball<Quad>> middle_;  // coordinates: the middles of at_, exact
  std::vector<Index> read_;         // coordinates that the current block reads: its unknowns, then its inputs
  std::vector<Index> column_;       // coordinates: place in read_, -1: none
};

}  // namespace assur
