// Runs the program of a class over the W lanes of a pack. All arrays are [slot][lane]: slot i of lane l is x[i * W +
// l].
#pragma once

#include <memory>
#include <span>

#include "equations/system.hpp"
#include "evaluation/coefficients.hpp"

namespace assur {

class Evaluator {
 public:
  virtual ~Evaluator() = default;

  // Sets the inputs of a step: computes the parts of the forms that do not depend on the unknowns. coefficients: see
  // bind_coefficients().
  virtual void set_inputs(const double* coefficients, const double* inputs) = 0;

  // Evaluates equations and Jacobian. phi: equations; jacobian: nnz of the pattern, or null.
  virtual void evaluate(const double* unknowns, double* phi, double* jacobian) = 0;

  // scale_i = sum_j |dPhi_i/dq_j| |q_j| + |constant|, at the posture of the last evaluate().
  virtual void scale(double* scale) = 0;

  // Raises scales, which are those of scale() or zeros, to the lower bound that residual_scale() explains.
  virtual void raise_scale(double* scale) = 0;

  // A bound, in units of epsilon / 2, for the rounding error of each Phi_i at the posture of the last evaluate(). The
  // posture is taken as exact, because differences of neighbours far from the origin are exact.
  virtual void rounding(double* bound) = 0;

  // -Phi_h h', at the posture of the last evaluate().
  virtual void velocity_rhs(const double* input_rates, double* rhs) = 0;

  // -(Phi_h h'' + d/dt(Phi_q) q'), after velocity_rhs() with the same rates.
  virtual void acceleration_rhs(const double* unknown_rates, const double* input_accelerations, double* rhs) = 0;

  // Changes of the unknowns and of the inputs.
  struct Change {
    double *unknowns, *inputs;
  };
  // out -= times * Phi''[a, b], at the posture of the last evaluate(). With callbacks, a and b are unspecified
  // afterwards. bent: one number for each equation, unspecified afterwards
  virtual void subtract_bend(const Change& a, const Change& b, double times, double* bent, double* out) = 0;
};

// lanes: 1, 2, 4, 8 or 16. `system` gives the callbacks; it and `group_class` must outlive the evaluator.
[[nodiscard]] std::unique_ptr<Evaluator> make_evaluator(const System& system, const GroupClass& group_class, int lanes);

}  // namespace assur
