// Lowering: from a Scene to a System, with every constraint, driver and body as equations.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "equations/system.hpp"

namespace assur {

// `controlled`: drivers that the program sets itself; they are treated as moving even if their law is constant.
// `declared_groups`: false ignores the declared groups, so that drivers may fix all coordinates.
[[nodiscard]] System lower(std::shared_ptr<const Scene> scene, std::span<const std::string> controlled = {},
                           bool declared_groups = true);

}  // namespace assur
