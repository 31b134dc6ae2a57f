// Data sets of linkages as HDF5: one row for each linkage whose motion is complete.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assur/curve.hpp"
#include "assur/fleet.hpp"
#include "sweep/random_linkage.hpp"

namespace assur::sweep {

// What makes a data set; a file is continued only by the same.
struct LinkageSet {
  std::uint64_t seed = 0;
  JointCounts joints;
  std::vector<double> times;         // s
  bool single = true;                // curves are stored in single precision
  std::int64_t first = 0, last = 0;  // samples from the first up to, without, the last
  std::vector<PlanePoint> target;    // paths are compared with it; empty: none
};

// Samples that are done.
struct LinkageCounts {
  std::int64_t samples = 0, rows = 0, jammed = 0, not_closed = 0, inaccurate = 0;
};

// One row.
struct LinkageRow {
  std::int64_t sample = 0;
  Linkage linkage;
  CurveFrame frame;
  double error = 0;               // estimated, as LinkageMotion::error
  double distance = 0;            // shape_distance() from the target
  std::vector<PlanePoint> curve;  // in its normal place, one point for each time
};

// Data sets of N rows, J joints and T times. Unused joints are 0.
//   sample (N), joints (N); kind, left (N, J), parents (N, J, 2), values (N, J, 3): as LinkageJoint, with the numbers
//   of its kinds; times (T); curves (N, T, 2), in their normal places; center (N, 2), radius (N), angle (N): as
//   CurveFrame; error (N); with a target: distance (N), target (M, 2)
// Attributes of the file: seed, fewest_joints, most_joints, first_sample, last_sample, and LinkageCounts.
class LinkageFile {
 public:
  // Creates the file, or continues it after the last rows that were flushed. Throws Error: input if the file was made
  // by another set or is none; environment if it cannot be written, or if HDF5 is missing.
  LinkageFile(const std::string& name, const LinkageSet& set);
  ~LinkageFile();

  [[nodiscard]] const LinkageCounts& counts() const;
  // Sample and distance of all rows; empty without a target.
  [[nodiscard]] std::vector<std::pair<std::int64_t, double>> distances() const;
  // Appends rows and flushes the file. `more`: the samples that they were taken from; its number of rows is ignored.
  // Throws Error (environment) if the file cannot be written.
  void append(std::span<const LinkageRow> rows, const LinkageCounts& more);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace assur::sweep
