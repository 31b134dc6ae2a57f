// A self-contained page on which a mechanism moves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "pictures/drawing.hpp"
#include "pictures/quantities.hpp"

namespace assur::pictures {

// The same scene, with the positions of all points and the directions of all vectors among its outputs, except points
// that no equation determines, such as a point off the line about which a rod turns freely.
[[nodiscard]] Scene with_all_places(const Scene& scene);

// Collects the postures of a simulator of with_all_places(scene), step after step.
class Animation {
 public:
  // `wanted` has the outputs to plot; `shown` has all points and vectors as well. `steps`: number of steps, of which
  // evenly spaced ones become frames. Draws no point that `shown` does not have. Throws like drawing_of().
  Animation(const Prepared& wanted, const Prepared& shown, std::int64_t steps);

  // For a scene whose structure `refused` cannot be assembled: shows the guess and the closest posture, with violated
  // constraints in red. Throws like drawing_of().
  Animation(const Scene& scene, const Structure& refused);

  // To be called after each step k = 0, 1, ..., `steps`.
  void take(std::int64_t k, const Simulator& simulator);
  // To be called if the motion ended early, possibly between two steps. `why`: "t = 1.3 s, group C: ...".
  void end(const Simulator& simulator, std::string why);

  // The page. `about`: sentences about the computation.
  [[nodiscard]] std::string page(const std::vector<std::string>& about) const;

  // The motion as SVG, see moving_picture.hpp.
  [[nodiscard]] std::string picture() const;

  [[nodiscard]] std::size_t frames() const { return times_.size(); }

 private:
  void keep(const Simulator& simulator);
  [[nodiscard]] std::string data() const;
  [[nodiscard]] std::vector<std::string> notes() const;

  std::string name_;
  Drawing drawing_;
  std::vector<Quantity> shown_;             // quantities to plot
  std::size_t quantities_ = 0;              // number of all quantities
  std::vector<std::size_t> point_columns_;  // of the moving points: moving x dimension
  std::vector<std::size_t> way_columns_;    // of the moving directions: as many x dimension
  std::vector<std::size_t> value_columns_;  // of the shown quantities
  std::int64_t steps_ = 0, stride_ = 1, last_ = 0;
  std::string ended_;                  // a sentence; empty: the motion is complete
  std::vector<std::string> postures_;  // names instead of times; empty: times
  std::vector<std::string> violated_;  // constraints
  std::vector<double> times_;
  std::vector<double> points_;  // frames x moving x dimension
  std::vector<double> ways_;    // frames x way_columns_
  std::vector<double> values_;  // frames x value_columns_
};

// Moves a simulator of with_all_places() over `times` (s) and collects its postures. proceed(k): asked before the step
// to times[k], k = 1, 2, ...; false ends the motion as interrupted.
[[nodiscard]] Animation animation_of(const Prepared& wanted, Simulator& simulator, std::span<const double> times,
                                     const std::function<bool(std::int64_t k)>& proceed);

}  // namespace assur::pictures
