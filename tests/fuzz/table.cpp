#include <algorithm>
#include <cmath>
#include <variant>

#include "assur/scene.hpp"
#include "fuzz/targets.hpp"
#include "parallel/file_tree.hpp"

namespace assur::fuzz {
namespace {

constexpr std::size_t kMostTried = 1000;  // largest number of tested points of a table

bool is_finite(const Motion& motion) {
  return std::isfinite(motion.value) && std::isfinite(motion.rate) && std::isfinite(motion.acceleration);
}

// A law whose table was accepted is finite wherever it is defined.
void try_law(const Law& law) {
  const auto& spline = std::get<Law::Spline>(law.parts().front());
  for (std::size_t i = 0; i < std::min(spline.time.size(), kMostTried); ++i) {
    const double t = spline.time[i], before = spline.time[i > 0 ? i - 1 : 0];
    for (const double at : {t, t / 2 + before / 2}) require(is_finite(law(at)), "the law must be finite");
  }
  for (const double far : {0.0, 1e300, -1e300}) {
    if (law.covers(far)) (void)law(far);
  }
}

constexpr const char* kScene = R"({"assur": 1, "dimension": 2, "points": {"A": {"at": [0, 0]}}, "drivers": {
  "push": {"coordinate": "A.x", "law": {"table": "table.csv"}}, "lift": {"coordinate": "A.y", "law": {"constant": 0}}}})";

}  // namespace

bool table(std::string_view bytes) {
  static test::FileTree folder;
  folder.file("table.csv", std::string(bytes));
  return accepts([&] {
    const Scene scene = parse_scene(kScene, "scene", folder.root());
    const Law law = std::get<DrivenCoordinate>(scene.drivers().front().kind).law;
    try_law(law);
    const auto& open = std::get<Law::Spline>(law.parts().front());
    (void)accepts([&] { try_law(Law::table(open.time, open.value, true)); });
  });
}

}  // namespace assur::fuzz
