#include "measure/race.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "assur/status.hpp"
#include "measure/step_times.hpp"
#include "median.hpp"
#include "numbers.hpp"

namespace assur::measure {
namespace {
constexpr int kMostCalls = 1 << 20;   // in a block, for work that takes no time
constexpr double kShort = 1e-3;       // s; a longer block warms the caches by itself
constexpr double kReady = 4;          // a block takes at least this many times as long as getting ready for it
constexpr double kPrecise = 0.005;    // relative difference of two medians that is too small to matter
constexpr double kMoment = 1e-3;      // s for which a measured slowness of the machine is valid
constexpr double kUneven = 1.3;       // cores differ if one takes this many times as long as another
constexpr int kLooks = 50;            // tries until all cores have the same pace; they mostly take milliseconds
constexpr double kLargeShare = 0.25;  // a call that takes this share of the whole time, or more, is made only once

class Race {
 public:
  Race(std::span<Runner> runners, const RaceRules& rules, const Instruments& with)
      : runners_(runners), rules_(rules), with_(with), end_(with.clock() + rules.seconds) {}

  RaceFigures hold() {
    for (Runner& r : runners_) find_block(r);
    if (rules_.least_blocks > 1) leave_out();
    std::mt19937_64 random(rules_.seed);
    std::vector<std::size_t> order(runners_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (int round = 1; round <= rules_.most_rounds && !over(); ++round) {
      std::shuffle(order.begin(), order.end(), random);
      for (const std::size_t i : order) {
        Runner& r = runners_[i];
        if (r.failed || r.hopeless) continue;
        if (over()) break;
        take(r);
      }
      if (round >= rules_.trial_rounds) dismiss();
      if (round >= rules_.least_rounds && settled()) break;
    }
    // If the time was too short for a single round, only runners with long calls have a time. The others get the time
    // of their last block.
    for (Runner& r : runners_) {
      if (r.seconds.empty() && !r.failed && per_call_.contains(&r)) keep(r);
      if (std::ssize(r.seconds) < rules_.least_blocks) forget(r);
    }
    if (!slowness_.empty()) figures_.slowness = assur::median(slowness_);
    return figures_;
  }

 private:
  // Slowness of the machine, measured again after kMoment.
  double slowness() {
    if (slowness_.empty() || with_.clock() - asked_ >= kMoment) {
      slowness_.push_back(with_.slowness());
      asked_ = with_.clock();
    }
    return slowness_.back();
  }

  [[nodiscard]] bool over() const { return with_.stop() || with_.clock() >= end_; }

  // Seconds of one block, at the usual pace; negative if a call fails. Some workloads find out only here that they
  // cannot run.
  double block(Runner& r) {
    const double before = slowness();
    double begin = 0, end = 0;
    bool ok = false;
    try {
      if (r.calls * per_call_[&r].seconds < kShort) {
        const double start = with_.clock();
        r.work->get_ready(r.calls);
        ready_ = with_.clock() - start;
      }
      const std::int64_t switches = with_.switches(r.threads);
      begin = with_.clock();
      ok = r.work->run(r.calls);
      end = with_.clock();
      switched_ = with_.switches(r.threads) != switches;
    } catch (const Error&) {
      ok = false;
    }
    if (!ok) {
      r.failed = true;
      forget(r);
      return -1;
    }
    figures_.timed += end - begin;
    const double seconds = (end - begin) / (r.by_the_clock ? 1 : (before + slowness()) / 2);
    per_call_[&r] = {seconds / r.calls, (end - begin) / r.calls};
    return seconds;
  }

  // Records the last block as a round.
  void keep(Runner& r) {
    r.seconds.push_back(per_call_[&r].seconds);
    r.raw.push_back(per_call_[&r].raw);
  }

  static void forget(Runner& r) {
    r.seconds.clear();
    r.raw.clear();
  }

  // The first runners start for which there is time for all of their blocks.
  void leave_out() {
    double left = end_ - with_.clock();
    for (Runner& r : runners_) {
      const auto found = per_call_.find(&r);
      const std::ptrdiff_t missing = rules_.least_blocks - std::ssize(r.seconds);
      const double needs =
          found == per_call_.end() ? kInfinity : static_cast<double>(missing) * r.calls * found->second.raw;
      if (r.failed || missing <= 0) continue;
      if (needs > left) {
        r.hopeless = true;
      } else {
        left -= needs;
      }
    }
  }

  // Doubles the calls until a block is long enough for the clock and worth its warming up. A long call is already a
  // round.
  void find_block(Runner& r) {
    if (over()) return;
    for (r.calls = 1;; r.calls *= 2) {
      const double seconds = block(r);
      if (seconds < 0) return;
      if (seconds >= kLargeShare * rules_.seconds) r.hopeless = true;
      if (seconds >= kShort) keep(r);
      if (seconds >= std::max(rules_.block, std::min(kReady * ready_, kShort)) || r.calls >= kMostCalls) return;
    }
  }

  [[nodiscard]] bool even(const Runner& r) const { return r.threads < 2 || with_.unevenness() < kUneven; }

  // Waits a while until the cores have the same pace; false if they do not.
  [[nodiscard]] bool await_even(const Runner& r) const {
    if (r.threads < 2 || !rules_.awaits_even) return true;
    for (int look = 0; look < kLooks && !over(); ++look) {
      if (even(r)) return true;
    }
    return false;
  }

  // One round of a runner. Repeats blocks that other programs interrupted, and blocks of several threads while another
  // guest of the host slowed one core down.
  void take(Runner& r) {
    for (int attempt = 0;; ++attempt) {
      const bool evenly = await_even(r);
      const double seconds = block(r);
      if (seconds < 0) return;
      const bool uneven = !evenly || !even(r);
      ++figures_.blocks;
      figures_.disturbed += switched_ ? 1 : 0;
      figures_.shared += r.threads > 1 ? 1 : 0;
      figures_.uneven += uneven ? 1 : 0;
      if ((switched_ || (uneven && rules_.awaits_even)) && attempt < rules_.repeats &&
          seconds < kLargeShare * rules_.seconds / 10)
        continue;
      keep(r);
      return;
    }
  }

  [[nodiscard]] bool runs(const Runner& r) const { return !r.failed && !r.hopeless && !r.seconds.empty(); }

  // Median of the fastest runner of the heat, for one result, among runners with at most this share.
  [[nodiscard]] double leader(int heat, int share) const {
    double best = kInfinity;
    for (const Runner& r : runners_) {
      if (r.heat == heat && r.share <= share && !r.seconds.empty()) best = std::min(best, r.median() / r.share);
    }
    return best;
  }

  void dismiss() {
    for (Runner& r : runners_) {
      if (!runs(r)) continue;
      const double best = *std::min_element(r.seconds.begin(), r.seconds.end());
      if (best / r.share > rules_.hopeless * leader(r.heat, r.share)) r.hopeless = true;
    }
  }

  // True if in every heat the two fastest differ clearly, or are known so precisely that the difference does not
  // matter.
  [[nodiscard]] bool settled() const {
    struct Time {
      double median, error;
    };
    std::map<int, std::vector<Time>> heats;
    for (const Runner& r : runners_) {
      if (!runs(r)) continue;
      // For normal noise the median has an error of 1.25 sigma / sqrt(rounds), and sigma is 1.48 median deviations.
      const double error = 1.25 * 1.48 * r.spread() / std::sqrt(static_cast<double>(r.seconds.size()));
      heats[r.heat].push_back({r.median() / r.share, error / r.share});
    }
    for (auto& [heat, times] : heats) {
      if (times.size() < 2) continue;
      std::partial_sort(times.begin(), times.begin() + 2, times.end(),
                        [](const Time& a, const Time& b) { return a.median < b.median; });
      const double error = std::hypot(times[0].error, times[1].error);
      const bool apart = times[1].median - times[0].median > 2 * error;
      if (!apart && error > kPrecise * times[0].median) return false;
    }
    return true;
  }

  std::span<Runner> runners_;
  const RaceRules& rules_;
  const Instruments& with_;
  double end_;
  struct Call {
    double seconds = 0, raw = 0;  // time at the usual pace, and by the clock
  };
  std::map<const Runner*, Call> per_call_;  // times of the last block
  std::vector<double> slowness_;            // measured so far
  double asked_ = 0;                        // s, time of the last measurement of the slowness
  double ready_ = 0;                        // s that the last workload took to get ready
  bool switched_ = false;                   // the system interrupted the last block
  RaceFigures figures_;
};

}  // namespace

double Runner::median() const { return seconds.empty() ? kInfinity : assur::median(seconds); }

double Runner::spread() const {
  if (seconds.size() == 1) return seconds[0];
  if (seconds.size() == 2) return std::abs(seconds[1] - seconds[0]);
  std::vector<double> deviations;
  const double middle = median();
  for (const double s : seconds) deviations.push_back(std::abs(s - middle));
  return seconds.empty() ? kInfinity : assur::median(std::move(deviations));
}

double Runner::slowness() const {
  const double usual = raw.empty() ? 0 : median();
  return usual > 0 ? assur::median(raw) / usual : 1;
}

Instruments::Instruments()
    : clock(StepTimes::steady),
      switches(involuntary_switches),
      stop([] { return false; }),
      slowness([] { return 1.0; }),
      unevenness([] { return 1.0; }) {}

RaceFigures race(std::span<Runner> runners, const RaceRules& rules, const Instruments& instruments) {
  return Race(runners, rules, instruments).hold();
}

std::int64_t involuntary_switches(int threads) {
  rusage usage{};
  getrusage(threads > 1 ? RUSAGE_SELF : RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

}  // namespace assur::measure
