// The loops of a group step over the W lanes of a pack, in the SIMD target of the machine. All arrays are [row][lane].
// Idle lanes repeat lane 0, so that a maximum over all lanes is the maximum over the used lanes. If a number is NaN,
// the result is NaN.
#pragma once

#include <cstddef>
#include <cstdint>

#include "evaluation/input_row.hpp"

namespace assur {

// A Jacobian by rows: row r has entries [row_start[r], row_start[r + 1]).
struct RowEntry {
  std::int32_t nonzero, column;
};

// The kernels for one W.
struct PackKernels {
  // out = sum of weights * sources, elementwise.
  void (*combine)(const double* const* sources, const double* weights, std::int32_t count, std::size_t size,
                  double* out);

  // out[i] = state[addresses[i]] for rows x W addresses.
  void (*gather)(const InputRow* rows, const std::int32_t* addresses, std::int32_t count, const double* state,
                 double* out);

  // The same for several arrays: states and outs have `orders` of them.
  void (*gather_all)(const InputRow* rows, const std::int32_t* addresses, std::int32_t count,
                     const double* const* states, double* const* outs, std::int32_t orders);

  // out[i]: the largest number of row i
  void (*row_maxima)(const double* numbers, std::int32_t rows, double* out);

  // True if every number lies between those in its place of `least` and `most`; false for NaN.
  bool (*between)(const double* numbers, std::int32_t rows, const double* least, const double* most);

  // True if the size of every number in the rows from these addresses on is at most that in its place of `most`.
  bool (*at_most)(const double* numbers, const std::int32_t* addresses, std::int32_t rows, const double* most);

  // Replaces each scale by 1 / scale, or by 1 if it is not positive or NaN.
  void (*invert_scale)(double* scale, std::int32_t count);

  // out: W, max |phi| * inverse_scale
  void (*largest_ratios)(const double* phi, const double* inverse_scale, std::int32_t count, double* out);

  // x -= correction over the unknowns of one block; largest: W, |correction|. Returns the largest of all.
  double (*correct)(const std::int32_t* unknowns, std::int32_t count, const double* correction, double* x,
                    double* largest);

  // residual = b - J x; returns the largest |residual| / (|J| |x| + |b|) of a lane, maximum norms. norm: W, |J|;
  // `measure` computes it first.
  double (*residual)(const std::int32_t* row_start, const RowEntry* entries, std::int32_t n, const double* jacobian,
                     const double* x, const double* b, double* residual, double* norm, bool measure);

  // The used part of a ball: omega * max |coordinate - anchor|; used: W. Coordinates below n are unknowns, the others
  // inputs.
  void (*ball_use)(const std::int32_t* coordinates, std::int32_t count, std::int32_t n, const double* unknowns,
                   const double* inputs, const double* anchor, const double* omega, double* used);
};

// lanes: 1, 2, 4, 8 or 16.
[[nodiscard]] const PackKernels& pack_kernels(int lanes);

}  // namespace assur
