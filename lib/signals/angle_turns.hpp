// Signed angles along a run: an angle is known up to whole turns from the posture alone, so they are counted from one
// accepted posture to the next one. That is safe as long as the vector behind the angle moves by less than its own
// length: it cannot have gone round the origin. Rates have no part in it: they are without bound towards a fold, and
// are not computed by every plan.
#pragma once

#include <span>
#include <vector>

#include "assur/structure.hpp"
#include "signals/output_program.hpp"

namespace assur {

class AngleTurns {
 public:
  // Of the angles whose values the program puts out; it must outlive this.
  explicit AngleTurns(const OutputProgram& outputs);

  // Nothing to follow.
  [[nodiscard]] bool empty() const { return now_.empty(); }

  // Angles in (-pi, pi]. q: coordinates by address.
  void start(const double* q);

  enum class Way {
    known,
    unknown,  // some vector moved so far, or would have at the speed of the step before: a shorter step may tell
    none,     // some vector is nothing but rounding: no step tells
  };
  // Another posture, a time `seconds` later: is it known how the vectors turned?
  [[nodiscard]] Way follow(const double* q, double seconds);
  // It is accepted. Angles of which too little is known take the shorter way.
  void accept(double seconds);

  // Angles are those of the row, up to what is less than half a turn.
  void continue_from(std::span<const double> row);

  // Whole turns to add to each angle in (-pi, pi].
  [[nodiscard]] const double* turns() const { return turns_.data(); }

  // Of the last accepted posture. Takes no memory once `into` has been taken of the same angles.
  struct Snapshot;
  void save(Snapshot& into) const;
  void restore(const Snapshot& from);

 private:
  struct Arm {
    double x = 0, y = 0;
    // Squares: of its length, of how far its end moved in the last step, and how fast; negative: unknown.
    double square = 0, chord = 0, speed = -1;
  };
  [[nodiscard]] static bool is_short(const Arm& from, const Arm& to, double way);
  [[nodiscard]] bool is_noise(std::size_t i, const Arm& from, const Arm& to, const double* q) const;

  const OutputProgram& outputs_;
  std::vector<std::size_t> columns_;
  std::vector<Arm> now_, next_;
  std::vector<double> turns_;
};

struct AngleTurns::Snapshot {
  std::vector<Arm> arms;
  std::vector<double> turns;
};

// Whole turns from one angle to another, rounded.
[[nodiscard]] double whole_turns(double from, double to);

// Part of what angles of drivers may turn in one step; more than 1: too much. `together`: see angles_together(). A
// radian leaves room for what follows them, which may turn three times as fast without going half round unnoticed.
[[nodiscard]] double turned(std::span<const double> from, std::span<const double> to, int together);

// The most driven angles that one coordinate depends on: the last link of an arm turns by the sum of its joints.
[[nodiscard]] int angles_together(const System& system, const Structure& structure);

}  // namespace assur
