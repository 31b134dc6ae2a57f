// Where a scene with parameters comes from.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assur/scene.hpp"

namespace assur {

struct SceneSource {
  std::vector<std::string> parameters;            // names
  std::function<Scene(const Parameters&)> again;  // makes the scene with other values of some parameters

  // The scene with its source.
  static Scene attach(Scene scene, SceneSource source);
  // The bodies as written, also those that a fixed joint makes a part of the ground.
  static const std::vector<Body>& written_bodies(const Scene& scene) { return scene.written().bodies; }
  // Throws Error (input) if Scene::with_values() does not know a name.
  static void check_names(const Scene& scene, std::span<const std::string> names);
};

}  // namespace assur
