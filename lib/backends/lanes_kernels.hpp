// The inner loops, compiled for several instruction sets: they run an Elimination over interleaved lanes.
#pragma once

#include <cstdint>

#include "assur/backend.hpp"
#include "backends/backends.hpp"
#include "backends/lanes_elimination.hpp"

namespace assur::lanes {

// Limits of a lane for each row, in 2-norms. A row whose square under- or overflows (below 1e-150 or above 1e150; in
// float 1e-18, 1e18) exceeds them.
struct Limits {
  double growth;    // of |row of L and, undivided, of U| * the largest |row of U| so far, over |row of A|
  double pivot;     // least pivot over |row of A|
  double smallest;  // least pivot
};

// Bit l is set if lane l exceeds a limit.
struct Alarms {
  std::uint32_t growth = 0, pivot = 0;

  [[nodiscard]] std::uint32_t any() const { return growth | pivot; }
};

// For one number of lanes and one precision. Arrays of the solver: slots (program.slots x lanes) and work
// (kRightSides x n x lanes), in that precision and aligned to 64 bytes; those of the caller in double.
struct Kernels {
  Alarms (*factorize)(const Elimination& program, const double* values, void* slots, const Limits& limits);
  void (*solve)(const Elimination& program, const void* slots, double* b_to_x, int rhs, int first_wanted, void* work);
  void (*solve_transposed)(const Elimination& program, const void* slots, double* b_to_x, int rhs, void* work);
};

// The fastest kernels for this processor; lanes: 1, 2, 4, 8 or 16.
[[nodiscard]] Kernels kernels(int lanes, Precision precision);

// The instruction set of kernels(), e.g. "AVX3".
[[nodiscard]] const char* instruction_set();

}  // namespace assur::lanes
