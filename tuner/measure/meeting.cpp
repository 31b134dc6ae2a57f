#include "measure/meeting.hpp"

#include <chrono>

#include "dispatch/prior.hpp"

namespace assur::measure {

bool Meeting::run(int calls) {
  const std::size_t others = static_cast<std::size_t>(team_.size()) - 1, each = numbers_.size() / others;
  using Clock = std::chrono::steady_clock;
  for (int i = 0; i < calls; ++i) {
    const auto begin = Clock::now();
    while (std::chrono::duration<double>(Clock::now() - begin).count() < kAloneBeforeMeeting) {
    }
    for (double& x : numbers_) x += 1;
    team_.run([&](int rank) {
      if (rank > 0) {
        double* const own = numbers_.data() + (static_cast<std::size_t>(rank) - 1) * each;
        for (std::size_t k = 0; k < each; ++k) own[k] += 1;
      }
      team_.barrier();
    });
  }
  return true;
}

}  // namespace assur::measure
