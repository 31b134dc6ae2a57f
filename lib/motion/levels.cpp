#include "motion/levels.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "index.hpp"
#include "motion/together.hpp"
#include "parallel/longest_first.hpp"

namespace assur {
namespace {

// Packs on the level with the most packs.
std::size_t widest_level(const std::vector<Pack>& packs) {
  std::ptrdiff_t most = 0;
  for (auto begin = packs.begin(), end = begin; begin != packs.end(); begin = end) {
    end = std::find_if(begin, packs.end(), [&](const Pack& p) { return p.level != begin->level; });
    most = std::max(most, end - begin);
  }
  return static_cast<std::size_t>(most);
}

}  // namespace

Levels::Levels(const Preparation& prepared, Layout& layout, std::span<const int> pin_to)
    : packs_(layout.packs), solvers_(layout.solvers), all_(layout.packs.size()) {
  std::iota(all_.begin(), all_.end(), 0);
  const bool together = prepared.plan.run.together;
  const std::size_t most = together ? Together::shares(*prepared.structure) : widest_level(packs_);
  const auto threads = static_cast<int>(std::min(idx(prepared.plan.run.threads), most));
  if (threads < 2) return;
  schedule(prepared.plan, threads);
  if (phases_.empty() && !together) return;
  if (!phases_.empty()) {
    for (int rank = 1; rank < threads; ++rank) {
      helpers_.push_back(make_solvers(prepared, together ? 1 : 0, prepared.code.get()));
    }
    shares_.resize(idx(threads));
  }
  team_ = std::make_unique<Team>(threads, pin_to);
}

// Plans the phases: levels are shared as planned, and the calling thread does the levels between them. No phases if no
// level is shared.
void Levels::schedule(const Plan& plan, int threads) {
  std::vector<double> cost;
  for (const Pack& pack : packs_) cost.push_back(plan.choices[idx(pack.group_class)].expected_seconds);
  bool any = false;
  Phase alone;
  const auto flush = [&] {
    if (alone.packs.empty()) return;
    alone.start.assign(idx(threads) + 1, static_cast<std::int32_t>(alone.packs.size()));
    alone.start[0] = 0;
    phases_.push_back(std::exchange(alone, {}));
  };
  for (std::size_t begin = 0, end = 0; begin < packs_.size(); begin = end) {
    while (end < packs_.size() && packs_[end].level == packs_[begin].level) ++end;
    const auto level = idx(packs_[begin].level);
    if (end - begin > 1 && (plan.level_threads.empty() || plan.level_threads[level] > 1)) {
      Shares shares = longest_first(std::span(cost).subspan(begin, end - begin), threads);
      flush();
      for (std::int32_t& p : shares.pack) p += static_cast<std::int32_t>(begin);
      phases_.push_back({std::move(shares.pack), std::move(shares.start)});
      any = true;
    } else {
      for (std::size_t p = begin; p < end; ++p) alone.packs.push_back(static_cast<std::int32_t>(p));
    }
  }
  flush();
  if (!any) phases_.clear();
}

GroupSolver& Levels::solver(const Pack& pack, int rank) {
  const auto& solvers = rank == 0 ? solvers_ : helpers_[idx(rank) - 1];
  return *solvers[idx(pack.group_class)];
}

void Levels::restart() {
  for (const auto& s : solvers_) s->restart();
  for (const auto& solvers : helpers_) {
    for (const auto& s : solvers) s->restart();
  }
}

Effort Levels::effort() const {
  Effort sum;
  for (const auto& s : solvers_) sum += s->effort();
  for (const auto& solvers : helpers_) {
    for (const auto& s : solvers) sum += s->effort();
  }
  for (const Pack& pack : packs_) {
    if (pack.solver && !pack.restarts) sum += pack.solver->effort();
  }
  return sum;
}

}  // namespace assur
