// The report of a run: work done, errors, events and status.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/status.hpp"

namespace assur {

// Work of a run. Groups are counted one by one, even if they are solved side by side; idle lanes do not count.
struct Counters {
  std::int64_t steps = 0;                // steps that reached their time
  std::int64_t substeps = 0;             // accepted steps to intermediate times
  std::int64_t rejected = 0;             // failed attempts at a step; the step was then divided, or ended there
  std::int64_t group_solutions = 0;      // position problems of single groups
  std::int64_t newton_iterations = 0;    // Newton corrections, summed over groups
  std::int64_t most_iterations = 0;      // largest number of corrections of one group in one step
  std::int64_t evaluated_equations = 0;  // scalar residuals
  std::int64_t factorizations = 0;       // factorised matrices
  std::int64_t factorized_unknowns = 0;  // sum of the orders of these matrices
  std::int64_t solved_unknowns = 0;      // unknowns found by back-substitution, summed over right-hand sides
  std::int64_t branch_checks = 0;        // uniqueness balls that were measured
  std::int64_t level_by_level = 0;       // attempts at a step that +together solved level after level
  std::int64_t stored_values = 0;        // doubles in the trajectory

  // Adds each counter; of most_iterations it takes the larger one.
  Counters& operator+=(const Counters& o);
};

// Relative errors, each the largest of the run; docs/accuracy.md defines them. A figure that was not measured is NaN
// (the residuals) or empty (the others), never 0.
struct ErrorFigures {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();  // a residual that was not measured

  double position = kUnknown;  // residual: max over i of |Phi_i| / (sum_j |dPhi_i/dq_j| |q_j| + |constant|)
  // Normwise residual of the linear systems for velocities, |J x - b| / (|J| |x| + |b|) in maximum norms. Systems that
  // are solved for only some of their unknowns are not measured; NaN if all systems are of this kind.
  double velocity = kUnknown;
  double acceleration = kUnknown;  // the same for accelerations
  // Estimated errors of the outputs, defined like forward_position, to first order; empty if no output is of this kind.
  std::optional<double> estimated_position = {};
  std::optional<double> estimated_velocity = {};      // of velocities
  std::optional<double> estimated_acceleration = {};  // of accelerations
  // Largest radius of the certificates of the run, relative to the characteristic length (docs/accuracy.md;
  // `assur inspect` prints it). Simulators leave this figure and the next ones empty; the command fills them from
  // certify() and forward_error().
  std::optional<double> certified_radius = {};
  // True errors of the outputs against a reference in quadruple precision: for each output x (all components of a point
  // or vector together) the maximum over the steps of |x - x_ref|, divided by the maximum of |x_ref|. The divisor has a
  // lower limit (docs/accuracy.md; for lengths the characteristic length).
  std::optional<double> forward_position = {};
  std::optional<double> forward_velocity = {};      // of velocities
  std::optional<double> forward_acceleration = {};  // of accelerations

  // The largest of the three residuals; NaN if none was measured.
  [[nodiscard]] double residual() const;
  // Takes the larger one of each pair of figures; if only one of them is known, that one.
  void merge(const ErrorFigures& o);
};

// A proof about one computed posture (Newton-Kantorovich theorem, docs/accuracy.md). Within the distance `uniqueness`
// there is exactly one posture that satisfies the equations of the scene, for this double time and these double
// parameters; its distance is at most `radius`. Distances are maximum norms over the unknowns that the outputs need,
// in characteristic lengths (components of unit vectors count as they are). The proof does not cover redundant
// equations, velocities, accelerations, and the choice of the branch. Laws that are C++ functions count as exact.
struct Certificate {
  double time = 0;        // time of the posture, s
  double radius = 0;      // bound of |computed - true| for each unknown; infinite: nothing is proven
  double uniqueness = 0;  // radius of the ball with one solution only; infinite if all equations are linear
  std::string group;      // group with the largest radius, or the first group without a proof
  std::string why_not;    // reason why nothing is proven; "": proven
};

// The weakest proof of a run: the certificate with the largest radius, and the smallest uniqueness of all. If there are
// no certificates, the radius is infinite.
[[nodiscard]] Certificate worst_of(std::span<const Certificate> certificates);

// An event at a time: a limit was reached, a change point was passed, ... Successive steps in doubt make one event,
// from the time before the first one to the time of the last one.
struct Event {
  double time = 0;   // s; if the time is known to lie within an interval: its begin
  double until = 0;  // end of that interval, s; equal to `time` if there is no interval
  // Name of the object that the event is about: the group; the driver, if its value is not finite, if it drives nothing
  // any more, or if its law is wrong; the constraint of a wrong callback; the limited quantity; or the redundant
  // equation that no longer holds. "": none.
  std::string group;
  Code kind = Code::ok;  // type of the event
  // Size: as Status::figure; for a redundant equation |Phi| / |grad Phi|; for a limit the bound, in SI units.
  double figure = 0;
  std::string detail = {};  // the wrong number and the expected one, or further explanation; "": none
  // Unit of the figure. Limit: "m", "rad", "m^2", or "1" for a number. Redundant equation: "m" if the violation is a
  // length. Else "": the table of statuses in docs/accuracy.md has the meaning.
  std::string unit = {};
};

// Report of a run, or of single steps: then `status` is that of the last step if it failed, else that of the first
// doubtful one. A run keeps all its events. A control loop may run for days, so single steps keep the latest ones.
struct Report {
  Counters counters;                   // work
  Effort effort;                       // extra work of all solvers; lanes are counted one by one
  ErrorFigures error;                  // largest errors
  Status status;                       // ok; `inaccurate` of the first doubtful step; or the reason why the run stopped
  double reached = 0;                  // last time with a valid posture, s
  std::vector<Event> events;           // in the order in which they were noticed
  std::int64_t dropped_events = 0;     // events that single steps dropped: of 1,000 the oldest 500
  std::vector<std::string> fallbacks;  // deviations from the plan, with their reasons
};

}  // namespace assur
