// The files into which a command writes the rows of a motion: CSV, NumPy's .npy, HDF5.
#pragma once

#include <string>

#include "assur/ensemble.hpp"
#include "assur/simulator.hpp"
#include "output/replace_file.hpp"

namespace assur::output {

// Names of files; "": none.
struct MotionFileNames {
  std::string csv;  // "-": standard output
  std::string npy, hdf5;
};

class MotionFiles {
 public:
  // Opens the files before the run, so that a misspelt folder does not cost the work of an hour. how: rows and numbers
  // of .npy and HDF5. Throws Error (environment), like write(); also if HDF5 is missing.
  MotionFiles(const MotionFileNames& names, const NpyOptions& how);

  void write(const Trajectory& motion) { write_all(motion); }
  void write(const EnsembleTrajectory& motion) { write_all(motion); }

 private:
  template <class Motion>
  void write_all(const Motion& motion);

  bool csv_to_standard_output_;
  NpyOptions how_;
  Replacement csv_, npy_, hdf5_;
};

}  // namespace assur::output
