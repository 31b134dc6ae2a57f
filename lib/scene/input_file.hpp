// Files that a user or a scene names may be anyone's, and anything: a pipe that nobody fills, a device without an end.
// Every one of them is read through here: regular files only, up to a size.
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

// "it is a pipe; only regular files are read", or what else it is; "" for a regular file, and where there is nothing.
[[nodiscard]] std::string why_not_regular(const std::filesystem::path& file);

}  // namespace assur
