// An Elimination with its kernels and its numbers.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "assur/backend.hpp"
#include "backends/lanes_elimination.hpp"
#include "backends/lanes_kernels.hpp"
#include "backends/lanes_order.hpp"
#include "parallel/cache_line.hpp"

namespace assur::lanes {

// Pivot rules from the sparsest to the safest factors. If growth exceeds its limit with one rule, the next is tried.
inline constexpr PivotRule kRules[] = {
    {.threshold = 0.1, .shallow = true}, {.threshold = 0.1}, {.threshold = 0.5}, {.threshold = 1}, {.rook = true}};

// Limits for matrices of order n. One rounding in the product of the rows of L and U, whose size is `growth`, makes a
// backward error of growth * eps / 2: at most 8 n eps. Measured: at most 2.0 n eps, with entries that oscillate with
// different phases, n = 2 to 720, 3.9 million lanes of which a quarter were redone.
[[nodiscard]] Limits limits(std::int32_t n, Precision precision);

class Factors {
 public:
  Factors(int lanes, Precision precision);

  // Takes the memory for any Elimination of up to kMostReserved unknowns.
  void reserve(std::int32_t n);
  // Replaces the Elimination and drops its factors. Allocates memory unless it is reserved.
  void set_program(std::shared_ptr<const Elimination> program);
  // Drops the Elimination and its factors.
  void forget() { program_ = nullptr; }
  [[nodiscard]] const std::shared_ptr<const Elimination>& program() const { return program_; }

  [[nodiscard]] Alarms factorize(std::span<const double> values, const Limits& limits) {
    return kernels_.factorize(*program_, values.data(), slots_.data(), limits);
  }
  void solve(double* b_to_x, int rhs, Transpose transpose, int first_wanted);
  [[nodiscard]] bool finite() const;  // true if all factors of all lanes are finite
  [[nodiscard]] Figures figures(int lane) const;

 private:
  [[nodiscard]] std::size_t bytes_of_slot() const;
  [[nodiscard]] const void* slots() const { return slots_.data(); }

  int lanes_;
  Precision precision_;
  Kernels kernels_;
  std::shared_ptr<const Elimination> program_;
  std::vector<std::byte, LineAllocator<std::byte>> slots_, work_;  // doubles or floats
};

}  // namespace assur::lanes
