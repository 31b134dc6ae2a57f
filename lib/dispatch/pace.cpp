#include "dispatch/pace.hpp"

#include "backends/backends.hpp"

namespace assur {

bool follows_pace(const Strategy& s) {
  return s.run.threads == 1 && s.solver.threads == 1 && !properties_of(s.solver.backend).device;
}

Sample slowed(Sample sample, double times) {
  if (!follows_pace(sample.strategy)) return sample;
  sample.seconds *= times;
  sample.spread *= times;
  return sample;
}

}  // namespace assur
