#include "output/motion_files.hpp"

#include <cerrno>
#include <cstring>
#include <iostream>

#include "output/motion_hdf5.hpp"

namespace assur::output {
namespace {

template <class Motion>
void write_to_standard_output(const Motion& motion) {
  errno = 0;
  write_csv(std::cout, motion);
  std::cout.flush();
  if (std::cout) return;
  const std::string why = errno != 0 ? std::strerror(errno) : "unknown reason";
  throw Error(Error::Kind::environment, {{"--csv", "cannot write to standard output: " + why}});
}

}  // namespace

MotionFiles::MotionFiles(const MotionFileNames& names, const NpyOptions& how)
    : csv_to_standard_output_(names.csv == "-"), how_(how) {
  if (!names.csv.empty() && !csv_to_standard_output_) csv_.emplace("--csv", names.csv);
  if (!names.npy.empty()) npy_.emplace("--npy", names.npy);
  if (names.hdf5.empty()) return;
  if (const std::string why = why_no_hdf5(); !why.empty()) throw Error(Error::Kind::environment, {{"--hdf5", why}});
  hdf5_.emplace("--hdf5", names.hdf5);
}

template <class Motion>
void MotionFiles::write_all(const Motion& motion) {
  if (csv_to_standard_output_) write_to_standard_output(motion);
  if (csv_) {
    write_csv(csv_->stream(), motion);
    csv_->put();
  }
  if (npy_) {
    write_npy(npy_->stream(), motion, how_);
    npy_->put();
  }
  if (hdf5_) {
    write_hdf5(hdf5_->stream(), motion, how_);
    hdf5_->put();
  }
}

template void MotionFiles::write_all(const Trajectory&);
template void MotionFiles::write_all(const EnsembleTrajectory&);

}  // namespace assur::output
