// The Jacobian of the equations of groups.
#pragma once

#include <cstdint>
#include <span>

#include "assur/jacobian.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// groups: indices into Structure::groups(), in solving order. posture: all coordinates, internal units.
[[nodiscard]] ConstraintJacobian constraint_jacobian(const GroupedSystem& structure,
                                                     std::span<const std::int32_t> groups,
                                                     std::span<const double> posture);

}  // namespace assur
