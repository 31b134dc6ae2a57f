#include "tuning/history.hpp"

#include <algorithm>
#include <cmath>

namespace assur::tuning {
namespace {

constexpr double kFarBehind = 20;  // times as slow as the leader
constexpr const char* kLongAnalysis = "its analysis takes too long";

std::string key(const std::string& family, const Candidate& candidate) {
  return family + '/' + std::string(name(candidate.kernel)) + '/' + to_string(candidate.strategy);
}

// Extrapolates to n by the power law through two sizes. Its power is limited to 1 ... 3, because the times are noisy.
double extended(double n, double n1, double t1, double n2, double t2) {
  const double power = std::clamp(std::log(t2 / t1) / std::log(n2 / n1), 1.0, 3.0);
  return t2 * std::pow(n / n2, power);
}

}  // namespace

void History::note(const std::string& family, const Candidate& candidate, const CandidateTimes& entry) {
  auto& entries = entries_[key(family, candidate)];
  const auto place = std::lower_bound(entries.begin(), entries.end(), entry.n,
                                      [](const CandidateTimes& e, double n) { return e.n < n; });
  if (place != entries.end() && place->n == entry.n) {
    *place = entry;
  } else {
    entries.insert(place, entry);
  }
}

std::string History::hopeless(const std::string& family, const Candidate& candidate, double n, double groups,
                              double seconds) const {
  const std::string own = why_hopeless(key(family, candidate), n, groups, seconds);
  if (!own.empty()) return own;
  // Its variants do not make the analysis of a backend shorter, and may be new at this size.
  Candidate plain = candidate;
  plain.strategy.solver = SolverSettings{.backend = candidate.strategy.solver.backend};
  const std::string of_plain = why_hopeless(key(family, plain), n, groups, seconds);
  return of_plain == kLongAnalysis ? of_plain : "";
}

std::string History::why_hopeless(const std::string& key, double n, double groups, double seconds) const {
  const auto found = entries_.find(key);
  if (found == entries_.end()) return "";
  std::vector<CandidateTimes> smaller, timed;
  for (const CandidateTimes& e : found->second) {
    if (e.n == n && e.setup * groups > seconds) return kLongAnalysis;
    if (e.n >= n) continue;
    smaller.push_back(e);
    if (std::isfinite(e.seconds)) timed.push_back(e);
  }
  if (timed.size() >= 2) {
    const CandidateTimes &a = timed[timed.size() - 2], &b = timed.back();
    const double behind_a = a.seconds / a.leader, behind_b = b.seconds / b.leader;
    if (behind_a > kFarBehind && behind_b > kFarBehind && behind_b > behind_a) return "far behind at smaller sizes";
    if (extended(n, a.n, a.seconds, b.n, b.seconds) > seconds) return "one call takes too long";
  }
  if (smaller.size() >= 2) {
    const CandidateTimes &a = smaller[smaller.size() - 2], &b = smaller.back();
    if (groups * extended(n, a.n, a.setup, b.n, b.setup) > seconds) return kLongAnalysis;
  }
  return "";
}

}  // namespace assur::tuning
