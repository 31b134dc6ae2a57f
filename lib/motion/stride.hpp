// The step control of motions.
#pragma once

#include "numbers.hpp"

namespace assur {

// Length of the steps to try: halved if a step fails, and multiplied by `growth` after `patience` steps that arrived.
struct Stride {
  double length = kInfinity;
  int patience = 1;
  double growth = 2;
  int arrived = 0;

  void set(double to) {
    length = to;
    arrived = 0;
  }
  void arrive() {
    if (++arrived == patience) set(growth * length);
  }
};

}  // namespace assur
