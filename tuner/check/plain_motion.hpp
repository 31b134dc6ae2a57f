// The motion of a scene by its plain equations: least squares with all of them, redundant ones included, its own
// continuation, and long double where rows are compared. Slow and simple; what the random search holds runs against.
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <string>
#include <vector>

#include "check/plain_equations.hpp"

namespace assur::check {

class PlainMotion {
 public:
  // care: 1, or how many times as short the steps are at least.
  explicit PlainMotion(const Scene& scene, int care = 1) : equations_(scene), care_(care) {}

  enum class Start {
    right,
    off_equations,  // an equation of the scene is not met there
    off_law,        // an angle driver's own angle is not that of its law
    singular,       // nothing can be said: the posture is singular
  };
  // Takes up the posture that a row shows, all columns given, polishes it with the laws' values there. `figure`: by how
  // much something is off.
  Start start(const std::vector<std::string>& columns, const std::vector<double>& row,
              const std::vector<TimeJet<Real>>& laws, double& figure);

  // Follows the laws, given over s = 0 ... 1 with their derivatives by s, to s = 1. Returns how far it came: < 1 where
  // the motion ends (or cannot be told apart from another one), and then the posture of before is kept.
  using Laws = std::function<std::vector<TimeJet<Real>>(Real s)>;
  Real advance(const Laws& laws);

  // Velocity and acceleration at the posture, with the laws' values, rates and accelerations there; in long double.
  // False if nothing converges.
  bool settle(const std::vector<TimeJet<Real>>& laws);

  // Angles to be unwrapped along the way; turned() in this order, from (-pi, pi] at the start.
  void follow(std::vector<PlainEquations::Column> angles);
  [[nodiscard]] Real turned(std::size_t i) const;
  // False once its points or directions met on the way, where it turns round either way.
  [[nodiscard]] bool knows_turns(std::size_t i) const { return !met_[i]; }

  void take_care(int care) { care_ = care; }

  [[nodiscard]] const PlainEquations& equations() const { return equations_; }
  [[nodiscard]] TimeJet<Real> show(const PlainEquations::Column& column) const;
  // Largest derivative of an unknown, lengths over the typical one.
  [[nodiscard]] double scale(int derivative) const;
  // How near the way came to a singularity: log of the smallest volume of the Jacobian over the largest one.
  [[nodiscard]] double narrowest() const { return least_volume_ - most_volume_; }
  [[nodiscard]] double condition() const { return condition_; }  // of the Jacobian, scaled, where it was settled last

 private:
  using Vector = Eigen::VectorXd;
  using Input = PlainEquations::Input<double>;
  // Of the Jacobian at x: rows of length 1, columns in typical lengths; log of the product of its singular values.
  double factorise(const Vector& x, const std::vector<TimeJet<Real>>& laws);
  [[nodiscard]] Vector solve(const Vector& residual) const;
  void derivatives(const Vector& x, const std::vector<TimeJet<Real>>& laws, Vector& v, Vector& a) const;
  Vector left(const Vector& x, const std::vector<TimeJet<Real>>& laws) const;
  [[nodiscard]] double size(const Vector& x) const;  // max over the unknowns, lengths over the typical one
  // Their angles there, unwrapped; `met`: those that turned so far that they may have gone either way round.
  bool unwrap(const Vector& x, std::vector<Real>& turned, std::vector<bool>& met) const;

  PlainEquations equations_;
  int care_;
  std::vector<TimeJet<Real>> x_;  // the posture
  std::vector<PlainEquations::Column> angles_;
  std::vector<Real> turned_;
  std::vector<bool> met_;
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
  Vector row_scale_, column_scale_;
  double stride_ = 0.25;
  double least_volume_ = 0, most_volume_ = 0;
  double condition_ = 0;
};

}  // namespace assur::check
