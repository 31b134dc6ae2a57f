// THE table of solvers. To add one: a file in this folder, a row here, a line in lib/CMakeLists.txt.
#include <array>

#include "assur/backend.hpp"
#include "backends/backends.hpp"
#include "parallel/thread_state.hpp"

namespace assur {
namespace {

// id, why_not, make, steady, keeps_pivots, single, licence, version[, slowed]
constexpr std::array kTable = {
    Backend{"eigen", eigen::why_not, eigen::make, true, false, true, "MPL-2.0", eigen::version},
    Backend{"lapack", lapack::why_not, lapack::make, true, false, true, "BSD-3-Clause", lapack::version, blas_slowed},
    Backend{"team", team::why_not, team::make, true, false, true, "BSD-3-Clause", team::version, blas_slowed},
    Backend{"klu", klu::why_not, klu::make, true, true, false, "LGPL-2.1-or-later", klu::version},
    Backend{"umfpack", umfpack::why_not, umfpack::make, false, false, false, "GPL-2.0-or-later", umfpack::version},
    Backend{"mumps", mumps::why_not, mumps::make, false, false, false, "CECILL-C", mumps::version},
    Backend{"lanes", lanes::why_not, lanes::make, true, true, true, "Apache-2.0", lanes::version},
    Backend{"ma27", ma27::why_not, ma27::make, true, false, false, "LicenseRef-HSL", ma27::version},
};

}  // namespace

std::span<const Backend> backends() { return kTable; }

bool takes_turns(std::string_view id) { return id == "mumps"; }

}  // namespace assur
