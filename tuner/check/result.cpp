#include "check/result.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace assur::check {
namespace {

void raise(std::optional<double>& worst, const std::optional<double>& value) {
  if (value && !(worst && *worst >= *value)) worst = value;
}

bool fits(const Expected& expected, const Run& run) {
  if (std::find(expected.verdicts.begin(), expected.verdicts.end(), run.verdict) == expected.verdicts.end()) {
    return false;
  }
  return run.verdict != "refused" || run.message.find(expected.message) != std::string::npos;
}

}  // namespace

void Result::add(Run run) {
  ++runs;
  raise(forward_error, run.forward_error);
  raise(backward_error, run.backward_error);
  if (verdict.empty()) {
    verdict = run.verdict;
    // A scene of the user has no expected verdict: all runs have to end like the first.
    if (what.expected.verdicts.empty() && run.verdict != "wrong") what.expected = {{run.verdict}, ""};
  }
  if (fits(what.expected, run)) return;
  if (unexpected.empty()) verdict = run.verdict;
  unexpected.push_back(std::move(run));
}

}  // namespace assur::check
