// What a run did and how good it is.
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

// Work done, counted: group instances, not calls. Lanes that are idle do not count.
struct Counters {
  std::int64_t steps = 0;                // grid times reached
  std::int64_t substeps = 0;             // accepted steps between grid times
  std::int64_t rejected = 0;             // attempts at a step that failed: it was divided, or ended there
  std::int64_t group_solutions = 0;      // groups solved for their position
  std::int64_t newton_iterations = 0;    // corrections, summed over groups
  std::int64_t most_iterations = 0;      // of one group in one step
  std::int64_t evaluated_equations = 0;  // scalar residuals evaluated
  std::int64_t factorizations = 0;
  std::int64_t factorized_unknowns = 0;  // sum of their orders
  std::int64_t solved_unknowns = 0;      // unknowns obtained by back-substitution, summed over right-hand sides
  std::int64_t branch_checks = 0;        // uniqueness balls measured anew
  std::int64_t stored_values = 0;        // doubles in the trajectory

  Counters& operator+=(const Counters& o);
};

// Relative errors, the worst of the run; docs/accuracy.md defines them. What was not measured is NaN
// (the residuals) or empty, never 0.
struct ErrorFigures {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

  double position = kUnknown;  // max |Phi_i| / (sum |dPhi_i/dq_j| |q_j| + |constant|); NaN: nothing was solved
  // Normwise residuals of the linear systems, |J x - b| / (|J| |x| + |b|) in the maximum norm. A system of which only
  // some unknowns were solved for (the last back-substitution stops at those wanted) has none.
  double velocity = kUnknown;
  double acceleration = kUnknown;
  // Of every output and step, as forward_* are defined, estimated to first order; empty where nobody asked, or no
  // output is of that kind.
  std::optional<double> estimated_position = {};
  std::optional<double> estimated_velocity = {};
  std::optional<double> estimated_acceleration = {};
  std::optional<double> certified_radius = {};  // largest of the proven ones, over the characteristic length
  std::optional<double> forward_position = {};  // against a reference in quad precision
  std::optional<double> forward_velocity = {};
  std::optional<double> forward_acceleration = {};

  // The largest residual; NaN if none was measured.
  [[nodiscard]] double residual() const;
  // The worse of both figures, or the one that is known.
  void merge(const ErrorFigures& o);
};

// What is proven of one computed posture: that within `uniqueness` of it there is exactly one posture which fulfils the
// equations of the scene at this double t with these double parameters, and how near it is. Distances are maximum norms
// over the unknowns that the outputs need, in characteristic lengths (one internal unit; directions: 1). Equations that
// are redundant, and only watched, have no part in it; neither have velocities and accelerations, nor which branch it
// is. Laws that are C++ functions count as exact.
struct Certificate {
  double time = 0;
  double radius = 0;      // largest |computed - true| of an unknown, at most; infinite: nothing is proven
  double uniqueness = 0;  // infinite if all equations are linear
  std::string group;      // where the radius is largest; else the first one without a proof
  std::string why_not;    // there is none; empty: proven
};

// Of a run: the largest radius, with its time and group, and the smallest uniqueness. Of none: nothing is proven.
[[nodiscard]] Certificate worst_of(std::span<const Certificate> certificates);

// Something that happened at a time: a limit reached, a change point passed, ...
struct Event {
  double time = 0;   // where it was noticed
  double until = 0;  // end of the bracket, = time if there is none
  // Or the driver that was set to a value that is not finite, that drives nothing any more, or whose law is wrong; or
  // the constraint of a wrong callback; or the redundant equation that ceased to hold; "": none.
  std::string group;
  Code kind = Code::ok;
  // Residual, contraction, smallest pivot, relative difference of derivatives; of a redundant equation |Phi| / |grad
  // Phi|.
  double figure = 0;
  std::string detail = {};  // which number is wrong, what it is and what it should be; "": nothing more to tell
  std::string unit = {};    // of the figure: "m" or ""
};

struct Report {
  Counters counters;
  Effort effort;  // of all solvers, beyond plain factorisations; lanes of a pack count one by one
  ErrorFigures error;
  Status status;       // ok; inaccurate: the first step in doubt; else why the run stopped
  double reached = 0;  // last time with a valid posture
  std::vector<Event> events;
  std::vector<std::string> fallbacks;  // whatever was done otherwise than planned, with the reason
};

}  // namespace assur
