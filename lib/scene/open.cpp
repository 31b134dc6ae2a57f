#include <filesystem>

#include "assur/scene.hpp"

namespace assur {

Scene open_scene(const std::string& file_or_sample, const Parameters& set) {
  std::error_code unused;
  if (std::filesystem::exists(file_or_sample, unused)) return read_scene(file_or_sample, set);
  if (is_sample(file_or_sample)) return sample(file_or_sample, set);
  const bool looks_like_file =
      file_or_sample.find('/') != std::string::npos || std::filesystem::path(file_or_sample).extension() == ".json";
  if (looks_like_file) throw Error(Error::Kind::environment, {{"", "the scene file cannot be read"}}, file_or_sample);
  return sample(file_or_sample, set);  // says which samples there are
}

}  // namespace assur
