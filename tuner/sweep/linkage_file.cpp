#include "sweep/linkage_file.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

#include "assur/status.hpp"
#include "output/hdf5_handle.hpp"

namespace assur::sweep {
namespace {

using Handle = output::Hdf5Handle;
using Shape = output::Hdf5Shape;
using output::hdf5_space;

constexpr hsize_t kChunkBytes = 256 << 10;

}  // namespace

struct LinkageFile::Impl {
  // One data set of the file, with a first dimension that grows.
  struct Column {
    const char* name;
    hid_t stored, given;  // types in the file and in memory
    Shape row;            // shape of a row
    Handle data{};
  };

  std::string name;
  std::size_t joints, times;
  Handle file;
  std::vector<Column> columns;
  LinkageCounts counts;

  [[noreturn]] void fail() const {
    throw Error(Error::Kind::environment, {{"--out", name + " cannot be written as HDF5"}});
  }
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(Error::Kind::input, {{"--out", name + " " + what + "; choose another file or remove it"}});
  }
  void check(herr_t result) const {
    if (result < 0) fail();
  }

  Impl(std::string file_name, const LinkageSet& set)
      : name(std::move(file_name)), joints(static_cast<std::size_t>(set.joints.most)), times(set.times.size()) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // this process prints its own messages
    const hsize_t j = joints;
    const hid_t real = H5T_NATIVE_DOUBLE;
    const auto add = [&](const char* of, hid_t stored, hid_t given, Shape row) {
      columns.push_back({of, stored, given, std::move(row), {}});
    };
    add("sample", H5T_STD_I64LE, H5T_NATIVE_INT64, {});
    add("joints", H5T_STD_I32LE, H5T_NATIVE_INT32, {});
    add("kind", H5T_STD_U8LE, H5T_NATIVE_UINT8, {j});
    add("left", H5T_STD_U8LE, H5T_NATIVE_UINT8, {j});
    add("parents", H5T_STD_U16LE, H5T_NATIVE_UINT16, {j, 2});
    add("values", H5T_IEEE_F64LE, real, {j, 3});
    add("curves", set.single ? H5T_IEEE_F32LE : H5T_IEEE_F64LE, real, {times, 2});
    add("center", H5T_IEEE_F64LE, real, {2});
    add("radius", H5T_IEEE_F64LE, real, {});
    add("angle", H5T_IEEE_F64LE, real, {});
    add("error", H5T_IEEE_F64LE, real, {});
    if (!set.target.empty()) add("distance", H5T_IEEE_F64LE, real, {});
    std::error_code ignored;
    if (std::filesystem::exists(name, ignored)) {
      open(set);
    } else {
      create(set);
    }
  }

  [[nodiscard]] static std::vector<std::pair<const char*, std::int64_t>> description(const LinkageSet& set) {
    return {{"seed", static_cast<std::int64_t>(set.seed)},
            {"fewest_joints", set.joints.least},
            {"most_joints", set.joints.most},
            {"first_sample", set.first},
            {"last_sample", set.last}};
  }

  [[nodiscard]] std::vector<std::pair<const char*, std::int64_t*>> figures() {
    return {{"samples", &counts.samples},
            {"rows", &counts.rows},
            {"jammed", &counts.jammed},
            {"not_closed", &counts.not_closed},
            {"inaccurate", &counts.inaccurate}};
  }

  void put(const char* attribute, std::int64_t value) {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const bool exists = H5Aexists(*file, attribute) > 0;
    const Handle at(exists ? H5Aopen(*file, attribute, H5P_DEFAULT)
                           : H5Acreate2(*file, attribute, H5T_STD_I64LE, *space, H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
    check(H5Awrite(*at, H5T_NATIVE_INT64, &value));
  }
  [[nodiscard]] std::int64_t get(const char* attribute) const {
    const Handle at(H5Aopen(*file, attribute, H5P_DEFAULT), H5Aclose);
    std::int64_t value = 0;
    if (!at.valid() || H5Aread(*at, H5T_NATIVE_INT64, &value) < 0) refuse("is no data set of linkages");
    return value;
  }

  void write_constant(const char* of, const Shape& shape, const double* values) const {
    const Handle space = hdf5_space(shape, shape);
    const Handle data(H5Dcreate2(*file, of, H5T_IEEE_F64LE, *space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
    check(H5Dwrite(*data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
  }
  // Empty if there is no such data set.
  template <class T = double>
  [[nodiscard]] std::vector<T> numbers_in(const char* of, hid_t type = H5T_NATIVE_DOUBLE) const {
    if (H5Lexists(*file, of, H5P_DEFAULT) <= 0) return {};
    const Handle data(H5Dopen2(*file, of, H5P_DEFAULT), H5Dclose), space(H5Dget_space(*data), H5Sclose);
    std::vector<T> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(*space)));
    check(H5Dread(*data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()));
    return values;
  }

  void create(const LinkageSet& set) {
    file = {H5Fcreate(name.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT), H5Fclose};
    if (!file.valid()) fail();
    for (Column& c : columns) {
      Shape shape = {0}, most = {H5S_UNLIMITED}, chunk = {1};
      hsize_t bytes = H5Tget_size(c.stored);
      for (const hsize_t n : c.row) {
        shape.push_back(n);
        most.push_back(n);
        chunk.push_back(n);
        bytes *= n;
      }
      chunk[0] = std::max<hsize_t>(1, kChunkBytes / bytes);
      const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose), space = hdf5_space(shape, most);
      check(H5Pset_chunk(*how, static_cast<int>(chunk.size()), chunk.data()));
      c.data = {H5Dcreate2(*file, c.name, c.stored, *space, H5P_DEFAULT, *how, H5P_DEFAULT), H5Dclose};
      if (!c.data.valid()) fail();
    }
    write_constant("times", {times}, set.times.data());
    if (!set.target.empty()) write_constant("target", {set.target.size(), 2}, set.target.data()->data());
    for (const auto& [attribute, value] : description(set)) put(attribute, value);
    finish();
  }

  void open(const LinkageSet& set) {
    file = {H5Fopen(name.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose};
    if (!file.valid()) refuse("is not an HDF5 file that can be continued");
    for (const auto& [attribute, value] : description(set)) {
      if (get(attribute) == value) continue;
      refuse("has " + std::string(attribute) + " " + std::to_string(get(attribute)) + ", this sweep " +
             std::to_string(value));
    }
    std::vector<double> target;
    for (const PlanePoint& p : set.target) target.insert(target.end(), p.begin(), p.end());
    if (numbers_in("times") != set.times) refuse("has other times");
    if (numbers_in("target") != target) refuse("has another target");
    for (const auto& [attribute, value] : figures()) *value = get(attribute);
    for (Column& c : columns) {
      c.data = {H5Dopen2(*file, c.name, H5P_DEFAULT), H5Dclose};
      if (!c.data.valid()) refuse("is no data set of linkages");
      if (H5Tequal(*Handle(H5Dget_type(*c.data), H5Tclose), c.stored) <= 0) refuse("has another precision");
      resize(c, counts.rows);  // drops rows after the last flush
    }
  }

  void resize(Column& c, std::int64_t to) const {
    Shape shape = {static_cast<hsize_t>(to)};
    shape.insert(shape.end(), c.row.begin(), c.row.end());
    check(H5Dset_extent(*c.data, shape.data()));
  }

  void write(Column& c, std::size_t count, const void* values) const {
    resize(c, counts.rows + static_cast<std::int64_t>(count));
    Shape from = {static_cast<hsize_t>(counts.rows)}, size = {count};
    from.insert(from.end(), c.row.size(), 0);
    size.insert(size.end(), c.row.begin(), c.row.end());
    const Handle in_file(H5Dget_space(*c.data), H5Sclose), in_memory = hdf5_space(size, size);
    check(H5Sselect_hyperslab(*in_file, H5S_SELECT_SET, from.data(), nullptr, size.data(), nullptr));
    check(H5Dwrite(*c.data, c.given, *in_memory, *in_file, H5P_DEFAULT, values));
  }

  // Values of all rows, one after another.
  template <class T>
  void write(std::size_t column, std::span<const LinkageRow> all,
             const std::function<void(const LinkageRow&, T*)>& fill) {
    std::size_t each = 1;
    for (const hsize_t n : columns[column].row) each *= n;
    std::vector<T> values(all.size() * each);
    for (std::size_t i = 0; i < all.size(); ++i) fill(all[i], values.data() + i * each);
    write(columns[column], all.size(), values.data());
  }

  // Values of all joints of all rows.
  template <class T>
  void write_joints(std::size_t column, std::span<const LinkageRow> all,
                    const std::function<void(const LinkageJoint&, T*)>& fill) {
    write<T>(column, all, [&](const LinkageRow& row, T* to) {
      std::size_t each = 1;
      for (std::size_t i = 1; i < columns[column].row.size(); ++i) each *= columns[column].row[i];
      for (const LinkageJoint& joint : row.linkage.joints) {
        fill(joint, to);
        to += each;
      }
    });
  }

  void append(std::span<const LinkageRow> all, const LinkageCounts& more) {
    if (!all.empty()) {
      write<std::int64_t>(0, all, [](const LinkageRow& r, auto* to) { *to = r.sample; });
      write<std::int32_t>(1, all,
                          [](const LinkageRow& r, auto* to) { *to = static_cast<int>(r.linkage.joints.size()); });
      write_joints<std::uint8_t>(2, all,
                                 [](const LinkageJoint& j, auto* to) { *to = static_cast<std::uint8_t>(j.kind); });
      write_joints<std::uint8_t>(3, all, [](const LinkageJoint& j, auto* to) { *to = j.left ? 1 : 0; });
      write_joints<std::uint16_t>(4, all, [](const LinkageJoint& j, auto* to) {
        to[0] = j.first;
        to[1] = j.second;
      });
      write_joints<double>(5, all,
                           [](const LinkageJoint& j, auto* to) { std::copy(j.value.begin(), j.value.end(), to); });
      write<double>(6, all, [](const LinkageRow& r, auto* to) {
        for (const PlanePoint& p : r.curve) to = std::copy(p.begin(), p.end(), to);
      });
      write<double>(7, all,
                    [](const LinkageRow& r, auto* to) { std::copy(r.frame.center.begin(), r.frame.center.end(), to); });
      write<double>(8, all, [](const LinkageRow& r, auto* to) { *to = r.frame.radius; });
      write<double>(9, all, [](const LinkageRow& r, auto* to) { *to = r.frame.angle; });
      write<double>(10, all, [](const LinkageRow& r, auto* to) { *to = r.error; });
      if (columns.size() > 11) write<double>(11, all, [](const LinkageRow& r, auto* to) { *to = r.distance; });
      check(H5Fflush(*file, H5F_SCOPE_LOCAL));
    }
    counts.samples += more.samples;
    counts.rows += static_cast<std::int64_t>(all.size());
    counts.jammed += more.jammed;
    counts.not_closed += more.not_closed;
    counts.inaccurate += more.inaccurate;
    finish();
  }

  // Says which rows count.
  void finish() {
    for (const auto& [attribute, value] : figures()) put(attribute, *value);
    check(H5Fflush(*file, H5F_SCOPE_LOCAL));
  }
};

LinkageFile::LinkageFile(const std::string& name, const LinkageSet& set) : impl_(std::make_unique<Impl>(name, set)) {}
LinkageFile::~LinkageFile() = default;
const LinkageCounts& LinkageFile::counts() const { return impl_->counts; }
std::vector<std::pair<std::int64_t, double>> LinkageFile::distances() const {
  const std::vector<double> distances = impl_->numbers_in("distance");
  const auto samples = impl_->numbers_in<std::int64_t>("sample", H5T_NATIVE_INT64);
  std::vector<std::pair<std::int64_t, double>> all;
  for (std::size_t i = 0; i < distances.size(); ++i) all.emplace_back(samples[i], distances[i]);
  return all;
}
void LinkageFile::append(std::span<const LinkageRow> rows, const LinkageCounts& more) { impl_->append(rows, more); }

}  // namespace assur::sweep
