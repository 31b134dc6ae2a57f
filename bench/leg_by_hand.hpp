// One leg of the Stewart platform, group SG_HS with its 15 coordinates B, e, r, c, d, written by hand in plain C++.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "assur/backend.hpp"
#include "peers/mechanisms.hpp"

namespace assur::bench {

using peers::Vec;

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
  // jacobian: in the order of pattern().
  void evaluate(const Unknowns& q, Unknowns& phi, double* jacobian);
  // scale_i = sum_j |dPhi_i/dq_j| |q_j| + |constant|
  void scale(const Unknowns& q, Unknowns& scale) const;
  // b = -Phi_h h' and b = -(Phi_h h'' + d/dt(Phi_q) q'), at the posture of the last evaluate().
  void velocity(const Terminal& rate, Unknowns& b);
  void acceleration(const Unknowns& v, const Terminal& acceleration, Unknowns& b) const;

  // All moving quantities that the equations read: the unknowns, P and t.
  using Reads = std::array<double, kUnknowns + 6>;
  [[nodiscard]] Reads reads(const Unknowns& q) const;
  // Lipschitz constants of the rows of the Jacobian in the maximum norm: the number of products in each row; squares
  // count once.
  static constexpr Unknowns kLipschitz = {0, 0, 0, 0, 0, 0, 0, 6, 3, 6, 6, 3, 3, 3, 3};

 private:
  Vec A_, a_, local_P_, local_t_;
  Vec P_{}, t_{}, t_rate_{}, c_{};
  Vec P_scale_{};  // |O| + |local| |u, v|
};

}  // namespace assur::bench
