// Motions that are known in closed form: yardsticks where a reference in quad is too large or cannot know the branch.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "assur/scene.hpp"
#include "scene/jet.hpp"

namespace assur::check {

using LongJet = Jet<long double>;  // value, rate and acceleration

// The components of an output (a point, vector or measure) at time t; nothing if it is not known.
using ClosedForm = std::function<std::optional<std::array<LongJet, 3>>(const std::string& output, double t)>;

// "n_four_bar", "parallelograms", "parallelogram" (almost_parallelogram with delta = 0), "equal_slider_crank", or
// "piston" (crank and piston above the origin's rail): of the scene, which is such a mechanism. Throws Error (input)
// for another name.
[[nodiscard]] ClosedForm closed_form(const std::string& name, const Scene& scene);

// In the plane: the point at distance p from P and q from Q, to the left of P -> Q.
[[nodiscard]] std::array<LongJet, 3> meet(const std::array<LongJet, 3>& P, double p, const Triple& Q, double q);

// At `centre`, radius away in the direction of an angle.
[[nodiscard]] std::array<LongJet, 3> on_circle(const Triple& centre, double radius, const LongJet& angle);

}  // namespace assur::check
