#include "measure/pace.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "assur/machine.hpp"
#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/status.hpp"
#include "dispatch/counts.hpp"
#include "measure/motion.hpp"
#include "measure/step_times.hpp"
#include "plan/preparation.hpp"

namespace assur::measure {
namespace {

constexpr double kBlock = 20e-6;     // s, duration of each of the three timed blocks
constexpr int kMostCalls = 1 << 20;  // in a block, for work that takes no time
constexpr std::int32_t kLegs = 1;    // class of the legs; the other class is the platform

std::vector<std::int32_t> first_cores(int threads) {
  std::vector<std::int32_t> cores = this_machine().cores;
  cores.resize(std::min(cores.size(), static_cast<std::size_t>(threads)));
  return cores;
}

}  // namespace

FixedWork leg_steps() {
  const std::string strategy = "groups/eigen";
  PrepareOptions options;
  options.strategy = strategy;
  options.budget = ThreadBudget{1};
  const Prepared prepared = prepare(sample("stewart"), options);
  const GroupClass& legs = preparation(prepared).structure->classes[kLegs];
  const auto groups =
      std::count_if(preparation(prepared).structure->groups.begin(), preparation(prepared).structure->groups.end(),
                    [](const SolvedGroup& g) { return g.group_class == kLegs; });
  return {Kernel::pack, shape_of(legs, static_cast<std::int32_t>(groups)), parse_strategy(strategy),
          std::make_unique<PackStep>(prepared, kLegs)};
}

Pace::Pace(Workload& work, std::function<double()> clock, double look, std::optional<double> usual)
    : work_(work), clock_(std::move(clock)) {
  while (calls_ < kMostCalls && calls_ * now() < kBlock) calls_ *= 2;
  if (!usual) {
    std::vector<double> looks;
    for (const double begin = clock_(); looks.empty() || clock_() - begin < look;) looks.push_back(now());
    const auto quarter = looks.begin() + static_cast<std::ptrdiff_t>(looks.size() / 4);
    std::nth_element(looks.begin(), quarter, looks.end());
    usual = *quarter;
  }
  usual_ = *usual;
}

double Pace::slowness() { return now() / usual_; }

// The median of three, of which one may be interrupted.
double Pace::now() {
  std::array<double, 3> seconds{};
  for (double& s : seconds) {
    work_.get_ready(calls_);
    const double begin = clock_();
    if (!work_.run(calls_)) throw Error(Error::Kind::numerical, "the work that measures the pace of the machine fails");
    s = (clock_() - begin) / calls_;
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[1];
}

CorePaces::CorePaces(std::span<const std::int32_t> processors, const std::function<FixedWork()>& work,
                     const std::function<double()>& clock)
    : team_(std::max(1, static_cast<int>(processors.size())), processors),
      slowness_(static_cast<std::size_t>(team_.size()), 1) {
  for (int rank = 0; rank < team_.size(); ++rank) {
    works_.push_back(work());
    paces_.emplace_back(*works_.back().work, clock, 0, 1);
  }
}

double CorePaces::unevenness() {
  team_.run([this](int rank) {
    const auto core = static_cast<std::size_t>(rank);
    slowness_[core] = paces_[core].slowness();
  });
  const auto [least, most] = std::minmax_element(slowness_.begin(), slowness_.end());
  return *most / *least;
}

MachinePace::MachinePace(int threads, double look, std::optional<double> usual)
    : work_(leg_steps()),
      pace_(*work_.work, StepTimes::steady, look, usual),
      cores_(first_cores(threads), leg_steps, StepTimes::steady) {}

void MachinePace::attach(Instruments& instruments) {
  instruments.slowness = [this] { return pace_.slowness(); };
  instruments.unevenness = [this] { return cores_.unevenness(); };
}

}  // namespace assur::measure
