// Mechanisms of one structure in lockstep, one in each SIMD lane: members of an ensemble, or one mechanism at several
// times. Every group is a pack of its own, whose lanes are the mechanisms.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/simulator.hpp"
#include "errors/error_estimate.hpp"
#include "path/function_check.hpp"
#include "path/independence.hpp"
#include "path/layout.hpp"
#include "path/state.hpp"
#include "path/watch.hpp"
#include "signals/angle_turns.hpp"
#include "signals/drive_program.hpp"
#include "signals/inputs.hpp"
#include "signals/output_program.hpp"

namespace assur {

// What a lane holds: an instance of the tile's structure, and where it starts.
struct Variant {
  std::shared_ptr<const System> system;
  std::vector<double> posture;  // all coordinates, internal units
  double time = 0;
  std::function<Prepared(std::vector<double>, double)> reselect;  // as in Prepared
};

// True if one tile can hold both: the same groups, equations and known coordinates, whatever the constants. Callbacks
// cannot be compared: only copies of one structure share them.
[[nodiscard]] bool same_structure(const Structure& a, const Structure& b);

class Tile {
 public:
  // Throws Error (environment) if a backend of the plan cannot run here.
  Tile(const Prepared& prepared, const StepLimits& limits);
  Tile(const Tile&) = delete;
  Tile& operator=(const Tile&) = delete;

  [[nodiscard]] int lanes() const { return lanes_; }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] const OutputProgram& outputs() const { return outputs_[0]; }

  // Puts 1 to lanes() variants into the lanes and finds their velocities; forgets whatever was there.
  [[nodiscard]] Status start(std::span<const Variant* const> variants);

  // One step of every variant, to its own time; all steps are equally long. Nothing is halved: on failure the last
  // posture is kept.
  [[nodiscard]] Status step(std::span<const double> times);

  // The outputs of one variant, as Simulator::outputs().
  void fill_row(int lane, double* row);
  // Those of the posture at hand are known already: angles go on from there.
  void continue_from(int lane, std::span<const double> row) {
    turns_[static_cast<std::size_t>(lane)].continue_from(row);
  }

  // All coordinates of one variant; those that are not computed as they were at the start.
  [[nodiscard]] std::vector<double> posture(int lane) const;

  // For every coordinate how far another solution surely is from the posture at which a variant was started, or from
  // one measured since: nearer ones are the same. 0 where that is not known.
  [[nodiscard]] std::vector<double> uniqueness(int lane) const;

  // Tell it of every step: is what is known of the errors out of date? Then measure them, for outputs `rows` of each
  // variant.
  [[nodiscard]] bool errors_are_due();
  void measure_errors(std::span<const double> times, std::span<const double* const> rows);
  // The postures at hand once more, and those of the next steps, as well as they are solved where errors are in doubt.
  // False: they are that already, or cannot be.
  [[nodiscard]] bool polish();
  // What was measured counts: as errors of the variants.
  void keep_errors();
  // When they were measured last, errors were larger than was asked for, those of some variant.
  [[nodiscard]] bool in_doubt() const { return estimate_.in_doubt(); }
  // Of a variant, as they were measured: ok, or inaccurate with the group where they are largest.
  [[nodiscard]] Status accuracy(int lane) const;
  // Estimates of a variant since it was put into its lane.
  [[nodiscard]] ErrorFigures estimated(int lane) { return estimate_.of_run(static_cast<std::size_t>(lane)); }

  [[nodiscard]] const Counters& counters() const { return counters_; }
  [[nodiscard]] Effort effort() const;
  [[nodiscard]] const ErrorFigures& error() const { return error_; }  // residuals
  void clear_figures();

 private:
  void bind();
  [[nodiscard]] bool driven_alike() const;
  [[nodiscard]] Status check_functions(std::span<const double> times);
  [[nodiscard]] Status drive(std::span<const double> times);
  [[nodiscard]] Status drive_lane(std::size_t lane, double time);
  [[nodiscard]] Status solve(std::span<const double> times, Attempt::Branch branch);
  [[nodiscard]] Status solve_all(std::span<const double> times, Attempt::Branch branch, StepErrors& errors);
  [[nodiscard]] Status solve_packs(std::span<const double> times, Attempt::Branch branch, double converged,
                                   StepErrors& errors);
  [[nodiscard]] double watched(std::int32_t& worst);
  [[nodiscard]] Status check_watched(std::span<const double> times, Attempt::Branch branch, StepErrors& errors);
  [[nodiscard]] Status check_sets();
  [[nodiscard]] Status check_levers(std::size_t begin, std::size_t end, std::size_t lane, double seconds) const;
  [[nodiscard]] Status begin_angles(std::span<const double> times);
  [[nodiscard]] Status follow_angles(double seconds);
  void accept(std::span<const double> times);

  std::shared_ptr<const Structure> structure_;
  StepLimits limits_;
  int lanes_;
  Layout layout_;
  Driven driven_;
  std::vector<Index> driven_coordinates_;
  std::vector<Lever> levers_;  // those that are known, then those that are solved for
  std::size_t known_levers_ = 0;
  std::vector<std::optional<DriveProgram>> drive_;  // lanes
  int together_;                                    // angles_together()
  std::size_t driven_lanes_ = 0;                    // whose drivers were evaluated last; the others are as the first
  std::vector<std::vector<double>> driven_angles_;  // lanes: of the drivers, at the last posture
  std::size_t lanes_accepted_ = 1;                  // whose driven angles are there; the others' are the first one's
  std::vector<std::string> columns_;
  std::vector<OutputProgram> outputs_;                       // lanes
  std::vector<AngleTurns> turns_;                            // lanes
  std::vector<double> all_divisors_;                         // of the measures, lane after lane
  std::vector<double*> divisors_;                            // lanes: there
  std::vector<std::optional<Watch>> watch_;                  // lanes
  std::vector<std::unique_ptr<Independence>> independence_;  // lanes; null where no other set can be chosen
  std::int64_t measured_at_ = -1;                            // branch checks when the sets were looked at
  std::vector<std::optional<FunctionCheck>> functions_;      // lanes; of equal ones the first; none: nothing to check
  ErrorEstimate estimate_;
  State state_;
  std::vector<const Variant*> variants_;  // lanes in use
  std::vector<double> now_;               // their times
  bool alike_ = false;                    // the drivers of all lanes are the same
  std::int64_t attempts_ = 0;
  Counters counters_;
  Effort effort_;  // of solvers that are gone
  ErrorFigures error_;
  double converged_ = 0;      // residual with which a step counts as solved; 0: as exact as doubles are
  double left_ = 0;           // largest residual of the last step
  double watched_level_ = 0;  // relative residual that the watched equations cannot be brought below
};

}  // namespace assur
