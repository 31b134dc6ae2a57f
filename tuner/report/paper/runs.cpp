#include "report/paper/runs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "assur/machine.hpp"
#include "assur/plan.hpp"
#include "assur/simulator.hpp"
#include "measure/deviation.hpp"
#include "measure/race.hpp"
#include "measure/step_times.hpp"
#include "measure/ways.hpp"
#include "median.hpp"
#include "numbers.hpp"
#include "output/format.hpp"

namespace assur::report {
namespace {

using measure::StepTimes;

constexpr double kPaperStep = 0.01;       // s, dt of the paper
constexpr std::int64_t kSteps = 20000;    // of the grid, tEnd / dt of the paper
constexpr double kCondition = 23;         // upper limit for all these mechanisms
constexpr double kConverged = 8 * kEps;   // residual at which Newton's method ends
constexpr double kVerification = 0.02;    // s for the compared steps; 2 to 50 steps
constexpr double kBlock = 2e-3;           // s, least duration of steps timed together
constexpr double kShort = 0.02;           // s; shorter steps get more rounds and are preceded by untimed steps
constexpr int kRoundsOfTheShort = 7;      // a choice: a median and a spread
constexpr double kSecondsOfTheShort = 2;  // s, most time for them
constexpr double kMeterSeconds = 0.25;    // s; the counters change every millisecond
constexpr double kShareExpected = 0.7;  // share of the time left that is planned, because expected times are uncertain
constexpr double kRoundsAtLeast = 3;    // rounds of all verified contenders, even beyond the time

double worst_residual(const ErrorFigures& e) { return std::fmax(e.residual(), kConverged); }

// The motion for comparison with all others, iterated until it converges.
struct Yardstick {
  std::vector<double> rows;  // steps x columns
  double residual = 0;
};

// A strategy to be timed: steps over the time grid of its scene, repeated from the start at its end.
class GridRun final : public measure::Workload {
 public:
  // iterations: StepSettings::iterations; cores: pins the threads to them if there is one for each thread. Throws Error
  // like Simulator.
  GridRun(const Prepared& prepared, int iterations, const std::vector<int>& cores)
      : grid_(prepared.time()), threads_(most_threads(prepared.plan())) {
    StepSettings settings{.iterations = iterations};
    if (prepared.plan().run.threads > 1 && static_cast<std::size_t>(threads_) <= cores.size()) settings.pin_to = cores;
    pinned_ = !settings.pin_to.empty();
    simulator_.emplace(prepared, settings);
    at_start_ = simulator_->report().counters;
  }

  // Outputs of the first steps: `count` rows of columns(). Throws Error (numerical) if a step fails.
  std::vector<double> first_steps(int count) {
    std::vector<double> rows;
    const double begin = StepTimes::steady();
    for (int k = 0; k < count; ++k) {
      if (!advance()) throw Error(Error::Kind::numerical, std::string(name(simulator_->report().status.code)));
      rows.insert(rows.end(), simulator_->outputs().begin(), simulator_->outputs().end());
    }
    seconds_ = (StepTimes::steady() - begin) / count;
    return rows;
  }

  // Long steps need no warm-up, which would take too long.
  void get_ready(int) override {
    if (seconds_ > kShort) return;
    if (threads_ == 1) {
      (void)advance();
    } else {
      measure::repeat_for(pinned_ ? measure::kUntilAwake : measure::kUntilSpread, [this] { (void)advance(); });
    }
  }
  bool run(int calls) override {
    const double begin = StepTimes::steady();
    bool ok = true;
    for (int i = 0; i < calls; ++i) ok = advance() && ok;
    seconds_ = (StepTimes::steady() - begin) / calls;
    return ok;
  }

  [[nodiscard]] const std::vector<std::string>& columns() const { return simulator_->columns(); }
  [[nodiscard]] const ErrorFigures& error() const { return simulator_->report().error; }
  [[nodiscard]] double seconds() const { return seconds_; }  // of a step in the last run
  [[nodiscard]] double iterations() const {                  // mean of all groups and steps
    const Counters& now = simulator_->report().counters;
    return static_cast<double>(now.newton_iterations - at_start_.newton_iterations) /
           static_cast<double>(std::max<std::int64_t>(now.group_solutions - at_start_.group_solutions, 1));
  }

 private:
  static int most_threads(const Plan& plan) {
    int q = 1;
    for (const Plan::Choice& c : plan.choices) q = std::max(q, c.solver.threads);
    return plan.run.threads * q;
  }
  bool advance() {
    if (next_ > grid_.steps()) {
      simulator_->reset();
      at_start_ = simulator_->report().counters;
      next_ = 1;
    }
    return simulator_->step(grid_.time(next_++)).arrived();
  }

  TimeGrid grid_;
  int threads_;
  bool pinned_ = false;
  std::optional<Simulator> simulator_;
  Counters at_start_;
  std::int64_t next_ = 1;
  double seconds_ = 0;
};

struct Contender {
  PaperTiming timing;
  std::unique_ptr<GridRun> run;
};

class PaperExperiments {
 public:
  explicit PaperExperiments(const PaperOptions& options)
      : options_(options),
        begin_(StepTimes::steady()),
        cores_(this_machine().cores),
        watch_(options.conditions.threads) {
    out_.threads = options.conditions.threads;
    out_.quick = options.conditions.quick;
    out_.stand_ins = stand_ins();
  }

  PaperResults run() {
    std::vector<PaperContest> left = contests(out_.threads, out_.quick, out_.stand_ins);
    std::stable_sort(left.begin(), left.end(),
                     [this](const PaperContest& a, const PaperContest& b) { return least(a) < least(b); });
    while (!left.empty() && !stopped()) {
      hold(left);
      left.erase(left.begin());
    }
    const std::vector<std::string>& devices = out_.stand_ins.devices;
    if (std::find(devices.begin(), devices.end(), "cusolver") != devices.end()) {
      out_.device_parts =
          measure_device_parts(cpu_beside_device(out_.stand_ins.dense, out_.threads), [this] { return stopped(); });
    }
    out_.interrupted = stopped();
    out_.noise = measure::assess(noise());
    return std::move(out_);
  }

 private:
  [[nodiscard]] measure::Noise noise() const {
    measure::Noise noise = watch_.noise();
    noise.disturbed =
        static_cast<double>(blocks_.disturbed) / static_cast<double>(std::max<std::int64_t>(blocks_.blocks, 1));
    std::vector<double> spreads;
    for (const PaperTiming& t : out_.times) {
      if (t.rounds > 2) spreads.push_back(t.spread / t.seconds);
    }
    noise.scatter = spreads.empty() ? 0 : median(std::move(spreads));
    return noise;
  }
  [[nodiscard]] bool stopped() const { return options_.conditions.interrupted(); }
  [[nodiscard]] double elapsed() const { return StepTimes::steady() - begin_; }
  [[nodiscard]] double least(const PaperContest& contest) const {
    double sum = 0;
    for (const Entrant& e : contest.entrants) sum += costs_.least(contest.cell, e);
    return sum;
  }

  // Runs the first of the remaining contests.
  void hold(const std::vector<PaperContest>& left) {
    const PaperContest& contest = left[0];
    const double time_left = options_.conditions.seconds - elapsed();
    const std::vector<std::vector<bool>> chosen = affordable(left, costs_, kShareExpected * time_left);
    double others = 0;
    for (std::size_t c = 1; c < left.size(); ++c) {
      for (std::size_t e = 0; e < left[c].entrants.size(); ++e) {
        if (chosen[c][e]) others += costs_.least(left[c].cell, left[c].entrants[e]);
      }
    }
    const double end = elapsed() + (time_left - others) / static_cast<double>(left.size());

    const Scene scene =
        sample(contest.cell.scene()).with_time({0, kPaperStep * static_cast<double>(kSteps), kPaperStep});
    std::optional<Yardstick> yardstick;
    std::vector<Contender> contenders;
    for (std::size_t e = 0; e < contest.entrants.size() && !stopped(); ++e) {
      const Entrant& entrant = contest.entrants[e];
      Contender c;
      c.timing = {.cell = contest.cell,
                  .version = entrant.version,
                  .split = entrant.split,
                  .strategy = entrant.strategy,
                  .reading = entrant.reading};
      if (!chosen[0][e]) {
        c.timing.why_not = "did not fit into the remaining time: about " +
                           output::duration(costs_.step(contest.cell, entrant)) + " a step";
      } else {
        verify(c, scene, entrant, yardstick);
      }
      contenders.push_back(std::move(c));
    }
    race(contenders, end - elapsed());
    for (std::size_t e = 0; e < contenders.size(); ++e) {
      PaperTiming& t = contenders[e].timing;
      if (contenders[e].run) t.newton = contenders[e].run->iterations();
      if (t.timed()) costs_.learn(contest.cell, contest.entrants[e], t.seconds);
      if (t.timed() && contest.cell.iterations == cells_of_table(4)[0].iterations) weigh(contenders[e]);
      out_.times.push_back(std::move(t));
    }
  }

  [[nodiscard]] PrepareOptions how(const std::string& strategy) const {
    PrepareOptions options{.strategy = strategy, .budget = ThreadBudget{out_.threads}};
    options.model = options_.model;
    return options;
  }

  // Sets c.run if the motion is right, else c.timing.why_not.
  void verify(Contender& c, const Scene& scene, const Entrant& entrant, std::optional<Yardstick>& yardstick) const {
    try {
      if (!yardstick) yardstick = make_yardstick(scene, c.timing.cell);
      const Prepared prepared = prepare(scene, how(entrant.strategy));
      if (entrant.version == kAuto) c.timing.strategy = "auto: " + measure::essence(prepared.plan());
      auto run = std::make_unique<GridRun>(prepared, c.timing.cell.iterations, cores_);
      const auto width = static_cast<std::size_t>(run->columns().size());
      const int steps = std::min(steps_to_verify(costs_.step(c.timing.cell, entrant)),
                                 static_cast<int>(yardstick->rows.size() / width));
      const std::vector<double> rows = run->first_steps(steps);
      const double off = measure::deviation(run->columns(), rows, std::span(yardstick->rows).first(rows.size()));
      c.timing.deviation = off;
      // Bound for the difference of accelerations, the most sensitive outputs, by the residuals of both motions.
      const double bound = 2 * std::max(worst_residual(run->error()), yardstick->residual) * std::pow(kCondition, 3);
      if (!(off <= bound)) {
        c.timing.why_not =
            "wrong: the deviation is " + output::error_figure(off) + ", above the bound " + output::error_figure(bound);
        return;
      }
      c.run = std::move(run);
    } catch (const Error& error) {
      c.timing.why_not = error.what();
    }
  }

  static int steps_to_verify(double step) { return static_cast<int>(std::clamp(kVerification / step, 2.0, 50.0)); }

  // Uses a solver that is fast at all sizes, with a strategy that no entrant has.
  [[nodiscard]] Yardstick make_yardstick(const Scene& scene, const PaperCell& cell) const {
    const Entrant sparse{std::string(kSparse), {}, Reading::shared, "groups/" + out_.stand_ins.sparse};
    GridRun run(prepare(scene, how("global/" + out_.stand_ins.sparse + "+refine")), 0, {});
    Yardstick out;
    out.rows = run.first_steps(steps_to_verify(costs_.step(cell, sparse)));
    out.residual = worst_residual(run.error());
    return out;
  }

  void race(std::vector<Contender>& contenders, double seconds) {
    std::vector<measure::Runner> runners;
    double round = 0;
    for (Contender& c : contenders) {
      if (c.run == nullptr) continue;
      runners.push_back({.work = c.run.get()});
      round += std::max(c.run->seconds(), kBlock);
    }
    take_turns(runners, std::max(seconds, kRoundsAtLeast * round), out_.quick ? 11 : 21);
    take_turns(short_of_rounds(runners), kSecondsOfTheShort, kRoundsOfTheShort);
    for (Contender& c : contenders) {
      for (const measure::Runner& r : runners) {
        if (r.work == c.run.get()) write_down(r, c.timing);
      }
    }
  }

  void take_turns(std::span<measure::Runner> runners, double seconds, int most_rounds) {
    measure::RaceRules rules;
    rules.block = kBlock;
    rules.seconds = seconds;
    rules.least_rounds = std::min(rules.least_rounds, most_rounds);
    rules.most_rounds = most_rounds;
    rules.hopeless = kInfinity;  // slow contenders are timed, too
    const measure::RaceFigures figures = measure::race(runners, rules, options_.conditions.instruments());
    blocks_.blocks += figures.blocks;
    blocks_.disturbed += figures.disturbed;
  }

  // Runners that could have had more rounds without the slow ones; moves them to the end, for another race.
  static std::span<measure::Runner> short_of_rounds(std::vector<measure::Runner>& runners) {
    const auto first = std::stable_partition(runners.begin(), runners.end(), [](const measure::Runner& r) {
      return r.failed || r.median() > kShort || r.seconds.size() >= kRoundsOfTheShort;
    });
    std::for_each(first, runners.end(), [](measure::Runner& r) { r.hopeless = false; });
    return {first, runners.end()};
  }

  void write_down(const measure::Runner& r, PaperTiming& t) const {
    if (r.seconds.empty()) {
      t.why_not = r.failed ? "failed while being timed" : stopped() ? "interrupted" : "no time left";
      return;
    }
    t.seconds = r.median();
    t.spread = r.spread();
    t.rounds = static_cast<int>(r.seconds.size());
    t.steps_timed = static_cast<std::int64_t>(r.seconds.size()) * r.calls;
  }

  // Energy of a run of enough steps for the resolution of the counters.
  void weigh(Contender& c) const {
    if (!options_.meter.why_not().empty() || stopped()) return;
    const int calls = std::max(1, static_cast<int>(std::ceil(kMeterSeconds / c.timing.seconds)));
    const std::vector<std::int64_t> before = options_.meter.read();
    if (!c.run->run(calls)) return;
    c.timing.joules = options_.meter.joules(before, options_.meter.read()) / calls * c.timing.cell.steps;
  }

  const PaperOptions& options_;
  double begin_;
  std::vector<int> cores_;
  measure::NoiseWatch watch_;
  measure::RaceFigures blocks_;
  PaperCosts costs_;
  PaperResults out_;
};

}  // namespace

PaperResults run_the_paper(const PaperOptions& options) { return PaperExperiments(options).run(); }

}  // namespace assur::report
