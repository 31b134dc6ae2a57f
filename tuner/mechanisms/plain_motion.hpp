// The motion of a scene by its plain equations: least squares with all of them, including redundant ones, its own
// continuation, and long double for the compared rows. It is slow and simple, and the reference of random tests.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "decompositions.hpp"
#include "mechanisms/plain_equations.hpp"

namespace assur::mechanisms {

// All laws of the equations at time t.
[[nodiscard]] std::vector<TimeJet<Real>> laws_at(const PlainEquations& equations, Real t);

class PlainMotion {
 public:
  // care: steps are at least this many times as short; 1: default.
  explicit PlainMotion(const Scene& scene, int care = 1) : equations_(scene), care_(care) {}

  enum class Start {
    right,
    off_equations,  // an equation of the scene does not hold
    off_law,        // the angle of a driver differs from its law
    singular,       // unknown, because the posture is singular
  };
  // Begins at the posture of a row with all columns, and refines it with the values of the laws there. `figure`: size
  // of the violation.
  Start start(const std::vector<std::string>& columns, const std::vector<double>& row,
              const std::vector<TimeJet<Real>>& laws, double& figure);

  // Begins at the posture as written, with all auxiliary scalars at 0.
  Start start_as_written(const std::vector<TimeJet<Real>>& laws, double& figure);

  // Follows the laws from s = 0 to s = 1; their derivatives are with respect to s. Returns the last s. It is < 1 if the
  // motion ends there, or if two branches cannot be distinguished there; the last good posture is then kept.
  using Laws = std::function<std::vector<TimeJet<Real>>(Real s)>;
  Real advance(const Laws& laws);
  // The same with the laws of the scene, from time t0 to t1.
  Real advance(Real t0, Real t1);

  // Solves velocity and acceleration of the posture in long double, with values, rates and accelerations of the laws.
  // False if it does not converge.
  bool settle(const std::vector<TimeJet<Real>>& laws);

  // Angles to unwrap along the motion. turned() has this order; their values begin in (-pi, pi].
  void follow(std::vector<PlainEquations::Column> angles);
  [[nodiscard]] std::vector<TimeJet<Real>> turned() const;
  // False after its points or directions have met, because the direction of the turn is then unknown.
  [[nodiscard]] bool knows_turns(std::size_t i) const { return !met_[i]; }

  void take_care(int care) { care_ = care; }

  [[nodiscard]] const PlainEquations& equations() const { return equations_; }
  [[nodiscard]] std::vector<TimeJet<Real>> show(std::span<const PlainEquations::Column> columns) const {
    return equations_.show(columns, x_.data());
  }
  // Largest derivative of an unknown; lengths relative to the typical one.
  [[nodiscard]] double scale(int derivative) const;
  // Nearness to a singularity on the way: log of the smallest over the largest volume of the Jacobian.
  [[nodiscard]] double narrowest() const { return least_volume_ - most_volume_; }
  [[nodiscard]] double condition() const { return condition_; }  // of the scaled Jacobian at the last settle()

 private:
  using Vector = Eigen::VectorXd;
  using Input = PlainEquations::Input<double>;
  Start begin(const std::vector<TimeJet<Real>>& laws, double& figure);  // at x_
  // Factorises the Jacobian at x, with rows of length 1 and columns in typical lengths. Returns the log of the product
  // of its singular values.
  double factorise(const Vector& x, const std::vector<TimeJet<Real>>& laws);
  [[nodiscard]] Vector solve(const Vector& residual) const;
  void derivatives(const Vector& x, const std::vector<TimeJet<Real>>& laws, Vector& v, Vector& a) const;
  Vector left(const Vector& x, const std::vector<TimeJet<Real>>& laws) const;
  [[nodiscard]] double size(const Vector& x) const;  // largest unknown, lengths relative to the typical one
  // Unwrapped angles at x; `met`: angles that turned so far that the direction of the turn is unknown.
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

// The rows of a plain motion, with these columns of a trajectory.
class PlainRows {
 public:
  PlainRows(PlainMotion& motion, const std::vector<std::string>& columns);

  // The row of the present posture; NaN: unknown.
  [[nodiscard]] std::vector<Real> now();
  [[nodiscard]] const PlainEquations::Column& column(std::size_t i) const { return columns_[i]; }
  [[nodiscard]] bool is_angle(std::size_t i) const { return angle_[i] >= 0; }  // which is followed over whole turns
  [[nodiscard]] bool knows_turns(std::size_t i) const;
  // Least divisor for the errors of a derivative, from the largest derivatives of unknowns so far.
  [[nodiscard]] double scale(int derivative) const { return scale_[derivative]; }

 private:
  PlainMotion& motion_;
  std::vector<PlainEquations::Column> columns_;
  std::vector<int> angle_;  // of each column: among those that the motion follows
  double scale_[3] = {1, 0, 0};
};

}  // namespace assur::mechanisms
