// The rival: the program that a good engineer writes in an afternoon for one mechanism. It uses one global Newton
// iteration in natural coordinates from a Taylor prediction; residuals and Jacobian by hand, straight into compressed
// columns; KLU with block triangular form and its defaults. The matrix is analysed once, and refactorised for each
// iteration and once more for velocity and acceleration. The only part of the library in it is the type Pattern, so
// that its motion is also an independent check of the library.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "bare_calls.hpp"
#include "peers/mechanisms.hpp"

namespace assur::bench {

// The library's bound for a solved equation: |Phi_i| / (sum_j |dPhi_i/dq_j| |q_j| + |constant|).
inline constexpr double kRivalTolerance = 8 * std::numeric_limits<double>::epsilon();

enum class KluOptions {
  defaults,  // klu_defaults: scales rows by their largest entry, accepts diagonal pivots down to 0.001 of the column
  unscaled,  // rows of one mechanism are alike: no scaling, no checks; partial pivoting, as small blocks have no fill
};

// Position, velocity and acceleration of `Mechanism`, which has these members:
//   Pattern pattern() const; void guess(double* q) const;
//   void drive(double t)                                      the known coordinates and their derivatives
//   double evaluate(const double* q, double* phi, double* J)  returns the largest relative residual
//   void velocity(double* b) const                            b = -Phi_h h', at the posture of the last evaluate()
//   void acceleration(const double* v, double* b) const       b = -(Phi_h h'' + d/dt(Phi_q) q')
template <class Mechanism>
class Afternoon {
 public:
  explicit Afternoon(Mechanism mechanism, KluOptions options = {}, double tolerance = kRivalTolerance);

  // Moves to time t. False if Newton's method does not converge or a pivot vanishes: the posture is then useless.
  [[nodiscard]] bool step(double t);

  [[nodiscard]] std::span<const double> position() const { return q_; }
  [[nodiscard]] std::span<const double> velocity() const { return v_; }
  [[nodiscard]] std::span<const double> acceleration() const { return a_; }
  [[nodiscard]] double residual() const { return residual_; }           // relative, of the last step
  [[nodiscard]] std::size_t iterations() const { return iterations_; }  // of the last step

 private:
  Mechanism mechanism_;
  BareKlu solver_;
  double tolerance_, time_ = 0, residual_ = 0;
  std::size_t iterations_ = 0;
  std::vector<double> q_, v_, a_, correction_;  // n
  std::vector<double> jacobian_;                // nnz
};

// sample("four_bar:LOOPS"): unknowns B1 ... B_LOOPS, equations coupler1, rocker1, coupler2, ..., each halved.
class FourBarChain {
 public:
  explicit FourBarChain(int loops);

  [[nodiscard]] Pattern pattern() const;
  void guess(double* q) const;
  void drive(double t);
  [[nodiscard]] double evaluate(const double* q, double* phi, double* jacobian);
  void velocity(double* b) const;
  void acceleration(const double* v, double* b) const;

 private:
  std::size_t loops_;
  double x_ = 0, y_ = 0, vx_ = 0, vy_ = 0, ax_ = 0, ay_ = 0;  // the crank's end B0
  double dx_ = 0, dy_ = 0;                                    // B1 - B0
};

// sample("stewart"): unknowns B1 ... B6, the ends of the handles; three equations for each leg, the distances halved:
// |B - P| = rod, |B - A| = handle, (B - A) . a = 0.
class StewartHandles {
 public:
  StewartHandles();

  [[nodiscard]] Pattern pattern() const;
  void guess(double* q) const;
  void drive(double t);
  [[nodiscard]] double evaluate(const double* q, double* phi, double* jacobian);
  void velocity(double* b) const;
  void acceleration(const double* v, double* b) const;

 private:
  using Vec = peers::Vec;
  struct Leg : peers::Stewart::Leg {
    Vec joint{}, rate{}, acceleration{};  // of P, in the ground
    Vec d{};                              // B - joint at the last evaluate()
  };
  std::array<Leg, 6> legs_;
};

extern template class Afternoon<FourBarChain>;
extern template class Afternoon<StewartHandles>;

}  // namespace assur::bench
