#include "tuning/campaign.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "assur/status.hpp"
#include "dispatch/pace.hpp"
#include "dispatch/prior.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur::tuning {
namespace {

constexpr double kSetupShare = 0.5;     // share of a cell's time, after which no more candidates are set up
constexpr double kCrowdBlock = 1e-3;    // s; long compared with the two meetings of the threads in each block
constexpr double kLongestBlock = 5e-4;  // s; other programs interrupt longer ones too often
constexpr int kLeastBlocks = 3;         // the fewest whose median and scatter mean something
constexpr double kMostlyUneven = 0.9;   // share of the blocks of several threads
constexpr std::int64_t kEnoughShared = 20;
constexpr double kMostScatter = 0.5;   // relative spread above which a time of Kernel::around is discarded
constexpr double kSetupCalls = 4;      // of each group, in a setup
constexpr double kLargestShare = 0.2;  // share of a cell's time: most that the setup of one candidate may take

// An error of store(): ends the run, whereas other errors only end a cell.
struct CannotStore {
  Error why;
};

// Time of the setup of a candidate, s, by the prior: it solves all groups a few times. 0 for whole steps and meetings.
double setup_without_samples(const Candidate& c, const Shape& shape, int groups) {
  if (c.kernel != Kernel::factor && c.kernel != Kernel::pack) return 0;
  return kSetupCalls * prior_seconds(c.kernel, shape, c.strategy) * groups / c.strategy.solver.lanes;
}

double per_lane(const Sample& s) {
  return s.seconds / (s.kernel == Kernel::step || s.kernel == Kernel::around ? 1 : s.strategy.solver.lanes);
}

}  // namespace

Campaign::Campaign(CampaignOptions options, measure::Instruments instruments)
    : options_(std::move(options)), instruments_(std::move(instruments)), begin_(instruments_.clock()) {}

void Result::add(Sample pass) {
  const auto faster = [](const Sample& a, const Sample& b) { return a.seconds < b.seconds; };
  passes.insert(std::upper_bound(passes.begin(), passes.end(), pass, faster), std::move(pass));
  sample = passes[(passes.size() - 1) / 2];
}

void add(std::vector<Result>& known, const Result& more) {
  const auto same = std::find_if(known.begin(), known.end(), [&](const Result& r) {
    return r.sample.kernel == more.sample.kernel && r.sample.strategy == more.sample.strategy;
  });
  if (same == known.end()) {
    known.push_back(more);
  } else {
    same->add(more.sample);
  }
}

void add_around(CellResult& cell, std::span<const Entrant> entrants, const Shape& shape) {
  const auto timed = [&](const Entrant& e) -> const Sample* {
    for (const Result& r : cell.results) {
      if (r.sample.kernel == e.kernel && r.sample.shape == e.shape && r.sample.strategy == e.strategy) return &r.sample;
    }
    return nullptr;
  };
  std::vector<Result> found;
  for (std::size_t i = 0; i < entrants.size(); ++i) {
    const Sample* const step = entrants[i].kernel == Kernel::step ? timed(entrants[i]) : nullptr;
    if (step == nullptr) continue;
    Sample s = *step;
    s.kernel = Kernel::around;
    s.shape = shape;
    s.backward_error = s.forward_error = kNan;
    bool all = false;
    for (std::size_t k = i + 1; k < entrants.size() && entrants[k].packs_of_step > 0; ++k) {
      const Entrant& part = entrants[k];
      const Sample* const pack = timed(part);
      s.seconds -= pack != nullptr ? part.packs_of_step * pack->seconds : kInfinity;
      s.spread = pack != nullptr ? std::hypot(s.spread, part.packs_of_step * pack->spread) : kInfinity;
      all = true;
    }
    if (all && s.spread < kMostScatter * s.seconds) found.emplace_back(std::move(s));
  }
  for (Result& r : found) cell.results.push_back(std::move(r));
}

double CampaignFigures::drift() const {
  if (slowness.empty()) return 0;
  std::vector<double> all = slowness;
  std::sort(all.begin(), all.end());
  const std::size_t tenth = all.size() / 10;
  return all[all.size() - 1 - tenth] / all[tenth] - 1;
}

double Campaign::seconds_left() const { return options_.seconds - (instruments_.clock() - begin_); }

template <class Work>
void Campaign::visit(const std::vector<Cell>& cells, double kept, const Work& work) {
  double weight = 0;
  for (const Cell& cell : cells) weight += cell.weight;
  for (const Cell& cell : cells) {
    figures_.interrupted = instruments_.stop();
    const double left = seconds_left() - kept;
    if (figures_.interrupted || left <= 0) break;
    if (options_.progress) options_.progress(options_.seconds - seconds_left(), cell);
    const double share = cell.weight * std::min(left / weight, options_.most_for_cell);
    weight -= cell.weight;
    try {
      const double opened = instruments_.clock();
      const std::unique_ptr<Ground> ground = open(cell, options_.field);
      work(cell, *ground, share - (instruments_.clock() - opened));
    } catch (const CannotStore& failure) {
      throw failure.why;
    } catch (const Error& error) {
      figures_.failures.push_back(to_string(cell) + ": " + error.what());
    }
  }
  figures_.interrupted = instruments_.stop();
  figures_.seconds = instruments_.clock() - begin_;
}

void Campaign::run(const std::vector<Cell>& cells, double kept) {
  figures_.planned += cells.size();
  visit(cells, kept, [&](const Cell& cell, Ground& ground, double seconds) {
    if (is_known(cell, ground)) {
      --figures_.planned;
      return;
    }
    CellResult result = earlier(cell, ground);
    if (result.results.empty()) {
      result = measure_cell(cell, ground, seconds);
      if (instruments_.stop()) return;  // do not store half a cell
    } else {
      ++figures_.earlier;
    }
    if (!result.results.empty()) keep(std::move(result));
  });
}

void Campaign::again() {
  ++figures_.passes;
  std::vector<Cell> cells;
  for (const CellResult& result : results_) cells.push_back(result.cell);
  visit(cells, 0, [&](const Cell& cell, Ground& ground, double seconds) {
    std::vector<Result>& known = results_[static_cast<std::size_t>(&cell - cells.data())].results;
    const CellResult more = measure_cell(cell, ground, seconds);
    if (instruments_.stop()) return;
    for (const Result& r : more.results) add(known, r);
    figures_.samples += static_cast<std::int64_t>(more.results.size());
    store(more);
  });
}

// True if an earlier cell had the same matrices.
bool Campaign::is_known(const Cell& cell, const Ground& ground) const {
  return cell.kind == Cell::Kind::matrix && std::any_of(results_.begin(), results_.end(), [&](const CellResult& r) {
           return r.cell.kind == cell.kind && r.results.front().sample.shape == ground.shape();
         });
}

CellResult Campaign::earlier(const Cell& cell, const Ground& ground) const {
  CellResult out;
  out.cell = cell;
  out.earlier = true;
  for (const Sample& s : options_.earlier) {
    if (!(s.shape == ground.shape())) continue;
    const bool of_this_cell =
        std::any_of(ground.candidates().begin(), ground.candidates().end(), [&](const Candidate& c) {
          const bool same_kernel = c.kernel == s.kernel || (c.kernel == Kernel::factor && s.kernel == Kernel::solve);
          return same_kernel && c.strategy == s.strategy;
        });
    if (of_this_cell) add(out.results, Result(s));
  }
  return out;
}

void Campaign::keep(CellResult result) {
  ++figures_.measured;
  if (result.cut_short) ++figures_.cut_short;
  figures_.samples += static_cast<std::int64_t>(result.results.size());
  results_.push_back(std::move(result));
  if (!results_.back().earlier) store(results_.back());
}

void Campaign::store(const CellResult& result) const {
  if (!options_.store || result.results.empty()) return;
  try {
    options_.store(result);
  } catch (const Error& error) {
    throw CannotStore{error};
  }
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
    const std::string hopeless =
        setup_without_samples(candidate, ground.shape(), cell.groups) > seconds
            ? "its analysis is expected to take too long"
            : history_.hopeless(cell.family, candidate, ground.shape().n, cell.groups, kLargestShare * seconds);
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
    // Meetings, evaluations with several widths, and parts of a step are not compared with each other.
    const int heat = e.kernel == Kernel::meeting    ? 100 + e.strategy.run.threads
                     : e.kernel == Kernel::evaluate ? 200 + e.strategy.solver.lanes
                     : e.packs_of_step > 0          ? 300 + static_cast<int>(runners.size())
                                                    : static_cast<int>(e.kernel);
    measure::Runner runner;
    runner.work = e.work;
    runner.heat = heat;
    runner.share = whole ? 1 : e.strategy.solver.lanes * e.packs_of_call;
    runner.threads = e.strategy.run.threads * e.strategy.solver.threads;
    runner.by_the_clock = !follows_pace(e.strategy);
    runners.push_back(std::move(runner));
  }
  measure::RaceRules rules = options_.race;
  rules.seconds = end - instruments_.clock();
  rules.block = cell.kind == Cell::Kind::crowd
                    ? kCrowdBlock
                    : std::clamp(rules.seconds / static_cast<double>(2 * std::max<std::size_t>(runners.size(), 1) *
                                                                     idx(rules.least_rounds)),
                                 rules.block, kLongestBlock);
  rules.least_blocks = kLeastBlocks;
  // Many cores may never have the same pace.
  const measure::RaceFigures& so_far = figures_.race;
  rules.awaits_even = static_cast<double>(so_far.uneven) < kMostlyUneven * static_cast<double>(so_far.shared) ||
                      so_far.shared < kEnoughShared;
  rules.seed += static_cast<std::uint64_t>(figures_.passes);
  const measure::RaceFigures race = measure::race(runners, rules, instruments_);
  figures_.race.blocks += race.blocks;
  figures_.race.disturbed += race.disturbed;
  figures_.race.shared += race.shared;
  figures_.race.uneven += race.uneven;
  figures_.race.timed += race.timed;
  if (!entrants.empty()) figures_.slowness.push_back(race.slowness);

  for (std::size_t i = 0; i < entrants.size(); ++i) {
    const Entrant& e = entrants[i];
    if (runners[i].seconds.empty()) {
      out.refused.push_back({{e.kernel, e.strategy},
                             runners[i].failed
                                 ? "refused: it failed while being timed"
                                 : "not timed: there was no time for " + std::to_string(kLeastBlocks) + " blocks"});
      continue;
    }
    Sample s;
    s.kernel = e.kernel;
    s.shape = e.shape;
    s.strategy = e.strategy;
    s.seconds = runners[i].median() / e.packs_of_call;
    s.spread = runners[i].spread() / e.packs_of_call;
    s.slowness = runners[i].slowness();
    s.repetitions = static_cast<std::int64_t>(runners[i].seconds.size()) * runners[i].calls;
    s.backward_error = e.backward_error;
    s.forward_error = e.forward_error;
    Result& result = out.results.emplace_back(std::move(s));
    result.rounds = static_cast<int>(runners[i].seconds.size());
    result.hopeless = runners[i].hopeless;
  }

  note(out, ground.shape().n, setups);
  if (ground.around()) add_around(out, entrants, *ground.around());
  return out;
}

void Campaign::note(const CellResult& result, double n, const std::vector<std::pair<Candidate, double>>& setups) {
  for (const auto& [candidate, setup] : setups) {
    double leader = kInfinity;
    const Sample* own = nullptr;
    for (const Result& r : result.results) {
      if (r.sample.kernel != candidate.kernel) continue;
      // As in a race, a candidate is compared only with candidates that need no more groups side by side.
      if (r.sample.strategy.solver.lanes <= candidate.strategy.solver.lanes)
        leader = std::min(leader, per_lane(r.sample));
      if (r.sample.strategy == candidate.strategy) own = &r.sample;
    }
    history_.note(result.cell.family, candidate,
                  {n, own != nullptr ? per_lane(*own) : kInfinity, leader, setup / result.cell.groups});
  }
}

}  // namespace assur::tuning
