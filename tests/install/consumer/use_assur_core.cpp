// The core alone runs a plan that another program saved.
#include <cmath>
#include <cstdio>
#include <fstream>

#include <assur/saved_plan.hpp>
#include <assur/simulator.hpp>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::ifstream file(argv[1]);
  assur::Simulator simulator(assur::load_plan(file));
  const assur::Trajectory motion = simulator.run();
  const double angle = motion.last("handle1"), error = simulator.report().error.position;
  std::printf("%s: handle1 = %.15f rad at t = %g s, position error %.1e\n", simulator.prepared().name().c_str(), angle,
              motion.times().back(), error);
  // The angle follows from the closed form of the leg, by the cosine rule in the plane of the handle.
  return simulator.report().status.ok() && std::abs(angle - 2.0782333566916) < 1e-12 && error < 1e-13 ? 0 : 1;
}
