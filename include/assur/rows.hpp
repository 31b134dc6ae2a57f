// Rows of outputs: where an output lies in them, and how a run gives them to a program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace assur {

// Where the components of an output lie in a row, found once by its name, so that a loop looks up no text:
//   const OutputHandle c = find_output(simulator.columns(), "C");
//   const std::span<const double> velocity = c.rate(simulator.outputs());  // vx, vy(, vz) of C
// Rows are Simulator::outputs() and the rows of trajectories with the same columns; their length is not checked.
struct OutputHandle {
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  std::size_t components = 1;  // of a point or vector: the dimension of the scene; of a quaternion: 4; else 1
  // The columns of the first component of value, first and second derivative; kNone: not among the columns.
  std::size_t first[3] = {kNone, kNone, kNone};

  // The value in SI units; empty if it is not among the columns.
  [[nodiscard]] std::span<const double> value(std::span<const double> row) const { return of(row, 0); }
  // The first derivative by time: velocity, rate, angular velocity; empty if it is not among the columns.
  [[nodiscard]] std::span<const double> rate(std::span<const double> row) const { return of(row, 1); }
  // The second derivative by time; empty if it is not among the columns.
  [[nodiscard]] std::span<const double> acceleration(std::span<const double> row) const { return of(row, 2); }

 private:
  [[nodiscard]] std::span<const double> of(std::span<const double> row, std::size_t d) const {
    return first[d] == kNone ? std::span<const double>() : row.subspan(first[d], components);
  }
};

// Finds an output among columns: a point, vector, measure or scalar by its name ("C", "rocker_angle", "B.origin"), or
// "B.quaternion", "B.angular_velocity" and "B.angle" of a body B. The angular velocity in space is a rate without a
// value, and its acceleration the angular acceleration. Throws Error (input), with the known columns, if no column
// belongs to it, or if some of its components are missing.
[[nodiscard]] OutputHandle find_output(const std::vector<std::string>& columns, std::string_view output);

// Where the pose of a body lies in a row, see find_body().
struct BodyHandle {
  OutputHandle origin;      // of the frame of the body, m
  OutputHandle quaternion;  // in space: w, x, y, z; rotates local into ground coordinates
  OutputHandle turn;        // in space: angular velocity and acceleration; in the plane: the angle, rad
};

// Finds the pose of a body that is an output ("B"; docs/joints.md#poses-of-bodies). Throws Error (input) like
// find_output().
[[nodiscard]] BodyHandle find_body(const std::vector<std::string>& columns, std::string_view body);

// Memory of stored rows. Large rows lie on large pages, if the system has them; the pages of small rows are mapped at
// once. Mapping a small page at the first write to it takes 1 us, on a virtual machine 13 us, often longer than a step.
struct RowAllocator {
  using value_type = double;
  template <class>
  struct rebind {
    using other = RowAllocator;
  };
  // Uninitialised numbers. Throws std::bad_alloc if there is no memory.
  [[nodiscard]] double* allocate(std::size_t count);
  void deallocate(double* numbers, std::size_t count) noexcept;
  friend bool operator==(RowAllocator, RowAllocator) = default;
};
using RowValues = std::vector<double, RowAllocator>;

// Which rows stream() gives, of a Simulator or an Ensemble.
struct RowSelection {
  std::vector<std::string> columns = {};                        // empty: all
  std::size_t every = 1;                                        // every n-th row, beginning with the first; at least 1
  std::size_t block = std::numeric_limits<std::size_t>::max();  // most rows that are given at once; at least 1
};

// Rows of one member of an ensemble, or of a simulator, in SI units.
struct MemberRows {
  std::size_t member = 0;          // counted from 0; 0 for a simulator
  std::span<const double> times;   // of the rows, s
  std::span<const double> values;  // rows x columns
};
// Called on the calling thread while a run goes on, with the number of rows (a Fleet: linkages) that are done and of
// all; returns true to stop the run. It must not change what runs.
using Observer = std::function<bool(std::int64_t done, std::int64_t of)>;

// Takes rows. They are valid within the call.
using RowSink = std::function<void(const MemberRows& rows)>;

}  // namespace assur
