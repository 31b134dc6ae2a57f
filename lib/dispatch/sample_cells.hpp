// Samples by cell: those of one cell measure the same work.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "assur/performance.hpp"

namespace assur {

// The parts of a strategy on which the time of a kernel depends. Solvers differ by backend, precision and threads; W is
// separate, so that another W can stand in.
struct SolverVariant {
  std::int32_t backend = 0;  // its number in CellNumbers; -1: unknown
  bool single = false, refine = false, once = false, separate = false, together = false;
  Reuse reuse = Reuse::fresh;
  std::int32_t q = 1, lanes = 1;

  friend auto operator<=>(const SolverVariant&, const SolverVariant&) = default;
};

// The parts of a shape on which the time of a kernel depends.
struct KernelShape {
  std::uint64_t pattern;
  std::int64_t terms;
  std::int32_t n, nnz, groups, rhs;
  bool one_program;

  friend auto operator<=>(const KernelShape&, const KernelShape&) = default;
};

[[nodiscard]] KernelShape kernel_shape(Kernel kernel, const Shape& shape);

struct SampleCell {  // samples of one cell measure the same work
  Kernel kernel;
  std::int32_t variant, shape;  // their numbers

  friend bool operator==(const SampleCell&, const SampleCell&) = default;
  friend auto operator<=>(const SampleCell& a, const SampleCell& b) { return a.rank() <=> b.rank(); }

 private:
  // Samples are fewer than 2^28.
  [[nodiscard]] std::uint64_t rank() const {
    return static_cast<std::uint64_t>(kernel) << 56 | static_cast<std::uint64_t>(variant) << 28 |
           static_cast<std::uint64_t>(shape);
  }
};

// Numbers of all variants and shapes of some samples, in their own order, so that the order of samples does not matter.
struct CellNumbers {
  [[nodiscard]] SolverVariant variant_of(Kernel kernel, const Strategy& strategy) const;
  // -1: no sample has this variant.
  [[nodiscard]] std::int32_t number_of(const SolverVariant& variant) const;
  [[nodiscard]] const KernelShape& shape_at(const SampleCell& cell) const {
    return shapes[static_cast<std::size_t>(cell.shape)];
  }

  // Backends of the registry and of all samples, in alphabetical order; a variant has the place in this list, from 1.
  std::vector<std::string> backends;
  std::map<SolverVariant, std::int32_t> variants;
  std::vector<KernelShape> shapes;  // ascending
};

// The figures of a cell with one of its samples, for fitting.
struct GatheredCell {
  SampleCell cell;
  const Sample* example;
  double seconds = 0, noise = 0, backward_error = 0;

  friend bool operator<(const GatheredCell& a, const SampleCell& b) { return a.cell < b; }
};
using GatheredCells = std::vector<GatheredCell>;  // ascending

// What threads cost each other. By the number of threads p.
struct ThreadCosts {
  std::map<std::int32_t, std::vector<double>> meetings;                // s
  std::map<std::int32_t, std::vector<double>> handovers;               // s for each double
  std::map<std::int32_t, std::map<std::int32_t, double>> contentions;  // by n: factor for each of p busy threads
};

struct GatheredSamples {
  CellNumbers numbers;
  GatheredCells cells;  // without meetings, crowds and whole steps
  ThreadCosts threads;
  std::map<KernelShape, std::vector<PerformanceModel::MeasuredStep>> steps;
};

// Takes the median of repeated measurements that scatter little; leaves out impossible ones. Examples point into
// `samples`.
[[nodiscard]] GatheredSamples gather(const std::vector<Sample>& samples);

}  // namespace assur
