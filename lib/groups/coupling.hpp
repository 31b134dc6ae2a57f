// The linear algebra between groups that are solved together, see program/together_step.hpp. Numbers of all groups of
// a class lie side by side: number k of the group at a place is [k stride + place]. lanes: places, a multiple of 8.
// Sums are added in the same order on every processor.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluation/lane_array.hpp"
#include "program/together_step.hpp"

namespace assur {

// to[i] = from[step i]
struct Run {
  std::int32_t to, from, count;
  std::int32_t step;  // 0 or 1
};

// Where inputs are found that other groups compute.
struct InputSources {
  static constexpr std::int32_t kNone = -1;  // address: no group computes this input
  // How the addresses of eight lanes follow each other.
  enum class Kind : std::uint8_t { none, neighbours, some_neighbours, apart };
  struct Eight {
    std::int32_t first = 0;  // address of the first lane, if it follows from that of others
    Kind kind = Kind::none;
  };

  std::size_t lanes = 0;
  std::vector<std::int32_t> addresses;  // inputs x lanes
  LaneArray computed;                   // inputs x lanes: 1 if a group computes the input, else 0
  std::vector<Eight> eights;            // inputs x lanes / 8

  InputSources() = default;
  // Eight numbers before and behind those at the addresses may be read.
  InputSources(std::vector<std::int32_t> of, std::size_t in_lanes);
};

struct CouplingKernels {
  void (*copy)(std::span<const Run> runs, const double* from, double* to);
  // to[input stride + lane]; lanes whose input is not computed stay as they are
  void (*gather)(const InputSources& sources, const double* numbers, std::size_t stride, double* to);
  // to[j stride + i] = from[n i + j], and back
  void (*part)(const double* from, std::size_t n, std::size_t count, std::size_t stride, double* to);
  void (*join)(const double* from, std::size_t n, std::size_t count, std::size_t stride, double* to);
  // sums = sum over the entries of coupling times the number of its source; couplings: entries x stride
  void (*couple)(const InputSources& sources, std::span<const Couplings::Coupling> entries, const double* couplings,
                 std::size_t stride, const double* numbers, double* sums);
  // to = own + sum_k columns[k] load_k, for n numbers of each group; loads: rows
  void (*complete)(const double* own, const double* const* columns, const double* loads, std::size_t n,
                   std::size_t rows, std::size_t stride, std::size_t lanes, double* to);
  // to += by
  void (*add)(const double* by, std::size_t n, std::size_t stride, std::size_t lanes, double* to);
  // Not for NaN.
  double (*largest)(const double* of, std::size_t lanes);
  // A chain of loads: loads[i] += gains[i] * loads[i - 1], where `before` is the load before the first one.
  void (*chain)(const double* gains, double before, std::int32_t count, double* loads);
};
[[nodiscard]] const CouplingKernels& coupling_kernels();

}  // namespace assur
