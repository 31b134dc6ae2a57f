// A sample from the installed library, from scene to motion.
#include <cstdio>

#include <assur/assur.hpp>

int main() {
  assur::Simulator simulator(assur::prepare(assur::sample("four_bar:3")));
  const assur::Trajectory motion = simulator.run();
  const double error = simulator.report().error.position;
  std::printf("%zu times, position error %.1e\n", motion.times().size(), error);
  const bool asked = assur::machine_model().model != nullptr;  // the databases
  return motion.times().size() > 1 && error < 1e-13 && asked ? 0 : 1;
}
