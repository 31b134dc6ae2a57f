// Runs a sample with the installed library, and saves a plan for the program that uses only the core.
#include <cstdio>
#include <fstream>

#include <assur/assur.hpp>

int main(int argc, char** argv) {
  assur::Simulator simulator(assur::prepare(assur::sample("four_bar:3")));
  const assur::Trajectory motion = simulator.run();
  const double error = simulator.report().error.position;
  std::printf("%zu times, position error %.1e\n", motion.times().size(), error);
  const bool asked = assur::machine_model().model != nullptr;  // reads the databases
  if (argc > 1) {
    std::ofstream file(argv[1]);
    assur::save_plan(file, assur::prepare(assur::sample("stewart"), {.strategy = "irreducible/lanes:8"}));
  }
  return motion.times().size() > 1 && error < 1e-13 && asked ? 0 : 1;
}
