// The current pace of the machine. If a host shares its cores among guests, everything may take up to twice as long for
// milliseconds or minutes, and a guest has no counter that shows it. The tuner therefore times a fixed piece of work
// between the measurements. All kinds of work slow down alike (bench/README.md), so that its times give the pace for
// all of them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "assur/performance.hpp"
#include "measure/race.hpp"
#include "measure/workload.hpp"
#include "parallel/team.hpp"

namespace assur::measure {

// The fixed piece of work, with its description.
struct FixedWork {
  Kernel kernel;
  Shape shape;
  Strategy strategy;
  std::unique_ptr<Workload> work;
};

// Steps of the legs of a Stewart platform by `eigen`: equations, factorisations and solutions of 15 unknowns.
[[nodiscard]] FixedWork leg_steps();

class Pace {
 public:
  // clock: s. Measures the usual time of a call for `look` seconds: the lower quartile, because other programs only
  // slow the machine down. If `usual` (s) is given, takes it instead. Throws Error (numerical) if the work fails.
  Pace(Workload& work, std::function<double()> clock, double look, std::optional<double> usual = {});

  [[nodiscard]] double usual() const { return usual_; }
  // Current time of the work over its usual time. Takes some 60 us.
  [[nodiscard]] double slowness();

 private:
  [[nodiscard]] double now();  // s of one call

  Workload& work_;
  std::function<double()> clock_;
  int calls_ = 1;  // of a block
  double usual_ = 0;
};

// Compares the paces of cores. If cores of a host run other guests, one core may take twice as long as another, and
// threads that share a step evenly take as long as the slowest.
class CorePaces {
 public:
  // work() makes the work of one thread. One thread runs on each of these processors (Machine::cores); none: a single
  // thread anywhere.
  CorePaces(std::span<const std::int32_t> processors, const std::function<FixedWork()>& work,
            const std::function<double()>& clock);

  // Current time of the slowest core over that of the fastest core. Takes some 100 us.
  [[nodiscard]] double unevenness();

 private:
  Team team_;
  std::vector<FixedWork> works_;
  std::vector<Pace> paces_;  // one of each core
  std::vector<double> slowness_;
};

// Pace and CorePaces of this machine, for races.
class MachinePace {
 public:
  // threads: number of cores to observe, at most all cores. look, usual: see Pace.
  MachinePace(int threads, double look, std::optional<double> usual = {});

  [[nodiscard]] double usual() const { return pace_.usual(); }
  // Connects the instruments of races with this object, which must outlive them.
  void attach(Instruments& instruments);

 private:
  FixedWork work_;
  Pace pace_;
  CorePaces cores_;
};

}  // namespace assur::measure
