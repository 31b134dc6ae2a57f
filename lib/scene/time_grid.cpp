#include "scene/time_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/names.hpp"

namespace assur {
namespace {

constexpr double kWholeSteps = 1e-9;  // largest error of the number of steps, besides the rounding of times
constexpr double kMostSteps = 1e12;   // hours of computing; doubles count up to it exactly

std::vector<Diagnostic> at(const char* where, std::string what) { return {{where, std::move(what)}}; }

}  // namespace

std::vector<Diagnostic> wrong_grid(const TimeGrid& time) {
  std::vector<Diagnostic> wrong;
  for (const auto& [where, value] :
       {std::pair{"/time/start", time.start}, {"/time/end", time.end}, {"/time/step", time.step}}) {
    if (!std::isfinite(value))
      wrong.push_back({where, "the value is " + shortest(value) + "; a finite number is wanted"});
  }
  if (!wrong.empty() || (time.start == 0 && time.end == 0 && time.step == 0)) return wrong;
  if (!(time.step > 0)) return at("/time/step", "the step is " + shortest(time.step) + " s; it must be > 0");
  if (time.end < time.start) {
    return at("/time/end",
              "the end, " + shortest(time.end) + " s, comes before the start, " + shortest(time.start) + " s");
  }
  const double steps = (time.end - time.start) / time.step;
  const double farthest = std::max(std::abs(time.start), std::abs(time.end));
  const double apart = std::nextafter(farthest, HUGE_VAL) - farthest;  // doubles there; HUGE_VAL for the last ones
  const bool too_long = std::round(steps) == 0 && time.end > time.start;
  const std::string is = "(end - start) / step is " + shortest(steps);
  if (!(steps <= kMostSteps)) {
    return at("/time/step", is + "; more than " + shortest(kMostSteps) + " steps are not possible");
  }
  if (time.step < 16 * apart) {
    return at("/time/step", "the step of " + shortest(time.step) + " s is lost in rounding: around " +
                                shortest(farthest) + " s doubles are " + shortest(apart) +
                                " s apart; take times nearer to 0, or longer steps");
  }
  if (too_long || std::abs(steps - std::round(steps)) > kWholeSteps + 4 * apart / time.step) {
    return at("/time/step", is + "; a whole number of steps is wanted, e.g. to the end " +
                                shortest(time.start + std::ceil(steps) * time.step));
  }
  return {};
}

}  // namespace assur
