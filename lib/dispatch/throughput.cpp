#include "dispatch/throughput.hpp"

#include <algorithm>

namespace assur {

std::int32_t chunks_for(std::int32_t lanes, std::int32_t threads, std::int64_t steps) {
  const std::int64_t at_once = std::int64_t{lanes} * threads, most = steps / kLeastSteps;
  if (most < lanes) return static_cast<std::int32_t>(std::max<std::int64_t>(most, 1));
  const std::int64_t unit =
      most < at_once ? std::int64_t{lanes} : at_once;  // a fraction of a unit would leave lanes or threads idle
  return static_cast<std::int32_t>(std::min(2 * at_once, most / unit * unit));
}

}  // namespace assur
