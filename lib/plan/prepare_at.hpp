// prepare() with a start posture that is known already.
#pragma once

#include <memory>
#include <vector>

#include "plan/preparation.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// like: null, or its plan is taken if the structures are the same.
[[nodiscard]] Preparation prepare_at(const Scene& scene, const PrepareOptions& options, const KnownStart& start,
                                     const Preparation* like = nullptr);

// Its structure alone, in the formulation of `like`.
[[nodiscard]] std::shared_ptr<const GroupedSystem> structure_like(const Scene& scene, const PrepareOptions& options,
                                                                  const KnownStart& start, const Preparation& like);

}  // namespace assur
