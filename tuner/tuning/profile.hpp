// Profiles of tuning runs: quick, standard, patient.
#pragma once

#include <optional>
#include <string>

#include "tuning/cells.hpp"

namespace assur::tuning {

struct Profile {
  std::string name;
  double seconds = 55;         // for the whole run; patient: at most
  double most_for_cell = 1;    // s
  bool until_settled = false;  // ends when the regret on held-out cells stops falling
  Extent extent;
};

// The profile `name`: quick, standard or patient. budget: replaces its seconds; a small budget measures fewer sizes.
// Throws Error (input) for another name.
[[nodiscard]] Profile profile(const std::string& name, std::optional<double> budget);

}  // namespace assur::tuning
