// Motions in closed form, for mechanisms that are too large for a reference in quad, or on whose branch it cannot
// decide.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "assur/scene.hpp"
#include "scene/jet.hpp"

namespace assur::check {

using LongJet = Jet<long double>;  // value, rate and acceleration

// The components of an output (a point, vector or measure) at time t; empty if unknown.
using ClosedForm = std::function<std::optional<std::array<LongJet, 3>>(const std::string& output, double t)>;

// The closed form for a scene that is such a mechanism: "n_four_bar", "parallelograms", "parallelogram"
// (almost_parallelogram with delta = 0), "equal_slider_crank", or "piston" (crank and piston above a rail through the
// origin). Throws Error (input) for another name.
[[nodiscard]] ClosedForm closed_form(const std::string& name, const Scene& scene);

// The point in the plane at distance p from P and q from Q, to the left of P -> Q.
[[nodiscard]] std::array<LongJet, 3> meet(const std::array<LongJet, 3>& P, double p, const Triple& Q, double q);

// The point on a circle in the direction of an angle.
[[nodiscard]] std::array<LongJet, 3> on_circle(const Triple& centre, double radius, const LongJet& angle);

}  // namespace assur::check
