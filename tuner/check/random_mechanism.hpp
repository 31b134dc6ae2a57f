// Mechanisms drawn at random, written as users write them: bodies that share points and axes, dot products, all kinds
// of constraints, drivers and laws, redundant equations, rough guesses, parts far from the origin, units of any size.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"

namespace assur::check {

struct RandomMechanism {
  std::uint64_t seed = 0;
  std::string family;  // "four_bar_chain", "delta", ...
  std::string json;    // the scene in the scene format
  std::string tables;  // the folder of its tables
  std::string exact;   // the same with the posture for its guesses
  double rough = 0;    // rad: by how much its guesses are turned; lengths are off by up to 30 %
  // Control: drivers that a program sets, and the values of each step, one for each of them. Empty: the laws alone.
  std::vector<std::string> controlled;
  std::vector<std::vector<double>> commands;
  bool with_rates = false;  // told with the values, so that no driver overshoots
  PrepareOptions how;       // the strategy to run it with

  [[nodiscard]] Scene scene() const;
};

// The same mechanism for the same seed on every machine. `tables`: a folder with swing.csv, a law's table over 0 ... 4
// s; empty: no tables.
[[nodiscard]] RandomMechanism random_mechanism(std::uint64_t seed, const std::string& tables = {});

}  // namespace assur::check
