// Whole turns of signed angles along a run. A posture gives an angle up to whole turns, so that turns are counted from
// one accepted posture to the next. This is safe if the vector that defines the angle moves by less than its own
// length, because it cannot have gone round the origin, and if the laws of the drivers have no room for a turn between
// both postures (motion/bows.hpp). Rates are not used: they are unbounded towards a fold, and not every plan computes
// them.
#pragma once

#include <span>
#include <vector>

#include "evaluation/lane_array.hpp"
#include "outputs/angle_kernels.hpp"
#include "outputs/output_program.hpp"
#include "outputs/output_steps.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// The signed angles among the outputs of a mechanism, or of mechanisms of one structure in the lanes of a state.
class AngleTurns {
 public:
  // Follows the angles whose values `outputs` compute, one program for each lane. They must outlive this object.
  explicit AngleTurns(std::span<const OutputProgram> outputs);
  // From now on computes the vectors by the same outputs as step programs, which must outlive this object.
  void use(const OutputSteps& steps) { steps_ = &steps; }

  // True if there is no angle to follow.
  [[nodiscard]] bool empty() const { return count_ == 0; }

  // Begins with angles in (-pi, pi]. q: coordinates by address.
  void start(const double* q);

  // Knowledge about the turns of one step.
  enum class Turned {
    known,
    unknown,  // a vector moved too far, or would have at the speed of the step before; a shorter step may help
    none,     // a vector is as small as rounding, so that its direction is unknown for any step
  };
  struct Followed {
    Turned turned = Turned::known;
    std::size_t lane = 0;  // the first one whose turns are not known
  };
  // Examines another posture, a time `seconds` later. times: factor of the bows in each lane, see measure(); 0: laws
  // are lines. used: number of lanes with mechanisms
  [[nodiscard]] Followed follow(const double* q, double seconds, std::span<const double> times, std::size_t used);
  [[nodiscard]] Turned follow(const double* q, double seconds, double times) {
    return follow(q, seconds, {&times, 1}, 1).turned;
  }
  // Measures how far each vector may leave its way within a step: by the changes of its coordinates that the probes
  // hold. scratch: memory of the size of the state; lane: at which q begins
  void measure(const double* q, std::span<double* const> probes, std::span<double> scratch, std::size_t lane = 0);
  // Accepts that posture. Angles with unknown turns take the shorter way.
  void accept(double seconds);

  // Chooses the turns of a lane so that the angles are those of the row, within half a turn.
  void continue_from(std::span<const double> row, std::size_t lane = 0);

  // Whole turns to add to each angle in (-pi, pi]: angles x lanes.
  [[nodiscard]] const double* turns() const { return turns_.data(); }

  // The turns at the last accepted posture. save() allocates no memory if `into` holds a snapshot of the same angles.
  struct Snapshot {
    LaneArray now, turns, bows;
  };
  void save(Snapshot& into) const;
  void restore(const Snapshot& from);

 private:
  [[nodiscard]] Arms arms(LaneArray& of) const;
  void find_arms(const double* q, LaneArray& to);

  std::span<const OutputProgram> outputs_;
  const OutputSteps* steps_ = nullptr;
  const AngleKernels* kernels_ = &angle_kernels();
  std::vector<std::size_t> columns_;
  std::size_t count_;                   // angles x lanes
  LaneArray now_, next_, probe_;        // the members of Arms, one after the other
  LaneArray turns_, bows_;              // bows_: squares of the largest bows, see measure()
  LaneArray bends_, strays_, nothing_;  // for AngleKernels::follow()
};

// Whole turns from one angle to another, rounded.
[[nodiscard]] double whole_turns(double from, double to);

}  // namespace assur
