// Runs a plan, and owns every workspace that this takes. After construction step() allocates nothing,
// locks nothing, throws nothing and reads no file, except on a reported numerical event, with backends marked steady.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/law.hpp"
#include "assur/plan.hpp"
#include "assur/report.hpp"

namespace assur {

// Results of a run: rows of doubles in SI units, contiguous [time][output].
class Trajectory {
 public:
  [[nodiscard]] const std::vector<std::string>& columns() const {
    return columns_;
  }  // "C.x", "C.vx", "angle.rate", ...
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] std::size_t rows() const { return times_.size(); }
  // Index of a column; throws Error (input) with a list of the columns if there is none of that name.
  [[nodiscard]] std::size_t index(std::string_view column) const;
  [[nodiscard]] std::span<const double> row(std::size_t k) const {
    return {values_.data() + k * columns_.size(), columns_.size()};
  }
  [[nodiscard]] double operator()(std::size_t row, std::size_t column) const {
    return values_[row * columns_.size() + column];
  }
  // In the last row; a trajectory without rows has none.
  [[nodiscard]] double last(std::string_view column) const { return (*this)(rows() - 1, index(column)); }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }  // rows x columns

 private:
  friend class Simulator;
  std::vector<std::string> columns_;
  std::vector<double> times_;
  std::vector<double> values_;
};

// t, then every column: the shortest text that reads back as the same double, nothing for NaN.
void write_csv(std::ostream& out, const Trajectory& trajectory);

// What a control loop asks of one step.
struct StepLimits {
  int iterations = 0;        // exactly this many Newton iterations for each group but those of the first level (the
                             // paper's tEnd2); 0: as many as convergence takes
  int most_iterations = 12;  // then the step is halved
  double seconds = 0;        // deadline of one step by the monotonic clock; 0: none
  // Processors, one for each thread of the strategy (Machine::cores): each thread stays on its own and waits without
  // ever sleeping. Empty: wherever the system puts them.
  std::vector<int> pin_to = {};
};

// How well one group is solved at a posture, and how well it can be.
struct GroupFigures {
  std::int32_t group = 0;      // index into Structure::groups
  double residual = 0;         // the largest |Phi_i| / (sum_j |dPhi_i/dq_j| |q_j| + |constant|)
  double condition = 0;        // how many times as large as the residuals the error of an unknown may be: the maximum
                               // norm of |J^-1| times those sums, over the characteristic length
  double estimated_error = 0;  // of its unknowns, over the characteristic length; those of its inputs included
};

// All that the next steps of a simulator depend on: posture, rates and the older postures that predictions read, the
// turns of angles, what drivers were set to, the equations chosen among redundant ones, and what is known of the
// errors. It may be copied, and outlives its simulator.
class SimulatorState {
 public:
  SimulatorState();
  SimulatorState(const SimulatorState& other);
  SimulatorState(SimulatorState&& other) noexcept;
  SimulatorState& operator=(const SimulatorState& other);
  SimulatorState& operator=(SimulatorState&& other) noexcept;
  ~SimulatorState();

  [[nodiscard]] bool empty() const { return impl_ == nullptr; }
  [[nodiscard]] double time() const;  // NaN if it is empty

 private:
  friend class Simulator;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Simulators share nothing that changes: each thread of the program's may use its own, within a parallel region of
// OpenMP too, with the threads of its plan; one simulator serves one thread at a time, whichever that is. The child of
// a fork() may go on with those that no other thread was using at that moment; they start their threads anew.
//
// With p threads, packs of one level, or chunks, are solved at once: then several threads call callbacks, and those of
// chunks also laws, at the same time. p changes no bit of the motion.
class Simulator {
 public:
  // Throws Error: environment if the plan cannot run here, input for bad limits, numerical if the start has no rates.
  explicit Simulator(Prepared prepared, StepLimits limits = {});
  Simulator(Simulator&&) noexcept;
  Simulator& operator=(Simulator&&) noexcept;
  ~Simulator();

  // The assembled start posture is the state after construction, at the scene's start time.
  [[nodiscard]] double time() const;

  // Moves to time t, which may be earlier than time(), by continuation: the step is halved where needed. On failure the
  // last good posture on the way is kept (time() says which) and the status says why. Code::inaccurate is no failure:
  // time t is reached, and an event says how wrong it may be. What a law or a callback throws comes from here, and then
  // the last good posture is kept too.
  Status step(double t);

  // Control: the driver's value, rate and acceleration at the next step (SI units). `driver` is the name of a driver
  // of an angle, a distance or a coordinate, or one value of a pose: "pose.x", "pose.y", "pose.z", "pose.psi",
  // "pose.theta", "pose.phi" in space, "pose.x", "pose.y", "pose.angle" in the plane, where "pose" is the driver's
  // name; values of a pose that were not set follow their laws. Throws Error (input) for any other name. A value that
  // is not finite fails that step as not_finite, with an event that names the driver; nothing of what was set for it is
  // kept.
  void set(std::string_view driver, double value, double rate = 0, double acceleration = 0);

  // One grid step further with what has been set; the other drivers follow their laws. A step that fails leaves the
  // simulator as it was before: time, posture, rates and all that save() holds, and nothing of what was set for it is
  // kept; status and events say why, and how far the way was open. Controlled drivers that move are first tried to stop
  // at once, where the way back from a limit would lead into it.
  Status step();

  // All that the next steps depend on, and back to it: the same steps follow bit by bit, in this simulator or in
  // another one of the same Prepared, unless a solver had to find another pivot order in between, which changes last
  // bits. What the report says of the run goes on. save() takes no memory if `into` has been saved to before. restore()
  // throws Error (input) if the state is empty or of another Prepared.
  void save(SimulatorState& into);
  [[nodiscard]] SimulatorState save();
  void restore(const SimulatorState& state);

  // Back to the last posture from which the way is open, with all that save() holds: one that was reached by a step
  // which was not divided, so that at most 0.7 of the ball was used in which the posture is known to be the only one
  // (lib/group/branch.hpp). Nothing changes if the posture at hand is one.
  void retreat();

  // From the start over the scene's time grid, or over `times`. Stops at the first failure: what was reached is
  // kept. `observer` (k rows done of n) may return false to stop. Throws Error: input if `times` descend anywhere or
  // are not finite, environment if there is no memory for the rows. Exceptions from laws and callbacks propagate.
  using Observer = std::function<bool(std::int64_t done, std::int64_t of)>;
  Trajectory run(const Observer& observer = {});
  Trajectory run(std::span<const double> times, const Observer& observer = {});

  // Back to the assembled start posture; counters and events are cleared.
  void reset();

  // The outputs at time(), in the order of columns().
  [[nodiscard]] const std::vector<std::string>& columns() const;
  [[nodiscard]] std::span<const double> outputs() const;
  [[nodiscard]] double output(std::string_view column) const;

  // Of every group, at time(). Takes memory and the time of several steps.
  [[nodiscard]] std::vector<GroupFigures> examine();

  [[nodiscard]] const Report& report() const;  // each call updates effort, fallbacks and estimates: do not keep it
  [[nodiscard]] const Prepared& prepared() const;

 private:
  Status go_to(double t);
  [[nodiscard]] bool run_in_chunks(std::span<const double> times, const Observer& observer, Trajectory& out);
  friend std::vector<double> posture_of(const Simulator& simulator);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct ForwardError {  // NaN: no output is of that kind
  double position = ErrorFigures::kUnknown, velocity = ErrorFigures::kUnknown, acceleration = ErrorFigures::kUnknown;
};

// True forward error of a trajectory by a reference in quad precision (113 bits): same parameters, same times, laws and
// residuals in quad, refined with a factorisation in double. Functions of the program are asked as the run asks them:
// the reference is wrong with them. The worst over the outputs of max over the times of |x - x_ref| / max over the run
// |x_ref| (lengths: at least the characteristic length); infinite where x is not finite, but for NaN rates at a kink.
// Throws Error: input (loaded plan, other columns), environment (no quad arithmetic), numerical (it does not converge).
[[nodiscard]] ForwardError forward_error(const Prepared& prepared, const Trajectory& trajectory);

// Proves the posture at time(). Throws Error: input if the plan was loaded, environment if this build has no quad
// arithmetic.
[[nodiscard]] Certificate certify(const Simulator& simulator);

// One for each row. The steps are taken once more, one after the other: rows that do not come out bit by bit (they were
// computed in chunks, with other limits or with drivers that were set) have no certificate. Throws what the above does.
[[nodiscard]] std::vector<Certificate> certify(const Prepared& prepared, const Trajectory& trajectory,
                                               StepLimits limits = {});

}  // namespace assur
