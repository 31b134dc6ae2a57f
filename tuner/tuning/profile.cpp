#include "tuning/profile.hpp"

#include <algorithm>

#include "assur/status.hpp"

namespace assur::tuning {
namespace {

constexpr double kQuick = 55, kStandard = 285,
                 kPatient = 7200;  // s, for the cells; the whole run takes a few seconds more

// The cells that can be measured in this time on two cores of 2024: about 95 cells of 0.5 s (measured).
Extent extent_for(double seconds) {
  Extent e;
  if (seconds < 5) return {.sizes = 3, .largest = 100, .largest_full = 50, .largest_random = 50, .most_groups = 10};
  if (seconds < 25)
    return {.sizes = 7, .largest = 1000, .largest_full = 200, .largest_random = 150, .most_groups = 100};
  if (seconds < 150) {
    e.most_groups = 1000;
    return e;
  }
  e.sizes = 24;
  e.largest_full = 1600;
  e.largest_random = 500;
  return e;
}

}  // namespace

Profile profile(const std::string& name, std::optional<double> budget) {
  Profile out;
  out.name = name;
  if (name == "quick") {
    out.seconds = kQuick;
  } else if (name == "standard") {
    out.seconds = kStandard;
  } else if (name == "patient") {
    out.seconds = kPatient;
    out.until_settled = true;
  } else {
    throw Error(Error::Kind::input, {{"--profile", "expects quick, standard or patient, not \"" + name + "\""}});
  }
  out.seconds = budget.value_or(out.seconds);
  out.extent = extent_for(out.seconds);
  out.most_for_cell = std::clamp(out.seconds / 100, 0.5, 5.0);
  return out;
}

}  // namespace assur::tuning
