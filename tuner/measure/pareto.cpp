#include "measure/pareto.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "numbers.hpp"

namespace assur::measure {
namespace {

bool is_known(const Trade& t) { return std::isfinite(t.seconds) && std::isfinite(t.error); }

}  // namespace

std::vector<bool> pareto_front(std::span<const Trade> all) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (is_known(all[i])) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(all[a].seconds, all[a].error) < std::pair(all[b].seconds, all[b].error);
  });
  std::vector<bool> front(all.size(), false);
  Trade last{0, kInfinity};  // the slowest and most accurate row of the front so far
  for (const std::size_t i : order) {
    const bool equal = all[i].seconds == last.seconds && all[i].error == last.error;
    if (!equal && !(all[i].error < last.error)) continue;
    front[i] = true;
    last = all[i];
  }
  return front;
}

}  // namespace assur::measure
