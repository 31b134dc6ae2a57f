// The kernels of a mechanism: `evaluate`, `pack` and `step`.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/simulator.hpp"
#include "measure/workload.hpp"
#include "parallel/team.hpp"

namespace assur::measure {

// set_inputs() and evaluate() of a class over `lanes` lanes at the start posture, with the Jacobian.
[[nodiscard]] std::unique_ptr<Workload> evaluation(std::shared_ptr<const GroupedSystem> structure,
                                                   std::int32_t group_class, int lanes);

// One call solves one pack of a class like an ordinary step: a prediction with a small error, one Newton iteration,
// velocity and acceleration. The packs of the class take turns, so that all its groups form the working set. With
// +together one call solves all packs of all classes.
class PackStep final : public Workload {
 public:
  // Throws Error: environment if the plan cannot run here, numerical if the start posture has no velocities or if no
  // prediction takes exactly one iteration.
  PackStep(const Prepared& prepared, std::int32_t group_class);
  ~PackStep() override;

  void get_ready(int calls) override;
  bool run(int calls) override;

  [[nodiscard]] int lanes() const;
  [[nodiscard]] std::size_t packs() const;         // of the class
  [[nodiscard]] const Counters& counters() const;  // work of all calls since construction
  [[nodiscard]] ErrorFigures error() const;        // largest errors of these calls

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Several threads with packs of their own: one call solves one pack on each thread.
class Crowd final : public Workload {
 public:
  // cores: one processor of each core; each thread gets a core if there are enough.
  Crowd(int threads, const std::vector<int>& cores, const std::function<std::unique_ptr<PackStep>()>& make);

  void get_ready(int calls) override;
  bool run(int calls) override;

 private:
  std::vector<std::unique_ptr<PackStep>> steps_;  // threads
  std::vector<std::uint8_t> ok_;                  // threads
  std::vector<int> pin_to_;                       // threads; empty: the system places them
  Team team_;
};

// One call is one step of a whole mechanism over its time grid; after the end it begins again.
class StepWorkload final : public Workload {
 public:
  // cores: a processor of each core; several threads get one each if there are enough. iterations: see StepSettings.
  // Throws Error like Simulator, and (numerical) if the first steps fail.
  explicit StepWorkload(const Prepared& prepared, const std::vector<int>& cores = {}, int iterations = 0);

  void get_ready(int calls) override;
  bool run(int calls) override;

  [[nodiscard]] const Report& report() const { return simulator_.report(); }

 private:
  bool advance();

  std::vector<int> pin_to_;  // empty: one thread, or the system places them
  Simulator simulator_;
  TimeGrid grid_;
  std::int64_t next_ = 1;
};

}  // namespace assur::measure
