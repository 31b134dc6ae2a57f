// Motions as HDF5: the data set `t` (rows), and one data set for each output, of rows or of members x rows. Rows that a
// member did not reach are NaN.
#pragma once

#include <iosfwd>
#include <string>

#include "assur/ensemble.hpp"
#include "assur/simulator.hpp"

namespace assur::output {

// Why this build cannot write HDF5; "": it can.
[[nodiscard]] std::string why_no_hdf5();

// The file is made in memory. If writing to `out` fails, its state says so. Throws Error (environment) if there is no
// memory for the file.
void write_hdf5(std::ostream& out, const Trajectory& motion, const NpyOptions& how);
void write_hdf5(std::ostream& out, const EnsembleTrajectory& motion, const NpyOptions& how);

}  // namespace assur::output
