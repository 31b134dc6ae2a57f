// How fast the machine is at the moment. Where a host shares its cores among guests, everything takes up to twice as
// long for milliseconds or minutes, and nothing that a guest can read tells when: only a fixed piece of work, timed
// among what is measured. Work of all kinds slows down alike (bench/README.md), so its times tell those of others.
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

// A fixed piece of work, and what it is.
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
  // clock: s. Takes `look` seconds for what is usual: the fastest quarter, since others only slow the machine down; or
  // goes by `usual`, s of one call. Throws Error (numerical) if the work fails.
  Pace(Workload& work, std::function<double()> clock, double look, std::optional<double> usual = {});

  [[nodiscard]] double usual() const { return usual_; }
  // How many times as long as usual everything takes now. Takes some 60 us.
  [[nodiscard]] double slowness();

 private:
  [[nodiscard]] double now();  // s of one call

  Workload& work_;
  std::function<double()> clock_;
  int calls_ = 1;  // of a block
  double usual_ = 0;
};

// Whether the cores are at the same pace. Where each core of a host runs another guest beside this one, one may take
// twice as long as another, and threads that share a step evenly as long as the slowest of them.
class CorePaces {
 public:
  // work(): for a thread on each of these processors (Machine::cores); none: a single thread, wherever it is.
  CorePaces(std::span<const std::int32_t> processors, const std::function<FixedWork()>& work,
            const std::function<double()>& clock);

  // How many times as long as on the fastest core it takes on the slowest, now. Takes some 100 us.
  [[nodiscard]] double unevenness();

 private:
  Team team_;
  std::vector<FixedWork> works_;
  std::vector<Pace> paces_;  // one of each core
  std::vector<double> slowness_;
};

// Both, of this machine by the system's clock, for races.
class MachinePace {
 public:
  // threads: a core is watched for each of them, as far as there are cores. look, usual: as for Pace.
  MachinePace(int threads, double look, std::optional<double> usual = {});

  [[nodiscard]] double usual() const { return pace_.usual(); }
  // Has races ask this one, which must outlive them.
  void attach(Instruments& instruments);

 private:
  FixedWork work_;
  Pace pace_;
  CorePaces cores_;
};

}  // namespace assur::measure
