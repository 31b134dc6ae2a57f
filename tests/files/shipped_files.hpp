// The scene files of scenes/.
#pragma once

#include <algorithm>
#include <filesystem>
#include <vector>

#include "assur/scene.hpp"
#include "source_dir.hpp"

namespace assur::test {

// In the order of their names.
inline std::vector<std::filesystem::path> shipped_files() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(ASSUR_SOURCE_DIR "/scenes")) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() == ".json" && file.filename() != "scene.schema.json") files.push_back(file);
  }
  std::ranges::sort(files);
  return files;
}

// Gears are callbacks, too.
inline bool has_callback(const Scene& scene) {
  return std::ranges::any_of(scene.constraints(), [](const Constraint& c) { return c.as<Callback>() != nullptr; });
}

}  // namespace assur::test
