#include "simulation/run_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "numbers.hpp"

namespace assur {

void check_times(std::span<const double> times) {
  const auto refuse = [](std::size_t k, const std::string& what) {
    throw Error(Error::Kind::input, "time " + std::to_string(k) + " of the run " + what);
  };
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!std::isfinite(times[k])) refuse(k, "is " + std::to_string(times[k]) + "; it must be finite");
    if (k > 0 && times[k] < times[k - 1]) {
      refuse(k,
             "is " + std::to_string(times[k]) + " s, after " + std::to_string(times[k - 1]) + " s; times must ascend");
    }
  }
}

void check_settings(const StepSettings& settings) {
  if (settings.iterations < 0 || settings.most_iterations < 1 || !(settings.seconds >= 0)) {
    throw Error(Error::Kind::input, "StepSettings must have iterations >= 0, most_iterations >= 1 and seconds >= 0");
  }
}

Needs needs_of(const StepSettings& settings) {
  Needs needs;
  needs.add(Need::deadline, settings.seconds > 0);
  return needs;
}

bool evenly_spaced(std::span<const double> times) {
  if (times.size() < 3) return true;
  const double step = times[1] - times[0];
  const double rounding = 4 * kEps * std::max(std::abs(times.front()), std::abs(times.back()));
  for (std::size_t k = 2; k < times.size(); ++k) {
    if (!(std::abs(times[k] - times[k - 1] - step) <= rounding)) return false;
  }
  return step > 0;
}

}  // namespace assur
