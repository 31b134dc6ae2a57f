// One leg of the Stewart platform, group SG_HS with its 15 coordinates B, e, r, c, d, written by hand in plain C++:
// what groups/klu and groups/lapack would be without a library around the library.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "assur/backend.hpp"

namespace assur::bench {

using Vec = std::array<double, 3>;

// O, u, v of the terminal, and their first or second derivative.
struct Terminal {
  Vec O, u, v;
};

// Equations in this order: handle_length (3), hinge, rod_length (3), c_across_rod, cardan, d_across_rod, d_across_c,
// |e| = |r| = |c| = |d| = 1, each halved.
class LegByHand {
 public:
  static constexpr std::size_t kUnknowns = 15;
  using Unknowns = std::array<double, kUnknowns>;

  // A, a: point and axis of the handle on the ground; P, t: joint and cardan axis in the plane of u and v.
  LegByHand(const Vec& A, const Vec& a, const Vec& P, const Vec& t) : A_(A), a_(a), local_P_(P), local_t_(t) {}

  [[nodiscard]] static Pattern pattern();

  void set_inputs(const Terminal& value);
  // Returns the largest |phi|; jacobian: in the order of pattern().
  double evaluate(const Unknowns& q, Unknowns& phi, double* jacobian);
  // b = -Phi_h h' and b = -(Phi_h h'' + d/dt(Phi_q) q'), at the posture of the last evaluate().
  void velocity(const Terminal& rate, Unknowns& b);
  void acceleration(const Unknowns& v, const Terminal& acceleration, Unknowns& b) const;

 private:
  Vec A_, a_, local_P_, local_t_;
  Vec P_{}, t_{}, t_rate_{}, c_{};
};

}  // namespace assur::bench
