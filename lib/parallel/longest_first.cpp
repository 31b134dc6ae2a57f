#include "parallel/longest_first.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "assur/status.hpp"
#include "decimal.hpp"

namespace assur {
namespace {

void check(std::span<const double> cost, int threads) {
  if (threads < 1) {
    throw Error(Error::Kind::input, "packs need at least one thread, not " + std::to_string(threads));
  }
  const auto bad = std::find_if(cost.begin(), cost.end(), [](double c) { return !(c >= 0 && std::isfinite(c)); });
  if (bad != cost.end()) {
    throw Error(Error::Kind::input, "the cost of pack " + std::to_string(bad - cost.begin()) +
                                        " must be a number >= 0, not " + general(*bad, 6));
  }
}

}  // namespace

Shares longest_first(std::span<const double> cost, int threads) {
  check(cost, threads);
  std::vector<std::int32_t> order(cost.size());
  std::iota(order.begin(), order.end(), 0);
  const auto cost_of = [&](std::int32_t pack) { return cost[static_cast<std::size_t>(pack)]; };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return cost_of(a) > cost_of(b); });

  std::vector<double> load(static_cast<std::size_t>(threads), 0.0);
  std::vector<std::vector<std::int32_t>> taken(load.size());
  std::vector<std::size_t> thread(load.size());
  std::iota(thread.begin(), thread.end(), std::size_t{0});
  for (const std::int32_t pack : order) {
    const auto least = *std::min_element(thread.begin(), thread.end(), [&](auto a, auto b) {
      return std::pair(load[a], taken[a].size()) < std::pair(load[b], taken[b].size());
    });
    load[least] += cost_of(pack);
    taken[least].push_back(pack);
  }

  Shares shares;
  shares.makespan = *std::max_element(load.begin(), load.end());
  shares.start.push_back(0);
  for (const auto& packs : taken) {
    shares.pack.insert(shares.pack.end(), packs.begin(), packs.end());
    shares.start.push_back(static_cast<std::int32_t>(shares.pack.size()));
  }
  return shares;
}

}  // namespace assur
