// The libraries that were measured: a sample is valid as long as its library has the same version and build.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "assur/performance.hpp"

namespace assur::db {

struct Library {
  std::string name;     // id of a backend, or "assur"
  std::string version;  // "" if it is absent; for code of assur it includes the version of assur
  std::string build;    // compiler and build type

  friend bool operator==(const Library&, const Library&) = default;
};

// The library in this build. An unknown name has neither version nor build.
[[nodiscard]] Library library_at_hand(std::string_view name);

using LibraryAtHand = std::function<Library(std::string_view name)>;

// The library that the time of a sample depends on: its backend, or "assur" for kernels without a solver.
[[nodiscard]] std::string library_name(const Sample& sample);

[[nodiscard]] std::string_view assur_version();

}  // namespace assur::db
