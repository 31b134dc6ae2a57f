// Yardsticks: the true motion of a case, which is computed once and compared with the trajectories of all strategies.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "check/closed_forms.hpp"
#include "equations/outputs.hpp"
#include "plan/preparation.hpp"

namespace assur::check {

// Rows of the true motion; SI units, in the order of the columns of trajectories. NaN: unknown.
class TrueMotion {
 public:
  virtual ~TrueMotion() = default;
  // Row k at time t; to be called in order. Throws Error (numerical) if the motion is unknown there.
  virtual std::vector<long double> row(std::size_t k, double t) = 0;
  // Row k again by smaller steps, if a trajectory is on another branch.
  virtual std::vector<long double> row_again(std::size_t k, double t) { return row(k, t); }
  // True if the whole turns of the angle in that column are known in the last row. If not, whole turns are ignored from
  // that row on.
  [[nodiscard]] virtual bool knows_turns(std::size_t) const { return false; }
  // Least divisor for the errors of a derivative of an output at rest (SI units of a scalar without dimension).
  [[nodiscard]] virtual double scale(int derivative) const { return derivative == 0 ? 1 : 0; }
};

// The motion in quadruple precision; null if this build has none. Throws Error (numerical) if it cannot start.
[[nodiscard]] std::unique_ptr<TrueMotion> reference_motion(const Prepared& prepared);

// The motion by all plain equations, also redundant ones. They share nothing with the equations of the library. Throws
// Error (numerical) if the start posture violates an equation, or if the angle of a driver differs from its law.
[[nodiscard]] std::unique_ptr<TrueMotion> plain_motion(const Prepared& prepared);

[[nodiscard]] std::unique_ptr<TrueMotion> known_motion(const Prepared& prepared, ClosedForm closed_form);

// The motion of one run, with which the other runs are compared.
[[nodiscard]] std::unique_ptr<TrueMotion> agreed_motion(const Trajectory& trajectory);

class Yardstick {
 public:
  // preparation(prepared).structure must outlive it.
  Yardstick(const Prepared& prepared, std::unique_ptr<TrueMotion> motion);

  // Largest error of the outputs and derivatives in the first `rows` rows, defined like ForwardError: max |x - x_true|
  // over max |x_true| (values: at least one internal unit). Rows that `counts` excludes affect only the divisor.
  // Infinite if a number is not finite, or if no number could be compared; 0 for no rows.
  using Counts = std::function<bool(std::size_t row)>;
  [[nodiscard]] double forward_error(const Trajectory& trajectory, std::size_t rows, const Counts& counts = {});

 private:
  struct Figure {
    long double difference = 0, size = 0;
  };
  // One output and derivative: columns, and least divisor.
  struct Item {
    std::size_t first, count;
    int derivative;
    double unit;
    bool angle;                                                         // true: the value of a signed angle
    std::size_t turns_known = std::numeric_limits<std::size_t>::max();  // of an angle: rows with known whole turns
    std::vector<std::pair<std::size_t, double>> angles = {};            // of a sum: items and factors
  };
  // Whole turns, rad, between the angle of a run and that of a true motion whose turns are unknown.
  [[nodiscard]] long double turns(const Item& item, const Trajectory& trajectory, std::size_t row) const;
  [[nodiscard]] Figure compare(const Item& item, const Trajectory& trajectory, std::size_t row) const;
  void add_row(const Trajectory& trajectory);
  [[nodiscard]] bool is_far(const Trajectory& trajectory, std::size_t row) const;

  std::shared_ptr<const GroupedSystem> structure_;
  std::unique_ptr<TrueMotion> motion_;
  std::vector<Item> items_;
  std::vector<std::vector<long double>> rows_;  // rows so far
  std::optional<Error> lost_;  // reason why there are no further rows; kept, because another try may take long
  bool apart_ = false;         // a trajectory is on another branch
};

}  // namespace assur::check
