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
    const std::string text = write_scene(scene);
    bool is_same = false;
    require(accepts([&] { is_same = write_scene(parse_scene(text)) == text; }), "a written scene must be readable");
    require(is_same, "a scene must be written the same again");
  });
}

}  // namespace assur::fuzz
