// The error for a database file that cannot be used.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "assur/status.hpp"

namespace assur::db {

enum class Trouble : std::uint8_t {
  absent,   // no such file, or an empty one
  foreign,  // another type of file, which is never changed
  newer,    // of a later version, which is never changed
  damaged,  // a damaged tuning database
  blocked,  // locked, no space, no permission, ...: the file may be good
};

class Unusable : public Error {
 public:
  Unusable(Trouble trouble, const std::filesystem::path& file, const std::string& what)
      : Error(Kind::environment, file.string() + ": " + what), trouble_(trouble) {}
  [[nodiscard]] Trouble trouble() const noexcept { return trouble_; }

 private:
  Trouble trouble_;
};

}  // namespace assur::db
