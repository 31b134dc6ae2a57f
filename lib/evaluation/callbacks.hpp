// Evaluates the callbacks of a class: in SI units, lane after lane.
#pragma once

#include <vector>

#include "equations/system.hpp"
#include "evaluation/coefficients.hpp"

namespace assur {

// Registers and coefficients are those of the evaluator: register i of lane l is x[i * lanes + l].
class CallbackRows {
 public:
  CallbackRows(const System& system, const GroupClass& group_class, int lanes);

  [[nodiscard]] bool empty() const { return class_.callbacks.empty(); }

  // To be called first at each posture; the other functions are for the same coefficients and values.
  void residuals(const double* coefficients, const double* value, double* phi);
  // Adds the derivatives of the callbacks to the entries of the Jacobian.
  void jacobian(const double* coefficients, const double* value, double* jacobian);
  // scale += |dPhi/dx| |x|
  void scale(const double* coefficients, const double* value, double* scale);
  // scale >= kLeastFactor |dPhi/dx|, internal units
  void raise_scale(const double* coefficients, const double* value, double* scale);
  // rhs -= dPhi/dx rate
  void rates(const double* coefficients, const double* value, const double* rate, double* rhs);
  // rhs -= d/dt(dPhi/dx) rate
  void curvature(const double* coefficients, const double* value, const double* rate, double* rhs);

 private:
  struct Scratch {
    std::vector<double> x, rate;   // arguments
    std::vector<double> phi;       // rows
    std::vector<double> jacobian;  // lanes x rows x arguments
  };
  [[nodiscard]] const CallbackBlock& block(const GroupClass::CallbackUse& use) const;
  void load(const GroupClass::CallbackUse& use, const double* constants, const double* from, int lane,
            std::vector<double>& x) const;
  void matrix(const double* coefficients, const double* value);
  [[nodiscard]] double derivative(std::size_t use, std::int32_t row, std::int32_t argument, int lane) const;
  template <class Use>
  void for_each_argument(Use&& use_it) const;

  const System& system_;
  const GroupClass& class_;
  int lanes_;
  std::vector<Scratch> scratch_;  // one for each use
  std::vector<double> least_;     // equations x lanes: of raise_scale()
  bool knows_matrix_ = false;     // Scratch::jacobian is that of the posture
};

}  // namespace assur
