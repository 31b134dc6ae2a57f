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
  older,    // of an earlier version; opening it for writing puts it aside
  damaged,  // a damaged tuning database; opening it for writing puts it aside
  blocked,  // locked, no space, no permission, ...: the file may be good
};

[[nodiscard]] constexpr bool goes_aside(Trouble trouble) {
  return trouble == Trouble::older || trouble == Trouble::damaged;
}

class Unusable : public Error {
 public:
  Unusable(Trouble trouble, const std::filesystem::path& file, const std::string& what)
      : Error(Kind::environment,
              file.string() + ": " + what +
                  (goes_aside(trouble) ? "; `assur tune --db " + file.string() + "` puts it aside and begins a new file"
                                       : "")),
        problem_(file.string() + ": " + what),
        trouble_(trouble) {}
  [[nodiscard]] Trouble trouble() const noexcept { return trouble_; }
  // The file and what is wrong with it, without the remedy.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }

 private:
  std::string problem_;
  Trouble trouble_;
};

}  // namespace assur::db
