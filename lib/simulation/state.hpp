// The posture at hand, the last accepted one, and the older ones that the predictor reads.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "simulation/lane_kernels.hpp"
#include "simulation/predictor.hpp"

namespace assur {

class State {
 public:
  // Coordinates [0, first_unknown) are known at any time; [first_unknown, size) are solved for.
  void resize(std::size_t first_unknown, std::size_t size, const Predictor& predictor);

  // d-th derivative of every coordinate.
  [[nodiscard]] double* at(int d) { return values_[d].data(); }
  [[nodiscard]] const double* at(int d) const { return values_[d].data(); }

  void clear();
  // Unknowns of the next posture, from the accepted ones.
  void predict(double t);
  // Largest move, over `count` unknowns from an address on, from the last accepted posture to the prediction.
  [[nodiscard]] double predicted_move(std::size_t address, std::size_t count) const;
  void accept(double t);
  // The older postures: the next prediction is from the last accepted one alone.
  void forget();
  // The next prediction is the last accepted posture itself.
  void stand_still();
  // Unknowns of the last accepted posture.
  void restore();
  // Where no velocities are computed: those of the unknowns from the last two accepted postures.
  void estimate_rates();

 private:
  const LaneKernels& kernels_ = lane_kernels(1);
  Predictor predictor_;
  std::size_t first_unknown_ = 0;
  std::size_t depth_ = 1;  // postures that the predictor reads
  int levels_ = 1;         // derivatives that it reads, and the value
  std::vector<double> values_[3];
  std::vector<double> last_[3];                              // unknowns only
  std::vector<std::array<std::vector<double>, 3>> history_;  // depth - 1 older ones, newest first
  std::vector<double> times_;                                // of last_ and history_
};

}  // namespace assur
