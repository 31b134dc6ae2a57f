#include "assur/status.hpp"
#include "sweep/design_space.hpp"

namespace assur::sweep {

void sobol(std::uint64_t, std::span<std::uint64_t>) {
  throw Error(Error::Kind::environment,
              "this build has no sampler sobol, because Boost was not found; use --sampler random");
}

}  // namespace assur::sweep
