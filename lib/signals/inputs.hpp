// The drivers at a time: laws, and what a control program has set instead.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "scene/system.hpp"
#include "signals/angle_turns.hpp"
#include "signals/drive_program.hpp"

namespace assur {

// What must stay positive, or its driver does nothing: a driven distance, or what a relative angle's driver acts on.
struct Lever {
  std::int32_t address;  // in a state, of its first lane
  Index driver;          // into System::drivers
  double start = 0;      // value at the start of the run
};

// The first one that is not positive in the posture `to`, or is not on the way there from `from`, `seconds` before (0:
// there is none), as far as both tell: on the quintic through them. Null: there is none. [d]: d-th derivatives.
[[nodiscard]] const Lever* vanished(std::span<const Lever> levers, const double* const (&from)[3],
                                    const double* const (&to)[3], double seconds);

class Inputs {
 public:
  Inputs(const System& system, const std::vector<std::string>& controlled);

  // Only drivers behind the coordinates that are marked are evaluated from now on.
  void keep(std::vector<std::uint8_t> needed) { compile(driven_behind(system_, std::move(needed))); }

  // Known coordinates at time t; state[d]: d-th derivative, indexed by coordinate.
  [[nodiscard]] Status drive(double t, double* const (&state)[3]);

  // Driven distances, of those that are evaluated.
  [[nodiscard]] const std::vector<Lever>& levers() const { return levers_; }

  // True if somebody reads that law of the system, and nothing was set instead.
  [[nodiscard]] bool follows_law(std::size_t input, std::size_t law) const;

  // Part of what the drivers' angles may turn in one step, by which drive() turned them since accept().
  [[nodiscard]] double turned(int together) const {
    return assur::turned(accepted_angles_, program_.angles(), together);
  }
  // The last drive() was to a posture that is accepted.
  void accept() { std::copy(program_.angles().begin(), program_.angles().end(), accepted_angles_.begin()); }
  [[nodiscard]] const std::vector<double>& accepted_angles() const { return accepted_angles_; }
  void accept(const std::vector<double>& angles) { accepted_angles_ = angles; }

  // What a controlled driver reaches at the next step. Throws Error (input) for any other name.
  void set(std::string_view driver, const Motion& motion);
  // The first driver set to what is not finite, with that value; null if there is none.
  [[nodiscard]] const std::string* not_finite(double& value) const;
  // Forgets what has been set since the last step.
  void drop_pending();
  // Between `now` and `next` the controlled drivers run from where they are to where they were set; end_step() says how
  // far the step came, and whether it failed, so that they stand still, or goes on with the same aim. True if some that
  // moved stand still.
  void begin_step(double now, double next);
  enum class End : std::uint8_t { arrived, failed, goes_on };
  bool end_step(double now, End end);
  void reset();

  struct Control {
    std::string name;
    std::size_t input = 0;
    int law = 0;
    std::int32_t slot = -1;                     // in the program; -1: nobody reads it
    bool set = false;                           // else the law serves
    bool pending = false;                       // `next` waits for the next step
    bool was_set = false, was_pending = false;  // before the step at hand
    Motion next, from, to;
    double start = 0, end = 0;
  };
  // What was set; copies take no memory once they were made.
  using Controls = std::vector<Control>;
  [[nodiscard]] const Controls& controls() const { return controls_; }
  // As it was before begin_step(), without what was set for that step.
  static void undo_step(Controls& controls, double now);
  // Takes over what was set in another one of the same scene.
  void take(const Controls& other);
  // After undo_step(): the drivers are to move as they were asked to, but stand still first. False if they did.
  bool ask_again_from_rest();

 private:
  void add_control(std::string name, std::size_t input, int law);
  void compile(const Driven& driven);

  const System& system_;
  DriveProgram program_;
  std::vector<Lever> levers_;
  std::vector<double> accepted_angles_;
  Controls controls_;
};

}  // namespace assur
