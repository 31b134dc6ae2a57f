// Tiles: mechanisms of one structure in lockstep, one in each SIMD lane. They are members of an ensemble, or one
// mechanism at several times. Every group is a pack whose lanes are the mechanisms.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/report.hpp"
#include "assur/simulator.hpp"
#include "drivers/drive_program.hpp"
#include "errors/error_estimate.hpp"
#include "motion/bows.hpp"
#include "motion/layout.hpp"
#include "motion/motion_conditions.hpp"
#include "motion/state.hpp"
#include "motion/whole_step.hpp"
#include "outputs/angle_turns.hpp"
#include "outputs/output_program.hpp"
#include "outputs/output_steps.hpp"
#include "plan/preparation.hpp"

namespace assur {

// Content of a lane: an instance of the structure of the tile, and its start.
struct Variant {
  std::shared_ptr<const System> system;
  std::vector<double> posture;  // all coordinates, internal units
  double time = 0;
  decltype(Preparation::reselect) reselect;  // as in Preparation
  std::vector<double> limited = {};          // limited quantities, as Preparation::start_limits
  // Set: the system is kept from start to start, and only its numbers change; these say which ones change besides those
  // of groups.
  struct Changes {
    bool outputs, laws, assignments;
  };
  std::optional<Changes> changes = {};
};

// A tile of W lanes.
class Tile {
 public:
  // Throws Error (environment) if a backend of the plan cannot run here.
  Tile(const Preparation& prepared, const StepSettings& settings);
  Tile(const Tile&) = delete;
  Tile& operator=(const Tile&) = delete;

  [[nodiscard]] int lanes() const { return lanes_; }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] const OutputProgram& outputs() const { return outputs_[0]; }

  // Puts 1 to lanes() variants into the lanes and solves their velocities. Drops the variants before. Not ok: the place
  // of the status is the lane that failed, or the first of several.
  [[nodiscard]] Status start(std::span<const Variant* const> variants) { return start(variants, true); }

  // From now on, each start begins with the pivots of this variant instead of choosing pivots: where many variants
  // start and run for a short time, the choice takes longer than the rest.
  void keep_pivots(const Variant& of);

  // Moves every variant to its next time; all steps must be equally long. Steps are not halved: if one fails, all
  // variants keep the last posture, and the place of the status is the lane that failed, or the first of several.
  [[nodiscard]] Status step(std::span<const double> times);

  // The outputs of one variant, as Simulator::outputs().
  void fill_row(int lane, double* row);
  // Sets the turns of angles so that the outputs of the current posture continue this row.
  void continue_from(int lane, std::span<const double> row) {
    turns_.continue_from(row, static_cast<std::size_t>(lane));
    has_outputs_ = false;
  }

  // All coordinates of one variant; coordinates that are not computed have the value of the start.
  [[nodiscard]] std::vector<double> posture(int lane) const;

  // The limited quantities of one variant, as in Preparation::start_limits.
  [[nodiscard]] std::vector<double> limited(int lane) const {
    return conditions_[static_cast<std::size_t>(lane)].limited();
  }
  // Moves the events at limits of one variant to the end of a list.
  void take_events(int lane, std::vector<Event>& to);

  // For every coordinate, a distance within which the solution is unique, from the start posture of the variant or from
  // the last anchor. 0 if unknown.
  [[nodiscard]] std::vector<double> uniqueness(int lane) const;

  // True if the error estimates are out of date; to be called after every step. Then measure them, with the outputs
  // `rows` of each variant.
  [[nodiscard]] bool errors_are_due();
  void measure_errors(std::span<const double> times, std::span<const double* const> rows);
  // Solves the current postures again, and the next ones, as exactly as doubtful errors require. False if they are
  // already as exact, or cannot be solved so exactly.
  [[nodiscard]] bool polish();
  // Includes the last measurement in the errors of the variants.
  void keep_errors();
  // True if the last measured errors of a variant exceed the required accuracy.
  [[nodiscard]] bool in_doubt() const { return estimate_.in_doubt(); }
  // Status of a variant by the last measurement: ok, or inaccurate with the group with the largest errors.
  [[nodiscard]] Status accuracy(int lane) const;
  // Estimates of a variant since start().
  [[nodiscard]] ErrorFigures estimated(int lane) { return estimate_.of_run(static_cast<std::size_t>(lane)); }

  [[nodiscard]] const Counters& counters() const { return counters_; }
  [[nodiscard]] Effort effort() const;
  [[nodiscard]] const ErrorFigures& error() const { return error_; }  // residuals
  void clear_figures();

 private:
  [[nodiscard]] Status start(std::span<const Variant* const> variants, bool alike);
  void find_whole_step();
  void bind(bool alike = true);
  [[nodiscard]] OutputSteps::News bind_programs(std::size_t lane);
  [[nodiscard]] bool drives_at_once(std::span<const double> times) const;
  [[nodiscard]] bool same_laws() const;
  [[nodiscard]] bool same_assignments() const;
  [[nodiscard]] Status drive(std::span<const double> times);
  [[nodiscard]] Status drive_lane(std::size_t lane, double time);
  [[nodiscard]] Status solve(std::span<const double> times, Attempt::Branch branch);
  [[nodiscard]] Status solve_all(std::span<const double> times, Attempt::Branch branch, StepErrors& errors);
  void predict(std::span<const double> times);
  void combine() { state_.predict(prediction_, 0, state_.unknowns()); }
  [[nodiscard]] Attempt usual_attempt(double time, Attempt::Branch branch, double converged) const;
  [[nodiscard]] Status solve_packs(std::span<const double> times, Attempt::Branch branch, double converged,
                                   StepErrors& errors);
  [[nodiscard]] Status check_redundant(std::span<const double> times, Attempt::Branch branch, StepErrors& errors);
  [[nodiscard]] Status check_sets();
  void begin_bows();
  [[nodiscard]] Status check_bows(std::span<const double> times);
  void measure_bows(std::span<const double> times);
  [[nodiscard]] Status check_levers(MotionConditions::Levers which, std::size_t lane, double seconds) const;
  [[nodiscard]] Status follow_angles(double seconds);
  void evaluate_outputs();
  [[nodiscard]] Status begin_limits();
  [[nodiscard]] Status check_limits(std::span<const double> times);
  void accept(std::span<const double> times);
  // Those in use.
  [[nodiscard]] std::span<MotionConditions> conditions() { return std::span(conditions_).first(variants_.size()); }

  std::shared_ptr<const GroupedSystem> structure_;
  StepSettings settings_;
  int lanes_;
  std::shared_ptr<StepCode> code_;  // null: there is none
  Layout layout_;
  std::size_t at_rest_ = 0;           // the first packs: they are solved again only if no time passes
  std::unique_ptr<WholeStep> apart_;  // the step without drivers, and with those of lane 0 for all lanes; null if there
  std::unique_ptr<WholeStep> alike_;  // is no such code, or if it was not needed yet
  bool tried_apart_ = false, tried_alike_ = false;
  WholeStep* whole_ = nullptr;  // one of them; null: there is none
  State::Prediction prediction_;
  bool is_predicted_ = true;  // false: it is left to whole_
  Driven driven_;
  std::vector<Index> driven_coordinates_;
  std::vector<std::optional<DriveProgram>> drive_;  // lanes
  int together_;                                    // angles_together()
  std::size_t driven_lanes_ = 0;    // lanes whose laws were evaluated last; the others have those of the first
  std::size_t lanes_accepted_ = 1;  // the same at the last posture
  std::vector<std::string> columns_;
  std::vector<OutputProgram> outputs_;  // lanes
  OutputSteps output_steps_;
  LaneArray rows_, divisors_;  // columns x lanes, measures x lanes
  bool has_outputs_ = false;   // they are those of the current posture
  AngleTurns turns_;
  std::vector<MotionConditions> conditions_;      // lanes
  std::vector<std::vector<Event>> limit_events_;  // lanes: not taken yet
  ErrorEstimate estimate_;
  State state_;
  Bows bows_;
  std::vector<double> bow_times_;   // lanes: Bows::times()
  bool may_bend_ = false;           // a law of a lane may leave its chord
  bool bends_ = false;              // one does so on the step that bows_ has
  std::array<LaneArray, 3> known_;  // for bows_: known coordinates and their derivatives, in the layout of the state
  std::vector<const Variant*> variants_;     // lanes in use
  std::vector<const System*> bound_to_;      // lanes: system of the programs
  std::vector<std::vector<Output>> wanted_;  // lanes: outputs of that system
  std::vector<double> now_;                  // their times
  bool same_laws_ = false;                   // of the drivers of all lanes
  bool same_assignments_ = false;
  std::int64_t attempts_ = 0;
  Counters counters_;
  Effort effort_;  // effort of solvers that were replaced
  ErrorFigures error_;
  double converged_ = 0;  // residual at which a step counts as solved; 0: as exact as doubles allow
  double left_ = 0;       // largest residual of the last step
};

}  // namespace assur
