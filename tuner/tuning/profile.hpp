// How much is measured: quick, standard, patient.
#pragma once

#include <optional>
#include <string>

#include "tuning/cells.hpp"

namespace assur::tuning {

struct Profile {
  std::string name;
  double seconds = 55;         // for everything; patient: at most
  double most_for_cell = 1;    // s, of these
  bool until_settled = false;  // ends when the regret on what was held out stops falling
  Extent extent;
};

// name: quick, standard or patient; budget: seconds that take the place of the profile's. A small budget samples fewer
// sizes. Throws Error (input) for another name.
[[nodiscard]] Profile profile(const std::string& name, std::optional<double> budget);

}  // namespace assur::tuning
