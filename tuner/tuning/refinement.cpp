#include "tuning/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "numbers.hpp"
#include "tuning/held_out.hpp"

namespace assur::tuning {
namespace {

constexpr std::size_t kAtOnce = 6;     // cells between two models
constexpr double kWorthGoingOn = 0.9;  // the mean regret falls if it is below this share of the least one so far
constexpr double kOfNoAccount = 1e-3;  // and if it is below the least one so far by more than this
constexpr int kModelsWithoutFall = 3;  // ends after this many models in a row without a fall
constexpr double kNeighbours = 1.12;   // least ratio of neighbouring sizes

// The shape halfway between two of a family, whose counts grow as powers of n.
Shape between(const Shape& a, const Shape& b) {
  const auto middle = [](auto x, auto y) {
    const double m = std::sqrt(std::max(1.0, static_cast<double>(x)) * std::max(1.0, static_cast<double>(y)));
    return static_cast<decltype(x)>(std::llround(m));
  };
  Shape out = a;
  out.n = middle(a.n, b.n);
  out.nnz = middle(a.nnz, b.nnz);
  out.fill = middle(a.fill, b.fill);
  out.operations = middle(a.operations, b.operations);
  out.depth = middle(a.depth, b.depth);
  out.terms = middle(a.terms, b.terms);
  out.pattern = 0;
  return out;
}

// Expected relative loss by choosing the best of two predictions, small if they differ by much more than their
// uncertainty: for log-normal times around t1 < t2, the mean of max(0, log t1 - log t2).
double expected_loss(const PerformanceModel& model, const Shape& shape, const std::set<std::string>& strategies,
                     int lanes) {
  struct Expected {
    double seconds = kInfinity, log_factor = 0;
  };
  Expected best, second;
  for (const std::string& text : strategies) {
    const Strategy s = parse_strategy(text);
    if (s.solver.lanes > lanes) continue;
    const Prediction p = model.kernel(Kernel::factor, shape, s);
    const Expected e{p.seconds / s.solver.lanes, std::log(p.factor)};
    if (e.seconds < best.seconds) {
      second = best;
      best = e;
    } else if (e.seconds < second.seconds) {
      second = e;
    }
  }
  if (!std::isfinite(second.seconds)) return 0;
  const double sigma = std::hypot(best.log_factor, second.log_factor);
  if (!(sigma > 0)) return 0;
  const double gap = std::log(second.seconds / best.seconds) / sigma;
  const double density = std::exp(-gap * gap / 2) / std::sqrt(2 * std::acos(-1.0));
  return sigma * (density - gap * std::erfc(gap / std::sqrt(2.0)) / 2);
}

}  // namespace

std::vector<Cell> propose(const PerformanceModel& model, std::span<const CellResult> cells, std::size_t most) {
  std::map<std::string, std::map<std::int32_t, const CellResult*>> families;
  for (const CellResult& c : cells) {
    if (c.cell.kind == Cell::Kind::matrix && c.cell.at && !c.results.empty()) families[c.cell.family][c.cell.n] = &c;
  }
  struct Proposal {
    double loss;
    Cell cell;
  };
  std::vector<Proposal> proposals;
  for (const auto& [family, sizes] : families) {
    for (auto here = sizes.begin(); here != sizes.end() && std::next(here) != sizes.end(); ++here) {
      const CellResult &a = *here->second, &b = *std::next(here)->second;
      Cell cell = a.cell.at(static_cast<std::int32_t>(std::lround(std::sqrt(1.0 * a.cell.n * b.cell.n))));
      if (cell.n < kNeighbours * a.cell.n || b.cell.n < kNeighbours * cell.n) continue;
      std::set<std::string> strategies;
      for (const CellResult* c : {&a, &b}) {
        for (const Result& r : c->results) {
          if (r.sample.kernel == Kernel::factor) strategies.insert(to_string(r.sample.strategy));
        }
      }
      const Shape shape = between(a.results.front().sample.shape, b.results.front().sample.shape);
      double loss = 0;
      for (const int lanes : {1, 16}) loss = std::max(loss, expected_loss(model, shape, strategies, lanes));
      proposals.push_back({loss, std::move(cell)});
    }
  }
  std::stable_sort(proposals.begin(), proposals.end(),
                   [](const Proposal& a, const Proposal& b) { return a.loss > b.loss; });
  std::vector<Cell> out;
  for (Proposal& p : proposals) {
    if (out.size() < most) out.push_back(std::move(p.cell));
  }
  return out;
}

PerformanceModel model_of(std::span<const CellResult> cells) {
  std::vector<Sample> samples;
  for (const CellResult& cell : cells) {
    if (cell.cell.held_out) continue;
    for (const Result& r : cell.results) samples.insert(samples.end(), r.passes.begin(), r.passes.end());
  }
  return PerformanceModel(std::move(samples));
}

void refine(Campaign& campaign, bool until_settled) {
  double least = kInfinity;
  int without_fall = 0;
  while (!campaign.figures().interrupted && campaign.seconds_left() > 0) {
    const PerformanceModel model = model_of(campaign.results());
    if (until_settled) {
      const double now = regret(model, campaign.results()).mean;
      without_fall = now < std::min(kWorthGoingOn * least, least - kOfNoAccount) ? 0 : without_fall + 1;
      least = std::min(least, now);
      if (without_fall == kModelsWithoutFall) return;
    }
    const std::vector<Cell> more = propose(model, campaign.results(), kAtOnce);
    const std::size_t before = campaign.results().size();
    campaign.run(more);
    if (until_settled) {
      campaign.again();
    } else if (campaign.results().size() == before) {
      return;  // all proposals are known already
    }
  }
}

}  // namespace assur::tuning
