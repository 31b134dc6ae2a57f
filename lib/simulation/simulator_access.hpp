// What the library and its tests do with a simulator beyond its public functions.
#pragma once

#include <chrono>
#include <vector>

#include "assur/simulator.hpp"

namespace assur {

struct SimulatorAccess {
  // All coordinates of the current posture, internal units.
  [[nodiscard]] static std::vector<double> posture(const Simulator& simulator);
  // As Simulator::step(t), but keeps all events.
  static Status step_of_run(Simulator& simulator, double t);
  // For tests: the clock that decides about deadlines.
  static void use_clock(Simulator& simulator, std::chrono::steady_clock::time_point (*clock)());
};

}  // namespace assur
