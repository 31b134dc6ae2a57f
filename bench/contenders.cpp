#include "contenders.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "assur/ensemble.hpp"
#include "crowd.hpp"
#include "machine.hpp"

namespace assur::bench {
namespace {

constexpr int kMostWarm = 10;       // untimed first steps: they wake threads and fill caches
constexpr double kShortRun = 0.02;  // s
constexpr std::size_t kSample = 4;  // members that run one by one

// Time since the construction of the object.
class Stopwatch {
 public:
  [[nodiscard]] double seconds() const { return measure::StepTimes::steady() - start_; }
  [[nodiscard]] Cost per(double steps) const {
    return {seconds() / steps, (processor_seconds() - processor_start_) / steps};
  }

 private:
  double processor_start_ = processor_seconds(), start_ = measure::StepTimes::steady();
};

Prepared prepared(const Scene& scene, const Prepare& how) {
  PrepareOptions options;
  options.strategy = how.strategy;
  options.budget = ThreadBudget{how.budget};
  return prepare(scene, options);
}

void expect_ok(const Status& status) {
  if (!status.arrived()) throw Error(Error::Kind::numerical, "a step failed: " + std::string(name(status.code)));
}

class Steps : public Contender {
 public:
  Steps(const Scene& scene, const Prepare& prepare, int steps, const StepSettings& settings, bool times_steps)
      : simulator_(prepared(scene, prepare), settings), steps_(steps) {
    if (times_steps) times_.emplace(0).tick();
  }

  // The motion of the samples continues beyond the end of the grid.
  Cost work() override {
    for (int i = 0; i < std::min(kMostWarm, steps_); ++i) advance();
    const Stopwatch watch;
    if (times_) times_->resume();
    for (int i = 0; i < steps_; ++i) {
      advance();
      if (times_) times_->tick();
    }
    return watch.per(steps_);
  }
  std::span<const double> result() const override { return simulator_.outputs(); }
  const std::vector<std::string>& columns() const override { return simulator_.columns(); }
  double residual() const override { return simulator_.report().error.position; }
  const measure::StepTimes* step_times() const override { return times_ ? &*times_ : nullptr; }

 private:
  void advance() { expect_ok(simulator_.step(simulator_.prepared().scene()->time().time(++k_))); }

  Simulator simulator_;
  int steps_;
  std::int64_t k_ = 0;
  std::optional<measure::StepTimes> times_;
};

class Run : public Contender {
 public:
  Run(const Scene& scene, const Prepare& prepare) : simulator_(prepared(scene, prepare)) {}

  // Runs of a few milliseconds are repeated, so that the state of the caches before them does not count.
  Cost work() override {
    trajectory_ = {};
    const Stopwatch watch;
    double runs = 0;
    do {
      trajectory_ = simulator_.run();
      ++runs;
    } while (watch.seconds() < kShortRun);
    const Cost cost = watch.per(runs * static_cast<double>(trajectory_.rows() - 1));
    expect_ok(simulator_.report().status);
    for (const std::string& fallback : simulator_.report().fallbacks) {
      if (fallback.starts_with("no chunks")) throw Error(Error::Kind::numerical, fallback);
    }
    return cost;
  }
  std::span<const double> result() const override { return trajectory_.values(); }
  const std::vector<std::string>& columns() const override { return simulator_.columns(); }
  double residual() const override { return simulator_.report().error.position; }

 private:
  Simulator simulator_;
  Trajectory trajectory_;
};

std::vector<std::size_t> sampled(std::size_t members) {
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < std::min(kSample, members); ++i) of.push_back(i * members / std::min(kSample, members));
  return of;
}

class Members : public Contender {
 public:
  Members(const std::vector<Scene>& members, const Prepare& prepare)
      : ensemble_(members.size(), [&](std::size_t i) { return prepared(members[i], prepare); }) {}

  Cost work() override {
    const Stopwatch watch;
    trajectory_ = ensemble_.run();
    const std::size_t rows = trajectory_.times().size(), columns = trajectory_.columns().size();
    const Cost cost = watch.per(static_cast<double>(trajectory_.members() * (rows - 1)));
    expect_ok(ensemble_.report().status);
    sample_.clear();
    for (const std::size_t member : sampled(trajectory_.members())) {
      const double* const first = trajectory_.row(member, 0).data();
      sample_.insert(sample_.end(), first, first + rows * columns);
    }
    return cost;
  }
  std::span<const double> result() const override { return trajectory_.values(); }
  std::span<const double> sample() const override { return sample_; }
  const std::vector<std::string>& columns() const override { return trajectory_.columns(); }
  double residual() const override { return ensemble_.report().error.position; }

 private:
  Ensemble ensemble_;
  EnsembleTrajectory trajectory_;
  std::vector<double> sample_;
};

class OneByOne : public Contender {
 public:
  OneByOne(const std::vector<Scene>& members, const Prepare& prepare) {
    for (const std::size_t i : sampled(members.size())) runs_.emplace_back(members[i], prepare);
  }

  Cost work() override {
    Cost mean;
    const auto count = static_cast<double>(runs_.size());
    values_.clear();
    for (Run& run : runs_) {
      const Cost cost = run.work();
      mean.seconds += cost.seconds / count;
      mean.processor += cost.processor / count;
      values_.insert(values_.end(), run.result().begin(), run.result().end());
    }
    return mean;
  }
  std::span<const double> result() const override { return values_; }
  const std::vector<std::string>& columns() const override { return runs_.front().columns(); }
  double residual() const override {
    double worst = 0;
    for (const Run& run : runs_) worst = std::max(worst, run.residual());
    return worst;
  }

 private:
  std::vector<Run> runs_;
  std::vector<double> values_;
};

class Crowded : public Contender {
 public:
  Crowded(std::unique_ptr<Contender> contender, int processes)
      : contender_(std::move(contender)), processes_(processes) {}

  Cost work() override {
    const Crowd crowd(processes_);
    return contender_->work();
  }
  std::span<const double> result() const override { return contender_->result(); }
  const std::vector<std::string>& columns() const override { return contender_->columns(); }
  double residual() const override { return contender_->residual(); }
  const measure::StepTimes* step_times() const override { return contender_->step_times(); }

 private:
  std::unique_ptr<Contender> contender_;
  int processes_;
};

}  // namespace

std::unique_ptr<Contender> make_steps(const Scene& scene, const Prepare& prepare, int steps,
                                      const StepSettings& settings, bool times_steps) {
  return std::make_unique<Steps>(scene, prepare, steps, settings, times_steps);
}

int steps_in(double seconds, const Scene& scene, const std::string& strategy) {
  constexpr int kTrial = 5;
  Steps trial(scene, {strategy, 1}, kTrial, {}, false);
  return static_cast<int>(std::clamp(seconds / trial.work().processor, 1.0, 1e6));
}

std::unique_ptr<Contender> make_run(const Scene& scene, const Prepare& prepare) {
  return std::make_unique<Run>(scene, prepare);
}

std::unique_ptr<Contender> make_ensemble(const std::vector<Scene>& members, const Prepare& prepare) {
  return std::make_unique<Members>(members, prepare);
}

std::unique_ptr<Contender> make_members_one_by_one(const std::vector<Scene>& members, const Prepare& prepare) {
  return std::make_unique<OneByOne>(members, prepare);
}

std::unique_ptr<Contender> in_a_crowd(std::unique_ptr<Contender> contender, int processes) {
  return std::make_unique<Crowded>(std::move(contender), processes);
}

}  // namespace assur::bench
