// The wanted outputs as forms and columns.
#pragma once

#include <string>
#include <vector>

#include "scene/system.hpp"

namespace assur {

struct Output {
  std::string name;                     // "C", "rocker_angle", "slider.lambda"
  std::vector<MeasureForms> parts;      // one for each component of a point or vector, one for a measure or a scalar
  bool is_measure = false;              // of the scene; parts then has one element
  bool wanted[3] = {true, true, true};  // value, first and second derivative

  // Highest derivative wanted.
  [[nodiscard]] int derivatives() const { return wanted[2] ? 2 : wanted[1] ? 1 : 0; }
};

// In the order asked for, nothing twice; everything that is not fixed if the scene asks for nothing in particular.
[[nodiscard]] std::vector<Output> wanted_outputs(const System& system);

// Columns of one output in the order value, rate, acceleration: "C.x C.y C.vx ..." or "m m.rate m.acceleration".
void append_columns(const Output& output, std::vector<std::string>& columns);

}  // namespace assur
