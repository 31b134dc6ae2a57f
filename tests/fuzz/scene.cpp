#include "assur/scene.hpp"

#include <cmath>

#include "fuzz/targets.hpp"
#include "source_dir.hpp"

namespace assur::fuzz {

bool scene(std::string_view bytes) {
  return accepts([&] {
    const Scene scene = parse_scene(bytes, "scene", ASSUR_SOURCE_DIR "/tests/data/tables");
    require(scene.dimension() == 2 || scene.dimension() == 3, "the dimension of a scene must be 2 or 3");
    require(scene.time().steps() >= 0 && std::isfinite(scene.time().time(scene.time().steps())),
            "times must be finite");
  });
}

}  // namespace assur::fuzz
