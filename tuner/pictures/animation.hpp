// A page on which a mechanism moves: it needs nothing but itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "pictures/drawing.hpp"
#include "pictures/quantities.hpp"

namespace assur::pictures {

// The same scene, with the positions of all points among its outputs.
[[nodiscard]] Scene with_all_points(const Scene& scene);

// Collects what a simulator of with_all_points(scene) shows, step after step.
class Animation {
 public:
  // `wanted`: with the outputs that can be plotted; `shown`: with all points, too. `steps`: of the motion, of which
  // evenly thinned ones become frames. Throws what drawing_of() does.
  Animation(const Prepared& wanted, const Prepared& shown, std::int64_t steps);

  // Where there is no motion because `refused` cannot be assembled: the guess and the closest posture to be had, the
  // constraints that it violates in red. Throws what drawing_of() does.
  Animation(const Scene& scene, const Structure& refused);

  // After each step k = 0, 1, ..., `steps`.
  void take(std::int64_t k, const Simulator& simulator);
  // Where the motion ended before its last step, maybe between two steps; `why`: "t = 1.3 s, group C: ...".
  void end(const Simulator& simulator, std::string why);

  // `about`: sentences on how it was computed.
  [[nodiscard]] std::string page(const std::vector<std::string>& about) const;

  [[nodiscard]] std::size_t frames() const { return times_.size(); }

 private:
  void keep(const Simulator& simulator);
  [[nodiscard]] std::string data() const;
  [[nodiscard]] std::vector<std::string> notes() const;

  std::string name_;
  Drawing drawing_;
  std::vector<Quantity> shown_;             // that can be plotted
  std::size_t quantities_ = 0;              // that there are
  std::vector<std::size_t> point_columns_;  // of the moving points: moving x dimension
  std::vector<std::size_t> value_columns_;  // of what is shown
  std::int64_t steps_ = 0, stride_ = 1, last_ = 0;
  std::string ended_;                  // a sentence; empty: the motion is whole
  std::vector<std::string> postures_;  // names instead of times; empty: times
  std::vector<std::string> violated_;  // constraints
  std::vector<double> times_;
  std::vector<double> points_;  // frames x moving x dimension
  std::vector<double> values_;  // frames x value_columns_
};

}  // namespace assur::pictures
