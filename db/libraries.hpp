// The libraries behind samples: a sample holds as long as the library that it was taken with is the one at hand.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "assur/performance.hpp"

namespace assur::db {

struct Library {
  std::string name;     // of a backend, or "assur"
  std::string version;  // "" if it is absent; of code that is our own, with the version of assur
  std::string build;    // compiler and kind of build

  friend bool operator==(const Library&, const Library&) = default;
};

// As this build reports it. A name that it does not know has neither version nor build.
[[nodiscard]] Library library_at_hand(std::string_view name);

using LibraryAtHand = std::function<Library(std::string_view name)>;

// Which one a sample's time depends on: its backend, or "assur" for the kernels that no solver takes part in.
[[nodiscard]] std::string library_name(const Sample& sample);

[[nodiscard]] std::string_view assur_version();

}  // namespace assur::db
