// Sines, cosines and angles side by side, in the SIMD target of the machine.
#pragma once

#include <cstddef>
#include <cstdint>

#include "program/law_step.hpp"

namespace assur {

inline constexpr std::size_t kAngleBlock = 8;  // arrays of angles are padded to a multiple of it
[[nodiscard]] constexpr std::size_t padded(std::size_t angles) {
  return (angles + kAngleBlock - 1) / kAngleBlock * kAngleBlock;
}

// Harmonic terms of eight laws in consecutive slots: amplitude * sin(2 pi frequency t + phase).
struct HarmonicBlock {
  double frequency[kAngleBlock] = {};
  double phase[kAngleBlock] = {};      // |phase| <= kLargestAngle
  double amplitude[kAngleBlock] = {};  // 0: no term
  double omega[kAngleBlock] = {};      // 2 pi frequency
  std::int32_t slot = 0;               // of the first
};

// The vectors that define signed angles, at one posture: arrays of numbers, padded.
struct Arms {
  double *x, *y;
  double *square, *chord;  // squares of the length, and of the way of the end in the last step
  double* speed;           // chord over the square of the step's duration; negative: unknown
};

// The kernels.
struct AngleKernels {
  // Sines and cosines, within 1 unit in the last place (2 if the result is below 2^-30); NaN if the angle is not
  // finite. Arrays: count, padded; the padding of the results is arbitrary.
  void (*sin_cos)(const double* angles, std::size_t count, double* sines, double* cosines);

  // Angles of directions (x, y), within 1 unit in the last place; NaN if both are zero. Arrays: count, padded.
  void (*angles)(const double* y, const double* x, std::size_t count, double* angles);

  // Adds the terms at time t, and their derivatives, to the slots.
  void (*add_harmonics)(const HarmonicBlock* blocks, std::size_t count, double t, double* values, double* rates,
                        double* accelerations);

  // Counting turns, see AngleTurns. Computes the squares and chords of the vectors `next`, a time `seconds` after
  // `now`. True if no vector strays: the turns of all are known. bends: how far each may leave its way, squared;
  // strays: receives 0 or 1 for each. Arrays: count, padded.
  bool (*follow)(std::size_t count, const Arms& now, const Arms& next, double seconds, const double* bends,
                 double* strays);
  // Moves `now` there, and adds the turns.
  void (*turn)(std::size_t count, const Arms& now, const Arms& next, double seconds, double* turns);
};

[[nodiscard]] const AngleKernels& angle_kernels();

}  // namespace assur
