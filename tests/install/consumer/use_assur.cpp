// A sample from the installed library, from scene to motion.
#include <cstdio>

#include <assur/assur.hpp>

int main() {
  assur::Simulator simulator(assur::prepare(assur::sample("four_bar:3")));
  const assur::Trajectory motion = simulator.run();
  const double error = simulator.report().error.position;
  std::printf("%zu times, position error %.1e\n", motion.times().size(), error);
  return motion.times().size() > 1 && error < 1e-13 ? 0 : 1;
}
