// Closes the drawings of several mechanisms that differ in numbers only, one in each SIMD lane, and moves their drivers
// to their laws: each in one proven step (program/closing_step.hpp). Every lane decides for itself, and its bits depend
// on no other lane.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "equations/lane_array.hpp"
#include "equations/program.hpp"
#include "execute/step_code.hpp"
#include "scene/system.hpp"
#include "structure/walk.hpp"

namespace assur {

class CloseInLanes {
 public:
  // system: any of the mechanisms, without functions and gears; posture: of this one, all coordinates; parts: in
  // solving order, each has as many equations as unknowns; code: null if there is none. Null if a part is too large, or
  // if the posture is singular.
  [[nodiscard]] static std::unique_ptr<CloseInLanes> make(const System& system, std::span<const WalkedPart> parts,
                                                          std::span<const double> posture, int lanes, StepCode* code);

  // Sets the mechanism of a lane: its numbers, and its drawing with the drivers in place (all coordinates).
  void set(std::size_t lane, const System& numbers, std::span<const double> drawing);
  // Then its drivers move: where the known coordinates are in the end, and how far they may leave their chords (all
  // coordinates, see set_strays()).
  void move(std::size_t lane, std::span<const double> end, std::span<const double> strays);
  // Brings all lanes to their ends.
  void run();

  // True if that is proven for a lane, and its posture; if not, a walk may find more.
  [[nodiscard]] bool has_arrived(std::size_t lane) const { return open_[lane] == 0; }
  [[nodiscard]] double at(std::size_t coordinate, std::size_t lane) const { return closed_[coordinate * w_ + lane]; }

 private:
  struct Step {
    std::int32_t group_class = 0;
    Program program;
    std::shared_ptr<const Executor> executor;
  };
  struct Part {
    std::size_t by = 0;  // index of its step
    std::vector<std::int32_t> unknowns, inputs, constants;
    LaneArray coefficients;
  };
  explicit CloseInLanes(std::size_t lanes) : w_(lanes), open_(lanes) {}
  void run_parts();
  void run(Part& part);

  std::size_t w_;
  std::vector<Step> steps_;
  std::vector<Part> parts_;
  LaneArray drawing_, closed_, strays_;  // coordinates x W
  LaneArray end_, strays_to_end_;        // the same, for drivers that move
  bool moves_ = false;                   // some do
  LaneArray open_;                       // W: 0, or positive
  // Of a part: its inputs when all is closed, in the drawing, and how far they may leave their chord; its drawing, the
  // result, one row for each of the two figures; work.
  LaneArray inputs_, drawn_inputs_, stray_inputs_, unknowns_, solved_, stray_, is_open_, work_;
  std::vector<double> constants_;
};

}  // namespace assur
