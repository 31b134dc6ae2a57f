#include "tuning/history.hpp"

#include <algorithm>
#include <cmath>

namespace assur::tuning {
namespace {

constexpr double kFarBehind = 20;  // times as slow as the leader

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

std::string History::hopeless(const std::string& family, const Candidate& candidate, double n, double seconds) const {
  const auto found = entries_.find(key(family, candidate));
  if (found == entries_.end()) return "";
  std::vector<CandidateTimes> smaller;
  for (const CandidateTimes& e : found->second) {
    if (e.n < n) smaller.push_back(e);
  }
  if (smaller.size() < 2) return "";
  const CandidateTimes &a = smaller[smaller.size() - 2], &b = smaller.back();
  const double behind_a = a.seconds / a.leader, behind_b = b.seconds / b.leader;
  if (behind_a > kFarBehind && behind_b > kFarBehind && behind_b > behind_a) return "far behind at smaller sizes";
  if (extended(n, a.n, a.seconds, b.n, b.seconds) > seconds) return "one call takes too long";
  if (extended(n, a.n, a.setup, b.n, b.setup) > seconds) return "its analysis takes too long";
  return "";
}

}  // namespace assur::tuning
