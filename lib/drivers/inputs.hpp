// The drivers at a time: laws, and the targets that a program sets instead.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "drivers/drive_program.hpp"
#include "equations/system.hpp"
#include "numbers.hpp"

namespace assur {

// A coordinate that must stay positive, because at 0 its driver drives nothing: a driven distance, or the unknown rho
// of a relative angle.
struct Lever {
  std::int32_t address;  // address of its first lane in a state
  Index driver;          // into System::drivers
  double start = 0;      // value at the start of the run
  double bow = 0;        // how far it may leave its way within a step (motion/bows.hpp)
};

// The first lever that is not positive in the posture `to`, or on the way from the posture `from`, `seconds` earlier;
// 0: the way is not examined. The way is the quintic through both postures. Null: all are positive. [d]: d-th
// derivatives.
[[nodiscard]] const Lever* vanished(std::span<const Lever> levers, const double* const (&from)[3],
                                    const double* const (&to)[3], double seconds);
// A lever that may vanish between both postures unseen, because the laws have room for it; null: there is none. times:
// factor of the bows
[[nodiscard]] const Lever* may_vanish(std::span<const Lever> levers, const double* from, const double* to,
                                      double times);

// The drivers of one mechanism.
class Inputs {
 public:
  Inputs(const System& system, const std::vector<std::string>& controlled);

  // From now on, evaluates only drivers that marked coordinates depend on.
  void keep_only(std::vector<std::uint8_t> needed) { compile(driven_behind(system_, std::move(needed))); }

  // Evaluates the laws by machine code, if there is some for them; after keep_only().
  void use(StepCode& code) { program_.use(code); }

  // Writes the known coordinates at time t; state[d]: d-th derivative, indexed by coordinate.
  [[nodiscard]] Status drive(double t, double* const (&state)[3]) {
    evaluate(t);
    return place(t, state);
  }
  // drive() in two parts. After evaluate() all laws and targets are at hand in the program of the drivers.
  void evaluate(double t);
  [[nodiscard]] Status place(double t, double* const (&state)[3]);
  [[nodiscard]] DriveProgram& program() { return program_; }
  [[nodiscard]] const DriveProgram& program() const { return program_; }

  // From now on, drive() follows the second-order expansions of all laws and targets about time t, until follow().
  void expand_about(double t);
  void follow() { expanded_about_ = kNan; }

  // After drive(): sets the derivatives of the known coordinates by the value of a controlled driver, in SI units, as
  // state[1].
  void differentiate(std::size_t control, double* const (&state)[3]);

  // True if this law of the system is needed, and no target was set instead.
  [[nodiscard]] bool follows_law(std::size_t input, std::size_t law) const;

  // The target to which this law of the system is set, in SI units; null if the law is followed.
  [[nodiscard]] const Motion* command(std::size_t input, std::size_t law) const;
  // The inputs of the system that are evaluated, ascending.
  [[nodiscard]] const std::vector<Index>& evaluated() const { return evaluated_; }

  // DriveProgram::renew_bows() with those of targets.
  [[nodiscard]] bool renew_bows(double from, double to);
  // False if that is 0 for all laws and steps.
  [[nodiscard]] bool bends() const { return program_.bends() || !controls_.empty(); }
  [[nodiscard]] std::size_t laws() const { return program_.laws(); }
  // After drive(): sets the derivatives of the known coordinates by these rates of all laws, as state[1].
  void lean(std::span<const double> rates, double* const (&state)[3]);

  // The number of a controlled driver. Throws Error (input) for any other name.
  [[nodiscard]] std::size_t index(std::string_view driver) const;
  // Stands for the names of all controlled drivers.
  [[nodiscard]] std::size_t names() const { return names_; }
  // Sets the target of this driver for the next step. Throws Error (input) for a number of no driver, or of a driver
  // among other `names`.
  void set(std::size_t driver, std::size_t names, const Motion& motion);
  // The first controlled driver whose target is not finite, with that number; -1 if there is none.
  [[nodiscard]] std::int32_t not_finite(double& value) const;
  // Forgets the targets of the next step.
  void drop_pending();
  // Begins a step in which the controlled drivers run from their current motion to their targets. Exceptions from laws
  // propagate, before anything has changed. end_step() ends the step at time `now`; goes_on: keeps the targets.
  void begin_step(double now, double next);
  void end_step(double now, bool goes_on);
  // Ends a step that failed, also one that did not begin: all drivers that were set stand still at time `now`, without
  // targets. It returns true if one of them was moving.
  bool stop(double now);
  void reset();

  struct Control {
    std::string name;
    std::size_t input = 0;
    int law = 0;
    std::int32_t slot = -1;                     // slot in the drive program; -1: not needed
    bool set = false;                           // true: a target was set; false: the driver follows its law
    bool pending = false;                       // `next` waits for the next step
    bool was_set = false, was_pending = false;  // before the step at hand
    Motion next, from, to;
    double start = 0, end = 0;
  };
  // State of all controlled drivers. Copies to an earlier copy allocate no memory.
  using Controls = std::vector<Control>;
  [[nodiscard]] const Controls& controls() const { return controls_; }
  // Copies of controls(): return to the state before begin_step(), without the targets of that step; and drop the
  // targets of a step that has not begun. Both keep the targets for ask_again_from_rest().
  static void undo_step(Controls& controls, double now);
  static void withhold_targets(Controls& controls);
  // Takes over the controls of another object for the same scene.
  void set_controls(const Controls& other);
  // After undo_step() or withhold_targets(): repeats the targets of the step, beginning at rest at time `now`. If all
  // drivers were at rest it changes nothing, and returns false.
  bool ask_again_from_rest(double now);

 private:
  void add_control(std::string name, std::size_t input, int law);
  [[nodiscard]] Status why_undefined(double t) const;
  static bool comes_to_rest(Control& c);  // true if it was moving
  [[nodiscard]] Motion motion_by_law(const Control& c, double t) const {
    return system_.inputs[c.input].laws[static_cast<std::size_t>(c.law)](t);
  }
  void compile(const Driven& driven);
  void follow_laws(double t);

  const System& system_;
  DriveProgram program_;
  double expanded_about_ = kNan;  // NaN: laws and targets are followed
  std::vector<Index> evaluated_;
  Controls controls_;
  std::size_t names_ = 0;
};

}  // namespace assur
