#include "tuning/campaign.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "assur/status.hpp"

namespace assur::tuning {
namespace {

constexpr double kSetupShare = 0.5;    // of a cell's time, after which no more candidates enter
constexpr double kLargestShare = 0.2;  // of a cell's time that one candidate may be expected to take to set up

double per_lane(const Sample& s) { return s.seconds / (s.kernel == Kernel::step ? 1 : s.strategy.lanes); }

}  // namespace

Campaign::Campaign(CampaignOptions options, measure::Instruments instruments)
    : options_(std::move(options)), instruments_(std::move(instruments)), begin_(instruments_.clock()) {}

double Campaign::seconds_left() const { return options_.seconds - (instruments_.clock() - begin_); }

void Campaign::run(const std::vector<Cell>& cells) {
  double weight = 0;
  for (const Cell& cell : cells) weight += cell.weight;
  const std::size_t before = figures_.planned;
  figures_.planned += cells.size();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    figures_.interrupted = instruments_.stop();
    const double left = seconds_left();
    if (figures_.interrupted || left <= 0) break;
    const Cell& cell = cells[i];
    if (options_.progress) options_.progress(options_.seconds - left, before + i, figures_.planned, cell);
    const double share = left * cell.weight / weight;
    weight -= cell.weight;
    CellResult result;
    try {
      const double opened = instruments_.clock();
      const std::unique_ptr<Ground> ground = open(cell, options_.field);
      if (was_stored(*ground)) {
        ++figures_.skipped;
        continue;
      }
      result = measure_cell(cell, *ground, share - (instruments_.clock() - opened));
    } catch (const Error& error) {
      figures_.failures.push_back(to_string(cell) + ": " + error.what());
      continue;
    }
    if (result.results.empty()) continue;
    if (instruments_.stop() && result.cut_short) continue;  // half a cell would look like a whole one
    if (options_.store) options_.store(result);
    ++figures_.measured;
    figures_.samples += static_cast<std::int64_t>(result.results.size());
  }
  figures_.interrupted = instruments_.stop();
  figures_.seconds = instruments_.clock() - begin_;
}

bool Campaign::was_stored(const Ground& ground) const {
  return std::any_of(ground.candidates().begin(), ground.candidates().end(), [&](const Candidate& c) {
    Sample s;
    s.kernel = c.kernel;
    s.shape = ground.shape();
    s.strategy = c.strategy;
    return options_.stored(s);
  });
}

CellResult Campaign::measure_cell(const Cell& cell, Ground& ground, double seconds) {
  const double begin = instruments_.clock(), end = begin + std::max(seconds, 0.0);
  CellResult out;
  out.cell = cell;
  std::vector<Entrant> entrants;
  std::vector<std::pair<Candidate, double>> setups;  // s
  for (const Candidate& candidate : ground.candidates()) {
    const double now = instruments_.clock();
    if (instruments_.stop() || now > begin + kSetupShare * seconds) {
      out.cut_short = true;
      break;
    }
    const std::string hopeless = history_.hopeless(cell.family, candidate, ground.shape().n, kLargestShare * seconds);
    if (!hopeless.empty()) {
      out.refused.push_back({candidate, hopeless});
      continue;
    }
    try {
      for (Entrant& e : ground.enter(candidate)) entrants.push_back(std::move(e));
      setups.emplace_back(candidate, instruments_.clock() - now);
    } catch (const Error& error) {
      out.refused.push_back({candidate, std::string("refused: ") + error.what()});
    }
  }

  std::vector<measure::Runner> runners;
  for (const Entrant& e : entrants) {
    const bool whole = e.kernel == Kernel::step;
    // Meetings are not rivals of each other, nor are the widths of an evaluation.
    const int heat = e.kernel == Kernel::meeting    ? 100 + e.strategy.p
                     : e.kernel == Kernel::evaluate ? 200 + e.strategy.lanes
                                                    : static_cast<int>(e.kernel);
    measure::Runner runner;
    runner.work = e.work;
    runner.heat = heat;
    runner.share = whole ? 1 : e.strategy.lanes;
    runners.push_back(std::move(runner));
  }
  measure::RaceRules rules = options_.race;
  rules.seconds = end - instruments_.clock();
  const measure::RaceFigures race = measure::race(runners, rules, instruments_);
  figures_.race.blocks += race.blocks;
  figures_.race.disturbed += race.disturbed;
  if (instruments_.stop()) out.cut_short = true;

  for (std::size_t i = 0; i < entrants.size(); ++i) {
    const Entrant& e = entrants[i];
    if (runners[i].seconds.empty()) {
      if (runners[i].failed) out.refused.push_back({{e.kernel, e.strategy}, "refused: it failed while it was timed"});
      continue;
    }
    Sample s;
    s.kernel = e.kernel;
    s.shape = e.shape;
    s.strategy = e.strategy;
    s.seconds = runners[i].median();
    s.spread = runners[i].spread();
    s.repetitions = static_cast<std::int64_t>(runners[i].seconds.size()) * runners[i].calls;
    s.backward_error = e.backward_error;
    s.forward_error = e.forward_error;
    out.results.push_back({std::move(s), runners[i].hopeless});
  }

  for (const auto& [candidate, setup] : setups) {
    double leader = std::numeric_limits<double>::infinity();
    const Sample* own = nullptr;
    for (const Result& r : out.results) {
      if (r.sample.kernel != candidate.kernel) continue;
      // As in a race: only those that need no more groups side by side are rivals.
      if (r.sample.strategy.lanes <= candidate.strategy.lanes) leader = std::min(leader, per_lane(r.sample));
      if (r.sample.strategy == candidate.strategy) own = &r.sample;
    }
    if (own != nullptr) {
      history_.note(cell.family, candidate, {static_cast<double>(ground.shape().n), per_lane(*own), leader, setup});
    }
  }
  return out;
}

}  // namespace assur::tuning
