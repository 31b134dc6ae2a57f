// Violated equations in the words of a scene, for messages.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// The object of the scene that an equation comes from: "'coupler'", "joint 'C'", "the shape of body 'rod'", "driver
// 'motor'", "the length of vector 'u'".
[[nodiscard]] std::string origin_in_words(const System& system, Index equation);

// "joint 'C' (relative residual 0.012) is violated most, by 0.07 m": the worst of these equations at q, by |Phi| /
// |grad Phi|, in m, or in rad if only directions take part. There must be at least one equation.
[[nodiscard]] std::string most_violated(const System& system, std::span<const Index> equations,
                                        const std::vector<double>& q);

}  // namespace assur
