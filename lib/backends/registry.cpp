// THE table of solvers. To add one: a file in this folder, a row here, a line in lib/CMakeLists.txt.
#include <array>

#include "assur/backend.hpp"
#include "backends/backends.hpp"

namespace assur {
namespace {

// id, why_not, make, steady, keeps_pivots, single, licence, version
constexpr std::array kTable = {
    Backend{"eigen", eigen::why_not, eigen::make, true, false, false, "MPL-2.0", eigen::version},
    Backend{"klu", klu::why_not, klu::make, true, true, false, "LGPL-2.1-or-later", klu::version},
    Backend{"lanes", lanes::why_not, lanes::make, true, true, true, "Apache-2.0", lanes::version},
};

}  // namespace

std::span<const Backend> backends() { return kTable; }

}  // namespace assur
