// The table of all solvers. docs/extending.md describes how to add one.
#include <algorithm>
#include <array>

#include "assur/backend.hpp"
#include "backends/backends.hpp"
#include "parallel/thread_state.hpp"

namespace assur {

ASSUR_DECLARE_BACKEND(lapack)
ASSUR_DECLARE_BACKEND(team)
ASSUR_DECLARE_BACKEND(klu)
ASSUR_DECLARE_BACKEND(umfpack)
ASSUR_DECLARE_BACKEND(mumps)
ASSUR_DECLARE_BACKEND(ma27)
ASSUR_DECLARE_BACKEND(cusolver)
ASSUR_DECLARE_BACKEND(magma)

namespace {

constexpr std::array kTable = {
    kEigen,
    ASSUR_BACKEND(lapack, .licence = "BSD-3-Clause", .slowed = blas_slowed, .dense = true, .single = true,
                  .steady = true, .threads = true),
    ASSUR_BACKEND(team, .licence = "BSD-3-Clause", .slowed = blas_slowed, .dense = true, .single = true, .steady = true,
                  .threads = true, .own_loops = true),
    ASSUR_BACKEND(klu, .licence = "LGPL-2.1-or-later", .steady = true, .keeps_pivots = true),
    ASSUR_BACKEND(umfpack, .licence = "GPL-2.0-or-later"),
    ASSUR_BACKEND(mumps, .licence = "CECILL-C", .takes_turns = true),
    kLanes,
    ASSUR_BACKEND(ma27, .licence = "LicenseRef-HSL", .steady = true),
    ASSUR_BACKEND(cusolver, .licence = "LicenseRef-CUDA", .dense = true, .single = true, .fills_lanes = true,
                  .device = true),
    ASSUR_BACKEND(magma, .licence = "BSD-3-Clause", .dense = true, .single = true, .device = true),
};

}  // namespace

std::span<const Backend> backends() { return kTable; }

const Backend& properties_of(std::string_view id) {
  static constexpr Backend kUnknown{};
  const auto* const found = std::find_if(kTable.begin(), kTable.end(), [&](const Backend& b) { return b.id == id; });
  return found == kTable.end() ? kUnknown : *found;
}

}  // namespace assur
