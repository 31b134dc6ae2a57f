// Outputs that are angles.
#pragma once

#include "equations/outputs.hpp"

namespace assur {

// True for angles and turns, in rad. The direction that turns has an acceleration at least as large as the square of
// the rate, which is a size for errors of the angle's acceleration.
[[nodiscard]] inline bool is_angle(const Output& output) {
  using Kind = MeasureForms::Kind;
  const Kind kind = output.parts().front().kind;
  return kind != Kind::form && kind != Kind::distance && kind != Kind::sum && !is_quaternion(kind);
}

}  // namespace assur
