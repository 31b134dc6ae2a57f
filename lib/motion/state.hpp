// The current posture, the last accepted one, and the older ones that the predictor reads.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "evaluation/lane_array.hpp"
#include "groups/pack_kernels.hpp"
#include "motion/predictor.hpp"

namespace assur {

// Postures of one continuation.
class State {
 public:
  // Allocates. Coordinates [0, first_unknown) are known, [first_unknown, size) are unknowns.
  void resize(std::size_t first_unknown, std::size_t size, const Predictor& predictor);

  // Allocates no memory if both have the same sizes.
  void copy(const State& from);
  // True if the other state has the same sizes, so that it can be copied.
  [[nodiscard]] bool is_like(const State& other) const;

  // d-th derivative of every coordinate of the current posture; valid until the next predict() or restore(). After
  // predict(), the unknowns have values but no derivatives.
  [[nodiscard]] double* at(int d) { return ring(d).at_hand(); }
  [[nodiscard]] const double* at(int d) const { return ring(d).at_hand(); }

  // The same of the last accepted posture.
  [[nodiscard]] const double* accepted(int d) const { return ring(d).at(last()); }

  void clear();
  // Begins the next posture: predicts its unknowns from the accepted postures.
  void predict(double t);
  // The same in parts for several threads: begin_prediction(), then predict() for ranges of all unknowns(). The weights
  // behind `count`, up to weights(), are 0 if the time alone is given.
  struct Prediction {
    const double* sources[kMostWeights];
    double weights[kMostWeights];
    std::int32_t count = 0;
  };
  void begin_prediction(double t, Prediction& out);
  // The most weights that it has.
  [[nodiscard]] std::uint32_t weights() const {
    return static_cast<std::uint32_t>(depth_) * static_cast<std::uint32_t>(levels_);
  }
  // A prediction by the Taylor series of the last accepted posture, up to the first or second derivative; for the
  // second by the predictor if it reads all derivatives itself.
  void begin_expansion(double t, Prediction& out, int derivatives = 2);
  // A prediction by a polynomial through accepted postures that save_history() collected, newest first.
  struct PostureHistory {
    static constexpr std::size_t kMost = 4;  // postures: a cubic
    std::array<LaneArray, kMost> postures;
    std::array<double, kMost> times{};
    std::size_t count = 0;
  };
  void reserve(PostureHistory& history) const;
  void save_history(PostureHistory& history) const;
  void begin_prediction(const PostureHistory& history, double t, Prediction& out);
  void predict(const Prediction& prediction, std::size_t begin, std::size_t end);
  [[nodiscard]] std::size_t unknowns() const { return size_ - first_unknown_; }
  // Largest change from the last accepted posture to the prediction, over `count` unknowns from an address on.
  [[nodiscard]] double predicted_move(std::size_t address, std::size_t count) const;
  // The same from the last accepted posture to the current one, over all unknowns: the length of the way.
  [[nodiscard]] double move() const;
  // Length of the rates of the unknowns.
  [[nodiscard]] double speed() const;
  // Seconds in which the known coordinates move by their rounding; 0 if they rest.
  [[nodiscard]] double time_of_rounding() const;
  void accept(double t);
  // Forgets the older postures: the next prediction uses the last accepted one alone.
  void forget();
  // The next prediction is the last accepted posture itself.
  void stand_still();
  // Returns to the last accepted posture, including its known coordinates.
  void restore();
  // Replaces the last accepted posture by the current one.
  void replace();
  // Makes the known coordinates of all postures equal to those of the current one.
  void spread_known();

 private:
  // One derivative of the postures by age; 0: the newest. A posture stays in its place when it becomes older.
  struct Ring {
    std::array<LaneArray, kMostPostures + 1> postures;  // `count` of them
    std::size_t count = 1, newest = 0;

    [[nodiscard]] std::size_t place(std::size_t age) const {
      const std::size_t i = newest + age;
      return i < count ? i : i - count;
    }
    [[nodiscard]] double* at_hand() { return postures[newest].data(); }
    [[nodiscard]] const double* at_hand() const { return postures[newest].data(); }
    [[nodiscard]] double* at(std::size_t age) { return postures[place(age)].data(); }
    [[nodiscard]] const double* at(std::size_t age) const { return postures[place(age)].data(); }
  };
  [[nodiscard]] Ring& ring(int d) { return rings_[static_cast<std::size_t>(d)]; }
  [[nodiscard]] const Ring& ring(int d) const { return rings_[static_cast<std::size_t>(d)]; }
  // Age of the last accepted posture: 0 until another one is begun.
  [[nodiscard]] std::size_t last() const { return begun_ ? 1 : 0; }
  void begin();

  const PackKernels* kernels_ = &pack_kernels(1);
  Predictor predictor_;
  WeightsOfEqualSteps weights_;
  std::size_t first_unknown_ = 0;
  std::size_t size_ = 0;
  std::size_t depth_ = 1;  // postures that the predictor reads
  int levels_ = 1;         // number of derivatives that it reads, including the value
  std::array<Ring, 3> rings_;
  bool begun_ = true;          // the newest posture is not accepted
  std::vector<double> times_;  // of the accepted postures, newest first
};

}  // namespace assur
