// Handles of the HDF5 library.
#pragma once

#include <hdf5.h>

#include <utility>
#include <vector>

namespace assur::output {

class Hdf5Handle {
 public:
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Handle(Hdf5Handle&& o) noexcept : id_(std::exchange(o.id_, -1)), close_(o.close_) {}
  Hdf5Handle& operator=(Hdf5Handle&& o) noexcept {
    std::swap(id_, o.id_);
    std::swap(close_, o.close_);
    return *this;
  }
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }
  [[nodiscard]] hid_t operator*() const { return id_; }
  [[nodiscard]] bool valid() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

using Hdf5Shape = std::vector<hsize_t>;

// most: the largest shape; H5S_UNLIMITED grows.
inline Hdf5Handle hdf5_space(const Hdf5Shape& shape, const Hdf5Shape& most) {
  return {H5Screate_simple(static_cast<int>(shape.size()), shape.data(), most.data()), H5Sclose};
}

}  // namespace assur::output
