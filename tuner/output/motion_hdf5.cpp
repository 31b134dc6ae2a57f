#include "output/motion_hdf5.hpp"

#include <ostream>
#include <span>
#include <vector>

#include "assur/status.hpp"
#include "output/hdf5_handle.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kGrowth = 1 << 20;  // bytes by which the file in memory grows

class FileInMemory {
 public:
  explicit FileInMemory(bool single) : single_(single) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // this process prints its own messages
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    check(H5Pset_fapl_core(*access, kGrowth, 0));
    file_ = {H5Fcreate("motion.h5", H5F_ACC_TRUNC, H5P_DEFAULT, *access), H5Fclose};
    check(*file_);
  }

  void add(const std::string& name, const Hdf5Shape& shape, std::span<const double> values) {
    const Hdf5Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose), space = hdf5_space(shape, shape);
    check(H5Pset_create_intermediate_group(*links, 1));  // a name with a slash is a data set in a group
    const Hdf5Handle data(H5Dcreate2(*file_, name.c_str(), single_ ? H5T_IEEE_F32LE : H5T_IEEE_F64LE, *space, *links,
                                     H5P_DEFAULT, H5P_DEFAULT),
                          H5Dclose);
    check(*data);
    check(H5Dwrite(*data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
  }

  // count numbers in each of `runs` runs; value(run, i) is one of them.
  template <class Value>
  void add_column(const std::string& name, const Hdf5Shape& shape, std::size_t runs, std::size_t count,
                  const Value& value) {
    column_.clear();
    for (std::size_t m = 0; m < runs; ++m) {
      for (std::size_t k = 0; k < count; ++k) column_.push_back(value(m, k));
    }
    add(name, shape, column_);
  }

  void write(std::ostream& out) {
    check(H5Fflush(*file_, H5F_SCOPE_GLOBAL));
    const ssize_t bytes = H5Fget_file_image(*file_, nullptr, 0);
    check(bytes);
    std::vector<char> image(static_cast<std::size_t>(bytes));
    check(H5Fget_file_image(*file_, image.data(), image.size()));
    out.write(image.data(), bytes);
  }

 private:
  template <class Result>
  static void check(Result result) {
    if (result < 0) throw Error(Error::Kind::environment, {{"--hdf5", "the file cannot be made in memory"}});
  }

  bool single_;
  Hdf5Handle file_;
  std::vector<double> column_;
};

std::vector<double> every(std::span<const double> times, std::size_t n) {
  std::vector<double> out;
  for (std::size_t k = 0; k < times.size(); k += n) out.push_back(times[k]);
  return out;
}

}  // namespace

std::string why_no_hdf5() { return {}; }

void write_hdf5(std::ostream& out, const Trajectory& motion, const NpyOptions& how) {
  FileInMemory file(how.single);
  const std::vector<double> times = every(motion.times(), how.every);
  file.add("t", {times.size()}, times);
  for (std::size_t c = 0; c < motion.columns().size(); ++c) {
    file.add_column(motion.columns()[c], {times.size()}, 1, times.size(),
                    [&](std::size_t, std::size_t k) { return motion(k * how.every, c); });
  }
  file.write(out);
}

void write_hdf5(std::ostream& out, const EnsembleTrajectory& motion, const NpyOptions& how) {
  FileInMemory file(how.single);
  const std::vector<double> times = every(motion.times(), how.every);
  file.add("t", {times.size()}, times);
  for (std::size_t c = 0; c < motion.columns().size(); ++c) {
    file.add_column(motion.columns()[c], {motion.members(), times.size()}, motion.members(), times.size(),
                    [&](std::size_t m, std::size_t k) { return motion(m, k * how.every, c); });
  }
  file.write(out);
}

}  // namespace assur::output
