// Proves computed postures, block after block in solving order: see newton_kantorovich.hpp. The radii of a block are
// the box of inputs of those behind it. The equations are the scene's own, before presolve; drivers are evaluated in
// quad with bounds of their error, residuals in quad.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assur/simulator.hpp"
#include "group/ball.hpp"
#include "group/newton_kantorovich.hpp"
#include "scene/system.hpp"
#include "structure/blocks.hpp"

namespace assur {

class Certifier {
 public:
  // Throws Error (input) if the plan was loaded: the scene is needed.
  explicit Certifier(const Prepared& prepared);

  // posture: all coordinates of Prepared::structure->system, internal units, computed for time t.
  [[nodiscard]] Certificate certify(std::span<const double> posture, double t);

  // Around the true value of each coordinate at the last posture; the radius is infinite where nothing is proven.
  // Middles of unknowns are those of the posture, middles of driven coordinates the rounded true values.
  [[nodiscard]] const std::vector<Ball<double>>& coordinates() const { return at_; }
  [[nodiscard]] const System& system() const { return system_; }

 private:
  using Quad = boost::multiprecision::cpp_bin_float_quad;

  void find_blocks(const Structure& structure);
  void drive(double t);
  void take_unknowns(std::span<const double> posture);
  // Encloses the block's unknowns; the first block without a proof says why.
  SolutionProof enclose(Index block, std::string& first_reason);
  [[nodiscard]] std::string why_out_of_reach(Index block) const;
  void number_columns(Index block);
  [[nodiscard]] QuadraticEquations equations_of(Index block) const;
  [[nodiscard]] Eigen::VectorXd curvature(Index block, const Eigen::VectorXd& radius) const;

  std::shared_ptr<const Structure> structure_;
  std::vector<std::string> controlled_;
  System system_;  // without presolve
  Blocks blocks_;
  std::vector<Index> needed_;  // blocks, in solving order
  Driven driven_;
  std::vector<Ball<double>> at_;    // coordinates
  std::vector<Ball<Quad>> middle_;  // coordinates: the middles of at_, exact
  std::vector<Index> read_;         // coordinates that the block at hand reads: its unknowns, then its inputs
  std::vector<Index> column_;       // coordinates: place in read_, -1: none
};

}  // namespace assur
