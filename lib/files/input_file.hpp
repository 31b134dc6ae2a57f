// Reads files that a user or a scene names. Such a file may be untrusted and of any type, e.g. a pipe that is never
// filled, or a device without an end. All of them are read here: regular files only, up to a given size.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace assur {

constexpr std::uintmax_t kLargestScene = 1'000'000'000;  // bytes; a million dyads take a fifth of it
constexpr std::uintmax_t kLargestTable = 256'000'000;    // bytes, of a CSV: an hour at 1 kHz takes a third of it

struct InputFile {
  std::string text;
  std::string why_not;  // half a sentence, e.g. "permission denied"; empty if the file was read
};

// The bytes of a regular file of at most `most` bytes. Never waits.
[[nodiscard]] InputFile read_input(const std::filesystem::path& file, std::uintmax_t most);

// "it is a pipe; only regular files are read", or the same for other types; "" for a regular file or a missing one.
[[nodiscard]] std::string why_not_regular(const std::filesystem::path& file);

}  // namespace assur
