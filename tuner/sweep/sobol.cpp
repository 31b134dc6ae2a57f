#include <algorithm>
#include <boost/random/sobol.hpp>

#include "sweep/design_space.hpp"

namespace assur::sweep {

void sobol(std::uint64_t k, std::span<std::uint64_t> point) {
  std::fill(point.begin(), point.end(), 0);
  if (k == 0) return;
  boost::random::sobol sequence(point.size());
  sequence.seed(k - 1);  // the sequence of Boost begins with point 1
  for (std::uint64_t& x : point) x = sequence();
}

}  // namespace assur::sweep
