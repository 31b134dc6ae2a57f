// Files in HDF5. Only the module assur_hdf5.so is linked to HDF5, and it is loaded for the first file: HDF5 brings
// thirty libraries, for networks and keys, with which every command took 18 ms to start instead of 10 ms (perf stat -r
// 50).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace assur::output {

// A file that is open. Functions return false if HDF5 fails.
class Hdf5File {
 public:
  enum class Access : std::uint8_t { memory, create, change };
  enum class Type : std::uint8_t { u8, u16, i32, i64, f32, f64 };  // little-endian in files
  using Shape = std::vector<std::uint64_t>;

  virtual ~Hdf5File() = default;

  virtual bool put(const char* attribute, std::int64_t value) = 0;
  virtual bool get(const char* attribute, std::int64_t& value) = 0;

  // Adds a complete data set; a name with a slash is one in a group.
  virtual bool add(const std::string& name, Type stored, const Shape& shape, const double* values) = 0;
  // Adds a data set without rows. row: shape of a row.
  virtual bool add_rows(const std::string& name, Type stored, const Shape& row) = 0;
  [[nodiscard]] virtual bool has(const std::string& name) = 0;

  // The data set exists in these:
  [[nodiscard]] virtual bool is(const std::string& name, Type stored) = 0;
  [[nodiscard]] virtual std::size_t size(const std::string& name) = 0;  // number of values
  virtual bool read(const std::string& name, Type given, void* values) = 0;
  virtual bool resize(const std::string& name, std::uint64_t rows) = 0;
  // Writes rows after the first `after` ones, and drops what was there.
  virtual bool append(const std::string& name, std::uint64_t after, std::uint64_t rows, Type given,
                      const void* values) = 0;

  virtual bool flush() = 0;
  virtual bool image(std::vector<char>& bytes) = 0;  // the bytes of the file
};

// Opens a file: one in memory, a new one, or an existing one to change it. Null if that fails; the caller deletes it.
using OpenHdf5 = Hdf5File*(Hdf5File::Access access, const char* name);

// Loads the module. Throws Error (environment), located at `option`, if it cannot be loaded or this build has none.
[[nodiscard]] OpenHdf5* load_hdf5(const std::string& option);

}  // namespace assur::output
