// The one interface of a linear solver: analyze once, factorize often, solve many; square systems, batched over the
// lanes of a pack from the start. To add a backend: one file in lib/backends and one row in registry.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/status.hpp"

namespace assur {

// Sparsity of a square matrix in compressed sparse columns; rows ascend within each column, no duplicates.
struct Pattern {
  std::int32_t n = 0;
  std::vector<std::int32_t> column_start;  // n + 1
  std::vector<std::int32_t> row;           // nnz

  [[nodiscard]] std::int32_t nnz() const { return static_cast<std::int32_t>(row.size()); }
};

// What a group costs.
struct Shape {
  std::int32_t n = 0;       // unknowns
  std::int32_t nnz = 0;     // nonzeros of its Jacobian
  std::int32_t groups = 1;  // groups of the class
  std::int32_t rhs = 1;     // right-hand sides of one factorisation

  friend bool operator==(const Shape&, const Shape&) = default;
};

// Threads that a call may use; handed down, never global.
struct ThreadBudget {
  std::int32_t threads = 1;
};

enum class Transpose : std::uint8_t { no, yes };

// Health of the last factorisation of one lane.
struct Figures {
  bool ok = false;                  // false: singular, or not finite
  double pivot_growth = 0;          // max |U| / max |A|, columnwise maximum for klu's reciprocal growth
  double reciprocal_condition = 0;  // a cheap estimate: min |u_ii| / max |u_ii|; 0 if singular
  int determinant_sign = 0;         // -1, 0, +1
};

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Once for each pattern. values and right-hand sides are interleaved: values[k * lanes + lane].
  [[nodiscard]] virtual Status analyze(const Pattern& pattern, int lanes) = 0;

  // values: nnz x lanes, in the order of pattern.row. The status is that of the worst lane; `where` is the lane.
  [[nodiscard]] virtual Status factorize(std::span<const double> values) = 0;

  // b_to_x: n x rhs x lanes, in place: element i of right-hand side r in lane l is b_to_x[(r * n + i) * lanes + l].
  // Unknowns before first_wanted are not needed: a backend that can stop its back-substitution there leaves them
  // unspecified. A lane whose factorisation failed gets NaN.
  [[nodiscard]] virtual Status solve(std::span<double> b_to_x, int rhs, Transpose transpose = Transpose::no,
                                     int first_wanted = 0) = 0;

  [[nodiscard]] virtual Figures figures(int lane) const = 0;
};

// One row of the table of solvers.
struct Backend {
  std::string_view id;                                  // stored in the database: never renamed
  std::string (*why_not)(const Shape&, ThreadBudget);   // "" if it can run here and now
  std::unique_ptr<LinearSolver> (*make)(ThreadBudget);  // call only if why_not() is ""
  bool steady;                                          // allocates nothing after the first factorisation
  bool keeps_pivots;         // starts from those of its last matrix: one solver for each pack
  std::string_view licence;  // SPDX identifier of the library behind it
  std::string (*version)();  // of the library behind it; "" if absent
};

// Every backend of this build, present or absent, in the order of registry.cpp. In assur::assur.
[[nodiscard]] std::span<const Backend> backends();

// The backends that assur::core brings with it.
[[nodiscard]] std::span<const Backend> core_backends();

// The row with this id in `table`; throws Error (input) that lists the ids if there is none.
[[nodiscard]] const Backend& find_backend(std::span<const Backend> table, std::string_view id);

}  // namespace assur
