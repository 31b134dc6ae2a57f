#include "assur/performance.hpp"

namespace assur {

std::string_view name(Kernel kernel) noexcept {
  constexpr std::string_view kNames[] = {"evaluate", "factor", "solve", "pack", "meeting", "step"};
  return kNames[static_cast<std::size_t>(kernel)];
}

}  // namespace assur
