// What a run is measured against: the true motion, once for each case, for the trajectories of all strategies.
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
#include "scene/outputs.hpp"

namespace assur::check {

// Rows of the true motion; SI units, in the order of the trajectory's columns. NaN: not known.
class TrueMotion {
 public:
  virtual ~TrueMotion() = default;
  // Row k at time t, asked in order. Throws Error (numerical) if it is not known that far.
  virtual std::vector<long double> row(std::size_t k, double t) = 0;
  // Of row k once more, where a trajectory is on another branch: followed in smaller steps.
  virtual std::vector<long double> row_again(std::size_t k, double t) { return row(k, t); }
  // Of the angle in that column, in the row that was asked for last. False: it is compared but for whole turns, from
  // there on.
  [[nodiscard]] virtual bool knows_turns(std::size_t) const { return false; }
  // What a derivative of an output that rests is measured against (SI units of a scalar without dimension).
  [[nodiscard]] virtual double scale(int derivative) const { return derivative == 0 ? 1 : 0; }
};

// In quad precision; null if this build has none. Throws Error (numerical) if it cannot be started.
[[nodiscard]] std::unique_ptr<TrueMotion> reference_motion(const Prepared& prepared);

// By plain equations that share nothing with the library's, redundant ones included. Throws Error (numerical) if the
// start posture meets not all of them, or a driver's angle is not that of its law.
[[nodiscard]] std::unique_ptr<TrueMotion> plain_motion(const Prepared& prepared);

[[nodiscard]] std::unique_ptr<TrueMotion> known_motion(const Prepared& prepared, ClosedForm closed_form);

// That of one run, for the others to be compared with.
[[nodiscard]] std::unique_ptr<TrueMotion> agreed_motion(const Trajectory& trajectory);

class Yardstick {
 public:
  // Keeps the scene's outputs: prepared.structure must live on.
  Yardstick(const Prepared& prepared, std::unique_ptr<TrueMotion> motion);

  // The worst over outputs and derivatives of the first `rows` rows, as ForwardError has it: max |x - x_true| over max
  // |x_true| (values: one internal unit at least). Rows that do not count add to the second maximum only. Infinite for
  // what is not finite, and if nothing in the rows could be compared; 0 for no rows.
  using Counts = std::function<bool(std::size_t row)>;
  [[nodiscard]] double forward_error(const Trajectory& trajectory, std::size_t rows, const Counts& counts = {});

 private:
  struct Figure {
    long double difference = 0, size = 0;
  };
  // One output and derivative: columns, and what it is measured against at least.
  struct Item {
    std::size_t first, count;
    int derivative;
    double unit;
    bool angle;                                                         // the value of one that has a sign
    std::size_t turns_known = std::numeric_limits<std::size_t>::max();  // an angle: rows
    std::vector<std::pair<std::size_t, double>> angles = {};            // of a sum: items and factors
  };
  // Whole turns, in rad, by which a run counts an angle otherwise than the true motion does, which cannot know.
  [[nodiscard]] long double turns(const Item& item, const Trajectory& trajectory, std::size_t row) const;
  [[nodiscard]] Figure compare(const Item& item, const Trajectory& trajectory, std::size_t row) const;
  void add_row(const Trajectory& trajectory);
  [[nodiscard]] bool is_far(const Trajectory& trajectory, std::size_t row) const;

  std::shared_ptr<const Structure> structure_;
  std::unique_ptr<TrueMotion> motion_;
  std::vector<Item> items_;
  std::vector<std::vector<long double>> rows_;  // those asked for so far
  std::optional<Error> lost_;                   // why there are no more: not tried again, which may take long
  bool apart_ = false;                          // a trajectory is on another branch
};

}  // namespace assur::check
