// What a section of the report is made under.
#pragma once

#include <functional>
#include <string>

#include "measure/race.hpp"

namespace assur::report {

struct Conditions {
  double seconds =
      60;  // to take, about: the smallest piece of a section is always made, no further one that cannot fit
  bool quick = false;
  int threads = 1;  // budget
  std::function<bool()> interrupted = [] { return false; };
  std::function<void(double share, const std::string& what)> progress = [](double, const std::string&) {};

  // For races: they end when the report is interrupted.
  [[nodiscard]] measure::Instruments instruments() const {
    measure::Instruments out;
    out.stop = interrupted;
    return out;
  }
};

}  // namespace assur::report
