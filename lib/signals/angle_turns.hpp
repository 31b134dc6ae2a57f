// Whole turns of signed angles along a run. A posture gives an angle up to whole turns, so that turns are counted from
// one accepted posture to the next. This is safe if the vector that defines the angle moves by less than its own
// length, because it cannot have gone round the origin, and if the laws of the drivers have no room for a turn between
// both postures (path/bows.hpp). Rates are not used: they are unbounded towards a fold, and not every plan computes
// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "assur/structure.hpp"
#include "signals/output_program.hpp"

namespace assur {

// The signed angles among the outputs.
class AngleTurns {
 public:
  // Follows the angles whose values `outputs` computes; it must outlive this object.
  explicit AngleTurns(const OutputProgram& outputs);

  // True if there is no angle to follow.
  [[nodiscard]] bool empty() const { return now_.empty(); }

  // Begins with angles in (-pi, pi]. q: coordinates by address.
  void start(const double* q);

  // Knowledge about the turns of one step.
  enum class Way {
    known,
    unknown,  // a vector moved too far, or would have at the speed of the step before; a shorter step may help
    none,     // a vector is as small as rounding, so that its direction is unknown for any step
  };
  // Examines another posture, a time `seconds` later. times: factor of the bows, see measure(); 0: laws are lines.
  [[nodiscard]] Way follow(const double* q, double seconds, double times);
  // Measures how far each vector may leave its way within a step: by the changes of its coordinates that the probes
  // hold. scratch: memory of the size of the state; lane: of a tile
  void measure(const double* q, std::span<double* const> probes, std::span<double> scratch, std::size_t lane = 0);
  // Accepts that posture. Angles with unknown turns take the shorter way.
  void accept(double seconds);

  // Chooses the turns so that the angles are those of the row, within half a turn.
  void continue_from(std::span<const double> row);

  // Whole turns to add to each angle in (-pi, pi].
  [[nodiscard]] const double* turns() const { return turns_.data(); }

  // The turns at the last accepted posture. save() allocates no memory if `into` holds a snapshot of the same angles.
  struct Snapshot;
  void save(Snapshot& into) const;
  void restore(const Snapshot& from);

 private:
  struct Arm {
    double x = 0, y = 0;
    // Squares of its length, and of the way and speed of its end in the last step; a negative speed is unknown.
    double square = 0, chord = 0, speed = -1;
  };
  [[nodiscard]] static bool is_short(const Arm& from, const Arm& to, double way);
  [[nodiscard]] bool is_noise(std::size_t i, const Arm& from, const Arm& to, const double* q) const;

  const OutputProgram& outputs_;
  std::vector<std::size_t> columns_;
  std::vector<Arm> now_, next_;
  std::vector<double> turns_;
  std::vector<double> bows_;  // squares of the largest bows, see measure()
};

struct AngleTurns::Snapshot {
  std::vector<Arm> arms;
  std::vector<double> turns, bows;
};

// Whole turns from one angle to another, rounded.
[[nodiscard]] double whole_turns(double from, double to);

inline constexpr double kStepOfDrivers = 1;  // rad

// Turn of the angles of drivers in one step, relative to the largest allowed one (kStepOfDrivers in all); more than 1:
// too far. bows: how far the angles may leave their chords, first of all laws. `together`: see angles_together(). With
// this limit, bodies that follow a driver may turn three times as fast without passing half a turn unnoticed. teeth:
// System::teeth, divides the largest turn.
[[nodiscard]] inline double turned(std::span<const double> from, std::span<const double> to,
                                   std::span<const double> bows, int together, int teeth) {
  double sum = 0, largest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double by = std::abs(to[i] - from[i]) + (bows.empty() ? 0 : bows[i]);
    sum += by;
    largest = std::max(largest, by);
  }
  return std::min(sum, together * largest) * teeth / kStepOfDrivers;
}

// The most driven angles that one coordinate depends on: the last link of an arm turns by the sum of its joints.
[[nodiscard]] int angles_together(const System& system, const Structure& structure);

}  // namespace assur
