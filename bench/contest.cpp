#include "contest.hpp"

#include <algorithm>
#include <cmath>

#include "assur/status.hpp"
#include "assur/strategy.hpp"
#include "decimal.hpp"
#include "median.hpp"

namespace assur::bench {
namespace {

constexpr double kMostResidual = 1e-14;  // a larger one of the equations is wrong; Newton's method ends at 8 eps

void fail(Entry& entry, const std::string& why, bool wrong) {
  entry.failure = why;
  entry.wrong = wrong;
  entry.seconds.clear();
  entry.processor.clear();
  entry.contender.reset();
}

bool one_thread(const Entry& entry) {
  const Strategy strategy = parse_strategy(entry.strategy);
  return strategy.run.threads * strategy.solver.threads == 1;
}

// Compares the result of an entry with that of a reference.
void check(Entry& entry, const Entry& reference, bool all) {
  if (!reference.contender) return fail(entry, "not verified: its reference has no result", false);
  const auto of = [all](const Entry& e) { return all ? e.contender->result() : e.contender->sample(); };
  const double off = deviation(entry.contender->columns(), of(entry), of(reference));
  if (!(off <= entry.deviation)) entry.deviation = off;
  if (!(off <= entry.bound)) {
    fail(entry,
         "WRONG: differs by " + general(off, 2) + " from " + reference.strategy +
             ", allowed: " + general(entry.bound, 2),
         true);
  }
}

void check(std::vector<Entry>& contest) {
  for (std::size_t i = 0; i < contest.size(); ++i) {
    Entry& entry = contest[i];
    if (!entry.contender) continue;
    entry.residual = entry.contender->residual();
    if (!(entry.residual <= kMostResidual)) {
      fail(entry, "WRONG: its equations have the residual " + general(entry.residual, 2), true);
    } else if (entry.alone != Entry::kItself) {
      check(entry, contest[entry.alone], true);
    } else if (entry.base != Entry::kItself) {
      check(entry, contest[entry.base], false);
    }
  }
}

}  // namespace

void hold(std::vector<Entry>& contest, int rounds) {
  std::vector<Cost> costs(contest.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < contest.size(); ++i) {
      if (!contest[i].contender) continue;
      try {
        costs[i] = contest[i].contender->work();
      } catch (const Error& error) {
        fail(contest[i], error.what(), true);
      }
    }
    check(contest);
    for (std::size_t i = 0; i < contest.size(); ++i) {
      if (!contest[i].contender) continue;
      contest[i].seconds.push_back(costs[i].seconds);
      contest[i].processor.push_back(costs[i].processor);
    }
  }
}

Spread spread(const std::vector<double>& values) {
  return {quantile(values, 0.25), median(values), quantile(values, 0.75)};
}

const std::vector<double>& telling(const Entry& entry) { return one_thread(entry) ? entry.processor : entry.seconds; }

Spread speed_up(const Entry& entry, const Entry& of) {
  const bool by_processor = one_thread(entry) && one_thread(of);
  const std::vector<double>& here = by_processor ? entry.processor : entry.seconds;
  const std::vector<double>& there = by_processor ? of.processor : of.seconds;
  std::vector<double> ratios;
  for (std::size_t r = 0; r < std::min(here.size(), there.size()); ++r) ratios.push_back(there[r] / here[r]);
  return spread(ratios);
}

}  // namespace assur::bench
