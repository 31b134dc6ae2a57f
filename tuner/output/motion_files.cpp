#include "output/motion_files.hpp"

#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "output/hdf5.hpp"

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

std::size_t members(const Trajectory&) { return 1; }
std::size_t members(const EnsembleTrajectory& motion) { return motion.members(); }
double value(const Trajectory& motion, std::size_t, std::size_t row, std::size_t column) { return motion(row, column); }
double value(const EnsembleTrajectory& motion, std::size_t member, std::size_t row, std::size_t column) {
  return motion(member, row, column);
}

// The data set `t` (rows), and one for each output, of rows or of members x rows. Rows that a member did not reach are
// NaN. The file is made in memory.
template <class Motion>
void write_hdf5(std::ostream& out, const Motion& motion, const NpyOptions& how) {
  using Type = Hdf5File::Type;
  const std::unique_ptr<Hdf5File> file(load_hdf5("--hdf5")(Hdf5File::Access::memory, "motion.h5"));
  const Type stored = how.single ? Type::f32 : Type::f64;
  std::vector<double> values;
  for (std::size_t k = 0; k < motion.times().size(); k += how.every) values.push_back(motion.times()[k]);
  const std::size_t rows = values.size();
  bool is_made = file && file->add("t", stored, {rows}, values.data());
  Hdf5File::Shape shape = {rows};
  if constexpr (std::is_same_v<Motion, EnsembleTrajectory>) shape = {motion.members(), rows};
  for (std::size_t c = 0; c < motion.columns().size() && is_made; ++c) {
    values.clear();
    for (std::size_t m = 0; m < members(motion); ++m) {
      for (std::size_t k = 0; k < rows; ++k) values.push_back(value(motion, m, k * how.every, c));
    }
    is_made = file->add(motion.columns()[c], stored, shape, values.data());
  }
  std::vector<char> bytes;
  if (!is_made || !file->image(bytes)) {
    throw Error(Error::Kind::environment, {{"--hdf5", "the file cannot be made in memory"}});
  }
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

MotionFiles::MotionFiles(const MotionFileNames& names, const NpyOptions& how)
    : csv_to_standard_output_(names.csv == "-"),
      how_(how),
      csv_("--csv", csv_to_standard_output_ ? "" : names.csv),
      npy_("--npy", names.npy),
      hdf5_("--hdf5", names.hdf5) {
  if (hdf5_) static_cast<void>(load_hdf5("--hdf5"));
}

template <class Motion>
void MotionFiles::write_all(const Motion& motion) {
  if (csv_to_standard_output_) write_to_standard_output(motion);
  if (csv_) {
    write_csv(csv_.stream(), motion);
    csv_.put();
  }
  if (npy_) {
    write_npy(npy_.stream(), motion, how_);
    npy_.put();
  }
  if (hdf5_) {
    write_hdf5(hdf5_.stream(), motion, how_);
    hdf5_.put();
  }
}

template void MotionFiles::write_all(const Trajectory&);
template void MotionFiles::write_all(const EnsembleTrajectory&);

}  // namespace assur::output
