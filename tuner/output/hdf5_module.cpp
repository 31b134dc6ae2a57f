// The module assur_hdf5.so.
#include <hdf5.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "output/hdf5.hpp"

namespace assur::output {
namespace {

constexpr hsize_t kChunkBytes = 256 << 10;
constexpr std::size_t kGrowth = 1 << 20;  // bytes by which a file in memory grows

class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& o) noexcept : id_(std::exchange(o.id_, -1)), close_(o.close_) {}
  Handle& operator=(Handle&& o) noexcept {
    std::swap(id_, o.id_);
    std::swap(close_, o.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  [[nodiscard]] hid_t operator*() const { return id_; }
  [[nodiscard]] bool valid() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

// most: the largest shape.
Handle space_of(const std::vector<hsize_t>& shape, const std::vector<hsize_t>& most) {
  return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), most.data()), H5Sclose};
}

class File final : public Hdf5File {
 public:
  File(Access access, const char* name) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // the command prints its own messages
    if (access == Access::change) {
      file_ = {H5Fopen(name, H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose};
      return;
    }
    const bool in_memory = access == Access::memory;
    const Handle how(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (in_memory && H5Pset_fapl_core(*how, kGrowth, 0) < 0) return;
    file_ = {H5Fcreate(name, in_memory ? H5F_ACC_TRUNC : H5F_ACC_EXCL, H5P_DEFAULT, *how), H5Fclose};
  }
  [[nodiscard]] bool valid() const { return file_.valid(); }

  bool put(const char* attribute, std::int64_t value) override {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle at(H5Aexists(*file_, attribute) > 0
                        ? H5Aopen(*file_, attribute, H5P_DEFAULT)
                        : H5Acreate2(*file_, attribute, H5T_STD_I64LE, *space, H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
    return H5Awrite(*at, H5T_NATIVE_INT64, &value) >= 0;
  }
  bool get(const char* attribute, std::int64_t& value) override {
    const Handle at(H5Aopen(*file_, attribute, H5P_DEFAULT), H5Aclose);
    return at.valid() && H5Aread(*at, H5T_NATIVE_INT64, &value) >= 0;
  }

  bool add(const std::string& name, Type stored, const Shape& shape, const double* values) override {
    const std::vector<hsize_t> all(shape.begin(), shape.end());
    return create(name, stored, space_of(all, all), H5P_DEFAULT) && write(name, H5S_ALL, H5S_ALL, Type::f64, values);
  }
  bool add_rows(const std::string& name, Type stored, const Shape& row) override {
    std::vector<hsize_t> shape = {0}, most = {H5S_UNLIMITED}, chunk = {1};
    hsize_t bytes = H5Tget_size(in_file(stored));
    for (const hsize_t n : row) {
      for (auto* const of : {&shape, &most, &chunk}) of->push_back(n);
      bytes *= n;
    }
    chunk[0] = std::max<hsize_t>(1, kChunkBytes / bytes);
    const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    return H5Pset_chunk(*how, static_cast<int>(chunk.size()), chunk.data()) >= 0 &&
           create(name, stored, space_of(shape, most), *how);
  }
  bool has(const std::string& name) override {
    return H5Lexists(*file_, name.c_str(), H5P_DEFAULT) > 0 && data(name) >= 0;
  }

  bool is(const std::string& name, Type stored) override {
    return H5Tequal(*Handle(H5Dget_type(data(name)), H5Tclose), in_file(stored)) > 0;
  }
  std::size_t size(const std::string& name) override {
    return static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(*space_in_file(name))));
  }
  bool read(const std::string& name, Type given, void* values) override {
    return H5Dread(data(name), in_memory(given), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0;
  }
  bool resize(const std::string& name, std::uint64_t rows) override {
    return H5Dset_extent(data(name), shape_of(name, rows).data()) >= 0;
  }
  bool append(const std::string& name, std::uint64_t after, std::uint64_t rows, Type given,
              const void* values) override {
    if (!resize(name, after + rows)) return false;
    const std::vector<hsize_t> size = shape_of(name, rows);
    std::vector<hsize_t> from(size.size(), 0);
    from[0] = after;
    const Handle in_file = space_in_file(name);
    return H5Sselect_hyperslab(*in_file, H5S_SELECT_SET, from.data(), nullptr, size.data(), nullptr) >= 0 &&
           write(name, *space_of(size, size), *in_file, given, values);
  }

  bool flush() override { return H5Fflush(*file_, H5F_SCOPE_GLOBAL) >= 0; }
  bool image(std::vector<char>& bytes) override {
    const ssize_t size = flush() ? H5Fget_file_image(*file_, nullptr, 0) : -1;
    if (size < 0) return false;
    bytes.resize(static_cast<std::size_t>(size));
    return H5Fget_file_image(*file_, bytes.data(), bytes.size()) >= 0;
  }

 private:
  static hid_t in_file(Type type) {
    const hid_t ids[] = {H5T_STD_U8LE, H5T_STD_U16LE, H5T_STD_I32LE, H5T_STD_I64LE, H5T_IEEE_F32LE, H5T_IEEE_F64LE};
    return ids[static_cast<std::size_t>(type)];
  }
  static hid_t in_memory(Type type) {
    const hid_t ids[] = {H5T_NATIVE_UINT8, H5T_NATIVE_UINT16, H5T_NATIVE_INT32,
                         H5T_NATIVE_INT64, H5T_NATIVE_FLOAT,  H5T_NATIVE_DOUBLE};
    return ids[static_cast<std::size_t>(type)];
  }

  // The data set, which stays open; < 0 if there is none.
  hid_t data(const std::string& name) {
    Handle& open = data_[name];
    if (!open.valid()) open = {H5Dopen2(*file_, name.c_str(), H5P_DEFAULT), H5Dclose};
    return *open;
  }
  bool create(const std::string& name, Type stored, const Handle& space, hid_t how) {
    const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    if (H5Pset_create_intermediate_group(*links, 1) < 0) return false;
    data_[name] = {H5Dcreate2(*file_, name.c_str(), in_file(stored), *space, *links, how, H5P_DEFAULT), H5Dclose};
    return data_[name].valid();
  }
  bool write(const std::string& name, hid_t in_memory, hid_t in_file, Type given, const void* values) {
    return H5Dwrite(data(name), File::in_memory(given), in_memory, in_file, H5P_DEFAULT, values) >= 0;
  }
  Handle space_in_file(const std::string& name) { return {H5Dget_space(data(name)), H5Sclose}; }
  // The shape of the data set with this number of rows.
  std::vector<hsize_t> shape_of(const std::string& name, hsize_t rows) {
    const Handle space = space_in_file(name);
    std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(1, H5Sget_simple_extent_ndims(*space))));
    H5Sget_simple_extent_dims(*space, shape.data(), nullptr);
    shape[0] = rows;
    return shape;
  }

  Handle file_;
  std::map<std::string, Handle> data_;
};

}  // namespace

extern "C" __attribute__((visibility("default"))) Hdf5File* assur_open_hdf5(Hdf5File::Access access, const char* name) {
  auto file = std::make_unique<File>(access, name);
  return file->valid() ? file.release() : nullptr;
}

}  // namespace assur::output
