// The linear algebra between groups that are solved together, see program/together_step.hpp. Numbers of all groups of
// a class lie side by side: number k of the group at a place is [k stride + place]. Sums are added in the same order on
// every processor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "program/slopes.hpp"

namespace assur {

// Numbers that are brought to neighbouring groups: to[i] = from[step i].
struct Run {
  std::int32_t to, from, count;
  std::int32_t step;  // 0, 1, 2 or 3
};

struct CouplingKernels {
  void (*gather)(std::span<const Run> runs, const double* from, double* to);
  // The other way, with step > 0: from[step i] = to[i].
  void (*scatter)(std::span<const Run> runs, double* from, const double* to);
  // sums = -sum over the entries of slope times source; lanes: a multiple of 8, here and below
  void (*couple)(std::span<const Slopes::Entry> entries, std::size_t first_entry, const double* slopes,
                 const double* sources, std::size_t stride, std::size_t lanes, double* sums);
  // to = own + sum_k columns[k] load_k, for n numbers of each group; loads: rows
  void (*complete)(const double* own, const double* const* columns, const double* loads, std::size_t n, std::size_t rows,
                   std::size_t stride, std::size_t lanes, double* to);
  // to += by
  void (*add)(const double* by, std::size_t n, std::size_t stride, std::size_t lanes, double* to);
  // Not for NaN.
  double (*largest)(const double* of, std::size_t lanes);
  // A chain of loads: loads[i] += gains[i] * loads[i - 1], where `before` is the load before the first one.
  void (*chain)(const double* gains, double before, std::int32_t count, double* loads);
};
[[nodiscard]] const CouplingKernels& coupling_kernels();

}  // namespace assur
