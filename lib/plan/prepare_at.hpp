// prepare() with a start posture that is known already.
#pragma once

#include <memory>
#include <vector>

#include "assur/plan.hpp"
#include "structure/at_rest.hpp"

namespace assur {

// The start posture. Redundant equations are chosen there.
struct KnownStart {
  std::vector<double> posture;  // all coordinates, internal units; empty: the posture is assembled from the guess
  double time = 0;              // s
  bool is_first = true;         // false: the functions of the scene have been checked at another posture
  AtRest at_rest = AtRest::left_out;
  std::vector<std::int32_t> checked = {};  // see StructureOptions
};

// like: null, or its plan is taken if the structures are the same.
[[nodiscard]] Prepared prepare_at(const Scene& scene, const PrepareOptions& options, const KnownStart& start,
                                  const Prepared* like = nullptr);

// Its structure alone, in the formulation of `like`.
[[nodiscard]] std::shared_ptr<const Structure> structure_like(const Scene& scene, const PrepareOptions& options,
                                                              const KnownStart& start, const Prepared& like);

}  // namespace assur
