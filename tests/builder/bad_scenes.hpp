// The scenes of tests/data/bad_scenes; the .expected file beside each has the lines of its refusal.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "source_dir.hpp"

namespace assur::bad_scenes {

inline const std::filesystem::path kFolder = std::filesystem::path(ASSUR_SOURCE_DIR) / "tests/data/bad_scenes";

// Names of the scenes without ".json", sorted.
inline std::vector<std::string> names() {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() == ".json") found.push_back(entry.path().stem().string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

inline std::string expected(const std::string& name) {
  std::ifstream stream(kFolder / (name + ".expected"), std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace assur::bad_scenes
