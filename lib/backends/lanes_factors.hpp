// A program, its kernels and the numbers that they work on.
#pragma once

#include <memory>
#include <span>
#include <utility>

#include "assur/backend.hpp"
#include "backends/lanes_buffer.hpp"
#include "backends/lanes_kernels.hpp"
#include "backends/lanes_order.hpp"
#include "backends/lanes_program.hpp"

namespace assur::lanes {

// Pivots within their rows, from the sparsest to the safest; where one does not keep growth within bounds the next is
// tried.
inline constexpr PivotRule kRules[] = {{.threshold = 0.1}, {.threshold = 0.5}, {.threshold = 1}, {.rook = true}};

// Limits for matrices of order n. Backward errors stay below n eps where the rows of the factors, multiplied, are up to
// `growth` times those of the matrix.
[[nodiscard]] Limits limits(std::int32_t n, Precision precision);

class Factors {
 public:
  Factors(int lanes, Precision precision);

  // The factors of the last program are lost. Takes memory; nothing else here does.
  void set_program(std::shared_ptr<const Program> program);
  [[nodiscard]] const std::shared_ptr<const Program>& program() const { return program_; }

  [[nodiscard]] Alarms factorize(std::span<const double> values, const Limits& limits) {
    return kernels_.factorize(*program_, values.data(), slots_.get(), limits);
  }
  void solve(double* b_to_x, int rhs, Transpose transpose, int first_wanted);
  [[nodiscard]] Figures figures(int lane) const;

 private:
  int lanes_;
  Precision precision_;
  Kernels kernels_;
  std::shared_ptr<const Program> program_;
  Buffer slots_, work_;
};

}  // namespace assur::lanes
