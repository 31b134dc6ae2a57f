#include "output/motion_hdf5.hpp"

namespace assur::output {

std::string why_no_hdf5() {
  return "this build cannot write HDF5, because the library was not found (Debian: libhdf5-dev)";
}
void write_hdf5(std::ostream& /*out*/, const Trajectory& /*motion*/, const NpyOptions& /*how*/) {}
void write_hdf5(std::ostream& /*out*/, const EnsembleTrajectory& /*motion*/, const NpyOptions& /*how*/) {}

}  // namespace assur::output
