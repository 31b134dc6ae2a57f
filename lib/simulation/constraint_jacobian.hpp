// The Jacobian of the equations of groups.
#pragma once

#include <cstdint>
#include <span>

#include "assur/jacobian.hpp"
#include "assur/structure.hpp"

namespace assur {

// groups: indices into Structure::groups, in solving order. posture: all coordinates, internal units.
[[nodiscard]] ConstraintJacobian constraint_jacobian(const Structure& structure, std::span<const std::int32_t> groups,
                                                     std::span<const double> posture);

}  // namespace assur
