// The interface of all linear solvers: analyze once, factorize often, solve many. Systems are square, and each call
// treats all lanes of a pack: up to W systems of one pattern, side by side in SIMD lanes. docs/extending.md explains
// how to add a backend.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/machine.hpp"
#include "assur/status.hpp"

namespace assur {

// Sparsity of a square matrix in compressed sparse columns. Rows ascend within each column, without duplicates.
struct Pattern {
  std::int32_t n = 0;                      // order of the matrix
  std::vector<std::int32_t> column_start;  // n + 1: index into `row` of the first nonzero of each column, then nnz
  std::vector<std::int32_t> row;           // nnz: row of each nonzero, 0 to n - 1

  // Number of nonzeros.
  [[nodiscard]] std::int32_t nnz() const { return static_cast<std::int32_t>(row.size()); }
  friend bool operator==(const Pattern&, const Pattern&) = default;
};

// Size of the systems of a class, and the operation counts that predict their cost. The counts are 0 where no plan
// needs them; fill, operations and depth assume Markowitz pivots.
struct Shape {
  std::int32_t n = 0;           // unknowns of one group, or order of one matrix
  std::int32_t nnz = 0;         // nonzeros of the Jacobian
  std::int32_t groups = 1;      // groups of the class, or number of matrices
  std::int32_t rhs = 1;         // right-hand sides that are solved with each factorisation
  std::int64_t fill = 0;        // nonzeros of L + U
  std::int64_t operations = 0;  // multiplications and divisions of one factorisation
  std::int64_t depth = 0;       // longest chain of dependent rows in forward plus that in backward substitution
  std::int64_t terms = 0;       // terms of the compiled equations of a group; 0: a bare matrix
  std::uint64_t pattern = 0;    // hash (64-bit FNV-1a) of the sparsity pattern; 0: not computed
  bool one_program = false;     // the step of a group can be one program, not a sequence of evaluations and solutions

  friend bool operator==(const Shape&, const Shape&) = default;
};

// Arithmetic of the factors: double or float. Values and right-hand sides are double in both cases. Solutions with
// factors in float have the accuracy of float; strategies with +float refine them.
enum class Precision : std::uint8_t { binary64, binary32 };

// Solve A x = b, or with the transposed matrix.
enum class Transpose : std::uint8_t { no, yes };

// Quality of the last factorisation of one lane. A figure that the library behind a backend does not report is 0.
struct Figures {
  bool ok = false;                  // false if the matrix is singular or not finite
  double pivot_growth = 0;          // max |U| / max |A|; of the scaled matrix if the backend scales rows
  double reciprocal_condition = 0;  // a cheap estimate, at most min |u_ii| / max |u_ii|; 0 if singular
  int determinant_sign = 0;         // -1 or +1; 0 if singular
};

// Extra work of a solver since analyze(), beyond the requested factorisations and solutions.
struct Effort {
  std::int64_t redone = 0;     // lanes factorised with their own pivots, because the common pivots failed
  std::int64_t renewed = 0;    // new pivot orders
  std::int64_t refined = 0;    // steps of iterative refinement, counted for each lane
  std::int64_t unplanned = 0;  // steps among `refined` that no setting requested, because pivots had grown
  std::int64_t in_double = 0;  // lanes factorised in double, because refinement from float did not converge

  // Adds each figure.
  Effort& operator+=(const Effort& o) {
    redone += o.redone;
    renewed += o.renewed;
    refined += o.refined;
    unplanned += o.unplanned;
    in_double += o.in_double;
    return *this;
  }
};

inline constexpr std::int32_t kMostLanes = 16;  // largest number of lanes

// Direct solver for square systems with one sparsity pattern, for several lanes at once. Call analyze(), factorize()
// and solve() in this order; another order is not detected. One thread at a time may use a solver. Values and
// right-hand sides are interleaved: number k of a lane is at [k * lanes + lane].
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  // Prepares for matrices of this pattern; call it once, before factorize(). Returns ok: factorize() reports singular
  // patterns. lanes: a power of two up to kMostLanes. Throws Error (input) for other lanes, or if the pattern is not as
  // Pattern describes.
  [[nodiscard]] virtual Status analyze(const Pattern& pattern, int lanes) = 0;

  // Factorises one matrix in each lane. values: nnz x lanes, in the order of pattern.row. The status is that of the
  // worst lane, which Status::where names: `not_finite` before `singular`, then the lowest lane. Throws Error (input)
  // for another number of values.
  [[nodiscard]] virtual Status factorize(std::span<const double> values) = 0;

  // Solves with the factors of the last factorize(). b_to_x: n x rhs x lanes, overwritten by the solution; element i of
  // right-hand side r in lane l is b_to_x[(r * n + i) * lanes + l]. Unknowns before first_wanted are not needed: a
  // backend that can stop its back-substitution there leaves them unspecified. A lane whose factorisation failed gets
  // NaN and keeps its status; a refinement may end as not_converged. Throws Error (input) for another size of b_to_x.
  [[nodiscard]] virtual Status solve(std::span<double> b_to_x, int rhs, Transpose transpose = Transpose::no,
                                     int first_wanted = 0) = 0;

  // Quality of the last factorisation of a lane, 0 to lanes - 1.
  [[nodiscard]] virtual Figures figures(int lane) const = 0;

  // Extra work since analyze().
  [[nodiscard]] virtual Effort effort() const { return {}; }

  // Makes this solver as it was after analyze(), without taking memory. False: a new solver must be made instead.
  [[nodiscard]] virtual bool restart() { return false; }

  // Another solver for the same pattern and lanes, which shares analysis and pivot order with this one. Null if a new
  // solver would be as good.
  [[nodiscard]] virtual std::unique_ptr<LinearSolver> clone() const { return nullptr; }
};

// One row of the table of solvers: functions and properties.
struct Backend {
  std::string_view id;  // name in strategies and databases; never changes
  // The reason if the backend cannot solve systems of this shape with these threads here; "" if it can.
  std::string (*why_not)(const Shape&, ThreadBudget);
  // Makes a solver. Call it only if why_not() is "", and with binary32 only if `single` is set.
  std::unique_ptr<LinearSolver> (*make)(ThreadBudget, Precision);
  std::string (*version)();  // version of the library behind the backend; "" if the library is absent
  std::string_view licence;  // SPDX identifier of the licence of that library
  // The reason if that library is slower here than it could be, with a remedy; "" if it is not. Null: unknown.
  std::string (*slowed)() = nullptr;

  bool dense = false;         // stores every entry, whatever the pattern
  bool single = false;        // can factorise in float
  bool steady = false;        // allocates no memory after the first factorisation
  bool keeps_pivots = false;  // starts from the pivots of its last matrix, so that each pack needs its own solver
  bool fills_lanes = false;   // solves all lanes at once; other backends solve them one after the other
  bool threads = false;       // may use several threads in one factorisation
  bool takes_turns = false;   // allows one call at a time in a process, so that several threads gain nothing
  bool device = false;        // computes on a GPU, to and from which each call copies matrices and vectors
  bool own_loops = false;     // its inner loops are compiled with assur, so that times change with the version of assur
};

// All backends that this version knows, including those that were not built, in a fixed order. Valid until the program
// ends. Needs the library assur::assur.
[[nodiscard]] std::span<const Backend> backends();

// The backends of the library assur::core, which are always built: `eigen` and `lanes`.
[[nodiscard]] std::span<const Backend> core_backends();

// The row with this id in `table`. Throws Error (input), with a list of the ids, if there is no such row.
[[nodiscard]] const Backend& find_backend(std::span<const Backend> table, std::string_view id);

}  // namespace assur
