// Hot loops for counting instructions; arguments: SCENE, STRATEGY, a number of steps, and a fixed number of iterations
// as in table 4 of the paper (0, the default: until the residual is small). Only run_hot_loop() is counted
// (instructions.sh names it to callgrind), not the preparation and the first steps. SCENE may be "joints=NAME" or
// "by_hand=NAME", one of the mechanisms of tests/joints/by_hand.hpp.
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>

#include "assur/assur.hpp"
#include "joints/by_hand.hpp"

namespace {

// Steps before those that are counted. With a fixed number of iterations all steps take the same work.
constexpr std::int64_t kWarm = 20, kWarmIfFixed = 2;

assur::Scene scene_of(const std::string& text) {
  const std::string way = text.substr(0, text.find('=')), name = text.substr(text.find('=') + 1);
  if (way != "joints" && way != "by_hand") return assur::open_scene(text);
  for (const auto& all : {assur::test::plane_mechanisms_by_hand(), assur::test::space_mechanisms_by_hand()}) {
    for (const assur::test::WrittenTwice& m : all) {
      if (m.name == name) return way == "joints" ? m.joints : m.by_hand;
    }
  }
  throw assur::Error(assur::Error::Kind::input, "no mechanism is named " + name);
}

}  // namespace

// Neither inlined nor mangled, because callgrind toggles its collection here.
extern "C" [[gnu::noinline]] bool run_hot_loop(assur::Simulator& simulator, const assur::TimeGrid& grid,
                                               std::int64_t first, std::int64_t steps) {
  for (std::int64_t k = first; k < first + steps; ++k) {
    if (!simulator.step(grid.time(k)).arrived()) return false;
  }
  return true;
}

int main(int argc, char** argv) {
  if (argc != 4 && argc != 5) {
    std::fprintf(stderr, "usage: %s SCENE STRATEGY STEPS [ITERATIONS]\n", argv[0]);
    return 2;
  }
  try {
    const assur::Scene scene = scene_of(argv[1]);
    assur::StepSettings settings;
    if (argc == 5) settings.iterations = std::stoi(argv[4]);
    assur::Simulator simulator(assur::prepare(scene, {argv[2], {}}), settings);
    const std::int64_t steps = std::stoll(argv[3]), warm = settings.iterations > 0 ? kWarmIfFixed : kWarm;
    for (std::int64_t k = 1; k <= warm; ++k) {
      if (!simulator.step(scene.time().time(k)).arrived()) return 1;
    }
    if (!run_hot_loop(simulator, scene.time(), warm + 1, steps)) return 1;
    std::printf("position error %.3g\n", simulator.report().error.position);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
}
