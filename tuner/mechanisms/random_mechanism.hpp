// Random mechanisms in the style of users: bodies that share points and axes, dot products, all kinds of constraints,
// drivers and laws, redundant equations, rough guesses, parts far from the origin, units of any size.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"

namespace assur::mechanisms {

struct RandomMechanism {
  std::uint64_t seed = 0;
  std::string family;  // "planar_chain", "delta", ...
  std::string json;    // the scene in the scene format
  std::string tables;  // the folder of its tables
  std::string exact;   // the same scene with exact guesses
  double rough = 0;    // rotation of the guesses, rad; their lengths are wrong by up to 30 %
  // Drivers that a program sets, and the values of each step, one for each driver. Empty: only laws.
  std::vector<std::string> controlled;
  std::vector<std::vector<double>> commands;
  bool with_rates = false;  // values are set with rates, so that no driver overshoots
  PrepareOptions how;       // the strategy to run it with

  [[nodiscard]] Scene scene() const;
};

// Makes a mechanism; the same seed gives the same one on every machine. `tables`: a folder with swing.csv, a table over
// 0 to 4 s; "": no tables.
[[nodiscard]] RandomMechanism random_mechanism(std::uint64_t seed, const std::string& tables = {});

}  // namespace assur::mechanisms
