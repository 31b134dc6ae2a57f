// Conversion of times to another pace of the machine.
#pragma once

#include <algorithm>

#include "assur/performance.hpp"
#include "dispatch/prior.hpp"

namespace assur {

// Time of a kernel while the machine is `times` as slow. The part of a meeting that waits by the clock does not change.
[[nodiscard]] inline double slowed(Kernel kernel, double seconds, double times) {
  const double fixed = kernel == Kernel::meeting ? std::min(kAloneBeforeMeeting, seconds) : 0;
  return times == 1 ? seconds : fixed + (seconds - fixed) * times;
}

[[nodiscard]] inline Sample slowed(Sample sample, double times) {
  sample.seconds = slowed(sample.kernel, sample.seconds, times);
  sample.spread *= times;
  return sample;
}

}  // namespace assur
