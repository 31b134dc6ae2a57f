#include "parallel/instruction_set.hpp"

#include <hwy/targets.h>

namespace assur {

const char* instruction_set() {
  const auto usable = static_cast<std::int64_t>(hwy::SupportedTargets()) & static_cast<std::int64_t>(HWY_TARGETS);
  return hwy::TargetName(usable & -usable);  // better targets have lower bits
}

}  // namespace assur
