// The one interface of a linear solver: analyze once, factorize often, solve many; square systems, batched over the
// lanes of a pack from the start. How to add a backend: docs/extending.md.
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
  // Counted for a plan, else 0; the first three with Markowitz pivots.
  std::int64_t fill = 0;        // nonzeros of L + U
  std::int64_t operations = 0;  // multiplications of a factorisation
  std::int64_t depth = 0;       // rows that wait for each other in a solution, forward and backward
  std::int64_t terms = 0;       // of the equations; 0: a bare matrix
  std::uint64_t pattern = 0;    // a number that only equal patterns have

  friend bool operator==(const Shape&, const Shape&) = default;
};

// Threads that a call may use; handed down, never global.
struct ThreadBudget {
  std::int32_t threads = 1;
};

// What a solver factorises and solves in. Values and right-hand sides are double either way.
enum class Precision : std::uint8_t { binary64, binary32 };

enum class Transpose : std::uint8_t { no, yes };

// Health of the last factorisation of one lane.
struct Figures {
  bool ok = false;  // false: singular, or not finite
  // What a library does not tell is 0, also where ok is true.
  double pivot_growth = 0;          // max |U| / max |A|, where a backend scales rows: of the scaled matrix
  double reciprocal_condition = 0;  // a cheap estimate, at most min |u_ii| / max |u_ii|; 0 if singular
  int determinant_sign = 0;         // -1, +1; 0 if singular
};

// What a solver did beyond plain factorisations and solutions, in all since analyze().
struct Effort {
  std::int64_t redone = 0;     // lanes factorised with pivots of their own, because those of the class did not serve
  std::int64_t renewed = 0;    // pivot orders chosen anew
  std::int64_t refined = 0;    // steps of iterative refinement
  std::int64_t unplanned = 0;  // of those: nobody asked for them, but the factors of the lane had grown
  std::int64_t in_double = 0;  // lanes factorised in double, because float did not converge

  Effort& operator+=(const Effort& o) {
    redone += o.redone;
    renewed += o.renewed;
    refined += o.refined;
    unplanned += o.unplanned;
    in_double += o.in_double;
    return *this;
  }
};

inline constexpr std::int32_t kMostLanes = 16;  // solved side by side: a power of two

class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Once for each pattern. values and right-hand sides are interleaved: values[k * lanes + lane].
  [[nodiscard]] virtual Status analyze(const Pattern& pattern, int lanes) = 0;

  // values: nnz x lanes, in the order of pattern.row. The status is that of the worst lane, which `where` names.
  [[nodiscard]] virtual Status factorize(std::span<const double> values) = 0;

  // b_to_x: n x rhs x lanes, in place: element i of right-hand side r in lane l is b_to_x[(r * n + i) * lanes + l].
  // Unknowns before first_wanted are not needed: a backend that can stop its back-substitution there leaves them
  // unspecified. A lane whose factorisation failed gets NaN.
  [[nodiscard]] virtual Status solve(std::span<double> b_to_x, int rhs, Transpose transpose = Transpose::no,
                                     int first_wanted = 0) = 0;

  [[nodiscard]] virtual Figures figures(int lane) const = 0;

  [[nodiscard]] virtual Effort effort() const { return {}; }

  // Another solver for the same pattern and lanes, which shares what no longer changes (analysis, pivot order); null
  // where a new one is as good.
  [[nodiscard]] virtual std::unique_ptr<LinearSolver> clone() const { return nullptr; }
};

// One row of the table of solvers.
struct Backend {
  std::string_view id;                                 // stored in the database: never renamed
  std::string (*why_not)(const Shape&, ThreadBudget);  // "" if it can run here and now
  // Call only if why_not() is "", with binary32 only where `single` is set.
  std::unique_ptr<LinearSolver> (*make)(ThreadBudget, Precision);
  std::string (*version)();  // of the library behind it; "" if absent
  std::string_view licence;  // SPDX identifier of that library
  // Why that library is slower than it could be here, and what helps; "" if it is not. Null: nobody knows.
  std::string (*slowed)() = nullptr;

  bool dense = false;         // stores every entry, whatever the pattern
  bool single = false;        // can factorise in float
  bool steady = false;        // allocates nothing after the first factorisation
  bool keeps_pivots = false;  // starts from those of its last matrix: one solver for each pack
  bool fills_lanes = false;   // solves the lanes of a pack side by side: others take one after the other
  bool threads = false;       // may use several threads in one factorisation
  bool takes_turns = false;   // one call at a time in a process: other threads wait and gain nothing
  bool own_loops = false;     // its inner loops are compiled with assur, and change with it
};

// Every backend of this build, present or absent, in the order of registry.cpp. In assur::assur.
[[nodiscard]] std::span<const Backend> backends();

// The backends that assur::core brings with it.
[[nodiscard]] std::span<const Backend> core_backends();

// The row with this id in `table`; throws Error (input) that lists the ids if there is none.
[[nodiscard]] const Backend& find_backend(std::span<const Backend> table, std::string_view id);

}  // namespace assur
