// How fast the machine is at the moment. Where a host shares its cores among guests, everything takes up to twice as
// long for milliseconds or minutes, and nothing that a guest can read tells when: only a fixed piece of work, timed
// among what is measured. Work of all kinds slows down alike (bench/README.md), so its times tell those of others.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "assur/performance.hpp"
#include "measure/workload.hpp"

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

}  // namespace assur::measure
