#include "start/directions.hpp"

#include <cmath>

#include "decimal.hpp"
#include "equations/own_values.hpp"
#include "index.hpp"
#include "scene/triple.hpp"
#include "start/frame_axes.hpp"

namespace assur {

std::string undefined_driver(const System& s, std::span<const double> q) {
  for (const DriverInput& in : s.inputs) {
    const std::string why = why_undefined(s, in, q);
    if (!why.empty()) return "driver " + s.drivers[idx(in.driver)] + " has no angle in the start posture: " + why;
  }
  return "";
}

std::string wrong_axis(const System& s, std::span<const double> q) {
  for (const MeasureForms& m : s.measures) {
    if (m.kind != MeasureForms::Kind::signed_angle || s.dimension == 2) continue;
    Triple axis;
    for (std::size_t k = 0; k < 3; ++k) axis[k] = form_value<double>(s, m.forms[6 + k], q);
    if (std::abs(triple::norm(axis) - 1) <= kSkew) continue;
    return "the axis of measure " + m.name + " has length " + general(triple::norm(axis), 6) +
           " in the start posture; it must be a unit vector";
  }
  return "";
}

}  // namespace assur
