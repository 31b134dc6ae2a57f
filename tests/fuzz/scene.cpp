#include "assur/scene.hpp"

#include <cmath>

#include "fuzz/targets.hpp"

namespace assur::fuzz {

bool scene(std::string_view bytes) {
  return accepts([&] {
    const Scene scene = parse_scene(bytes, "scene", ASSUR_SOURCE_DIR "/tests/data/tables");
    require(scene.dimension() == 2 || scene.dimension() == 3, "a scene is in the plane or in space");
    require(scene.time().steps() >= 0 && std::isfinite(scene.time().time(scene.time().steps())), "times are finite");
  });
}

}  // namespace assur::fuzz
