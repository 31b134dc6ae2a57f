// SCENE of the command: a scene, a model or a sample.
#include <filesystem>

#include "assur/mjcf.hpp"
#include "scene/names.hpp"

namespace assur {

bool is_model(const std::filesystem::path& file) { return file.extension() == ".xml"; }

Scene open_scene(const std::string& file_or_sample, const Parameters& set,
                 const std::vector<std::filesystem::path>& more_folders) {
  std::error_code unused;
  const std::filesystem::path file = file_or_sample;
  const bool looks_like_file =
      file_or_sample.find('/') != std::string::npos || file.extension() == ".json" || is_model(file);
  if (std::filesystem::exists(file, unused) || (looks_like_file && !is_sample(file_or_sample))) {
    if (!is_model(file)) return read_scene(file, set, more_folders);
    if (!set.empty()) {
      throw Error(Error::Kind::input, {{"", "a model has no parameters, such as " + in_quotes(set.begin()->first)}},
                  file_or_sample);
    }
    return import_model(file).scene;
  }
  return sample(file_or_sample, set);  // its error lists the samples
}

}  // namespace assur
