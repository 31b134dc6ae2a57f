// Follows several mechanisms that differ in numbers only to their start, one in each SIMD lane: drawings close, then
// drivers move to their laws (start/walk_path.hpp). Each step is proven (program/walk_step.hpp). Every lane has steps
// of its own, and its bits depend on no other lane. start/walk.hpp follows one mechanism, wherever that is possible;
// here there are no change points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "equations/system.hpp"
#include "evaluation/coefficients.hpp"
#include "evaluation/lane_array.hpp"
#include "executors/step_code.hpp"
#include "start/walk.hpp"

namespace assur {

class WalkInLanes {
 public:
  // Drivers of the mechanisms.
  class Drivers {
   public:
    virtual ~Drivers() = default;
    // Puts the known coordinates of q where they are at this share of the way of the drivers, and finds how far they
    // may leave their chords since a share before it (set_strays()). q, strays: all coordinates of the lane; unknown
    // ones are unspecified
    virtual void move(std::size_t lane, double before, double share, std::vector<double>& q,
                      std::vector<double>& strays) = 0;
    // True if the drivers have their values there, measured without their equations.
    [[nodiscard]] virtual bool hold(std::size_t lane, const std::vector<double>& q) = 0;
  };

  // system: any of the mechanisms, without functions and gears; posture: of this one, all coordinates; parts: in
  // solving order, each has as many equations as unknowns; code: null if there is none. Null if a part is too large, or
  // if the posture is singular.
  [[nodiscard]] static std::unique_ptr<WalkInLanes> make(const System& system, std::span<const WalkedPart> parts,
                                                         std::span<const double> posture, int lanes, StepCode* code);

  // Sets the mechanism of a lane: its numbers, and its drawing with the drivers in place (all coordinates).
  void set(std::size_t lane, const System& numbers, std::span<const double> drawing, bool drivers_move);
  // Follows the mechanisms that were set since the last call.
  void run(Drivers& drivers);

  // True if a mechanism is at its start, and its posture.
  [[nodiscard]] bool arrived(std::size_t lane) const { return lanes_[lane].stage == Stage::arrived; }
  [[nodiscard]] double at(std::size_t coordinate, std::size_t lane) const { return from_[coordinate * w_ + lane]; }

 private:
  enum class Stage : std::uint8_t { unset, closing, moving, arrived, given_up };
  struct Lane {
    Stage stage = Stage::unset;
    bool drivers_move = false;
    double share = 0, step = 1;  // of the way of this stage; length of the next step
    int steps = 0;               // attempts

    [[nodiscard]] bool is_on_its_way() const { return stage == Stage::closing || stage == Stage::moving; }
    [[nodiscard]] double target() const { return share + step < 1 ? share + step : 1; }
  };
  struct Step {
    std::int32_t number = 0;  // of the class
    GroupClass group_class;
    std::shared_ptr<const Executor> executor;
  };
  struct UnitInLanes {
    std::size_t by = 0;  // index of its step
    std::vector<std::int32_t> unknowns, inputs, constants;
    LaneArray numbers, coefficients;  // x W; numbers: those of `constants`
    LaneArray open, aims;             // n x W: residuals in the drawing, and at the end of the step
  };
  explicit WalkInLanes(std::size_t lanes) : w_(lanes), lanes_(lanes), used_(lanes), left_(lanes), goes_on_(lanes) {}
  void begin_step(std::size_t lane, Drivers& drivers);
  void set_aims();
  void end_step(std::size_t lane, Drivers& drivers);
  void run(UnitInLanes& part, bool is_first);
  [[nodiscard]] bool holds(std::size_t lane, Drivers& drivers);

  std::size_t w_;
  std::vector<Step> steps_;
  std::vector<UnitInLanes> parts_;
  std::vector<std::int32_t> known_, positive_;  // coordinates
  std::vector<Lane> lanes_;
  LaneArray from_, to_, strays_;  // coordinates x W
  LaneArray used_;                // W: largest WalkSlots::used of the parts
  LaneArray left_;                // W: share of the open residuals at the end of the step
  LaneArray goes_on_;             // W: 1 if the lane has made the step, else 0
  // Of a part: its inputs in the end and now, and how far they may leave their chord; its unknowns now and in the end;
  // residuals now; one row for each of the two figures; work.
  LaneArray inputs_, from_inputs_, stray_inputs_, unknowns_, solved_, open_, stray_, use_, work_;
  std::vector<double> one_, one_strays_;  // of one lane
};

}  // namespace assur
