#include <filesystem>

#include "assur/scene.hpp"

namespace assur {

Scene open_scene(const std::string& file_or_sample, const Parameters& set,
                 const std::vector<std::filesystem::path>& more_folders) {
  std::error_code unused;
  const bool looks_like_file =
      file_or_sample.find('/') != std::string::npos || std::filesystem::path(file_or_sample).extension() == ".json";
  if (std::filesystem::exists(file_or_sample, unused) || (looks_like_file && !is_sample(file_or_sample))) {
    return read_scene(file_or_sample, set, more_folders);
  }
  return sample(file_or_sample, set);  // its error lists the samples
}

}  // namespace assur
