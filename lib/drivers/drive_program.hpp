// The drivers as a flat program in double: all laws side by side, then the driven coordinates. equations/drive.hpp
// defines the result.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assur/status.hpp"
#include "drivers/driver_turns.hpp"
#include "equations/system.hpp"
#include "executors/step_code.hpp"
#include "numbers.hpp"
#include "outputs/angle_kernels.hpp"
#include "program/law_step.hpp"
#include "program/mechanism_step.hpp"

namespace assur {

// The program for the drivers of a system.
class DriveProgram {
 public:
  // Keeps references to the laws of `system`.
  DriveProgram(const System& system, const Driven& driven);

  // Takes over other constants of the assignments of a system that is the same otherwise. False, with the program
  // invalid, if it must be made anew.
  [[nodiscard]] bool renew_assignments(const System& system, const Driven& driven);

  // Slot of a law of System::inputs[input]; -1: the law is not needed.
  [[nodiscard]] std::int32_t slot(std::size_t input, int law) const;
  // held: the caller replaces this law after each evaluation, so that its tables and functions are not evaluated.
  void hold(std::int32_t slot, bool held) {
    std::uint8_t& now = held_[static_cast<std::size_t>(slot)];
    held_laws_ += static_cast<int>(held) - now;
    now = held ? 1 : 0;
  }
  // Evaluates harmonics, polynomials and tables by machine code, if there is some for them. Functions stay calls.
  void use(StepCode& code);

  // Evaluates all laws at time t.
  void evaluate(double t);
  void replace(std::int32_t slot, const Motion& motion);  // SI units
  // Keeps all laws at hand. expand() then gives their second-order expansions, `seconds` later.
  void keep_expansion();
  void expand(double seconds);
  // Leaves the values of all laws, and lets this one alone change, by one SI unit per second.
  void move_only(std::int32_t slot);
  // Leaves the values of all laws, and lets them change by these rates, internal units. rates: laws()
  void move(std::span<const double> rates);

  [[nodiscard]] std::size_t laws() const { return laws_; }  // in slots 0, 1, ...; the angles come first
  [[nodiscard]] double scale(std::int32_t slot) const { return scale_[static_cast<std::size_t>(slot)]; }
  // False if no law ever leaves its chord.
  [[nodiscard]] bool bends() const;
  // Computes how far each law may leave its chord between two times, internal units (equations/law_bow.hpp). A function
  // of the program is called once between them. The last evaluate() was for `to`. False if bows() are still those of
  // the last step.
  [[nodiscard]] bool renew_bows(double from, double to);
  [[nodiscard]] std::span<const double> bows() const { return bows_; }  // laws(); those of held laws are meaningless
  // For a law that was replaced: its bow on this step, SI units.
  void set_bow(std::int32_t slot, double bow) {
    bows_[static_cast<std::size_t>(slot)] = bow * scale(slot);
    forget_bows();
  }
  void forget_bows() { length_of_bows_ = kNan; }
  // To be called when a step to the time of the last evaluate() is accepted.
  void accept() {
    for (Other& o : others_) o.from = o.to;
    std::copy_n(jets_[0].begin(), angles_, accepted_angles_.begin());
  }
  // Values of the laws that are angles, unwrapped; at the last accepted step.
  [[nodiscard]] std::span<const double> angles() const { return {jets_[0].data(), angles_}; }
  [[nodiscard]] const std::vector<double>& accepted_angles() const { return accepted_angles_; }
  void accept(const std::vector<double>& angles) { accepted_angles_ = angles; }
  // After renew_bows(): turn of the angles since these accepted ones, relative to the largest allowed turn of a step.
  [[nodiscard]] double turned(const std::vector<double>& since, int together, int teeth) const {
    return assur::turned(since, angles(), bows_, together, teeth);
  }
  // Writes the driven coordinates. state[d]: d-th derivative, indexed by coordinate * stride.
  void place(double* const (&state)[3], std::size_t stride = 1) {
    find_sines();
    turn();
    place_as(*this, state, stride);
  }
  // The same as a program for mechanism_step(), which reads jets(), sines() and cosines(), after find_sines().
  [[nodiscard]] DrivenOutline outline(std::int32_t stride = 1) const;
  void find_sines() {
    if (!knows_sines_) kernels_->sin_cos(jets_[0].data(), angles_, sines_.data(), cosines_.data());
    knows_sines_ = true;
  }
  [[nodiscard]] double* jets(std::size_t d) { return jets_[d].data(); }
  [[nodiscard]] double* sines() { return sines_.data(); }
  [[nodiscard]] double* cosines() { return cosines_.data(); }
  // The same with the values of another program that has placed its coordinates and has the same laws.
  void place_as(const DriveProgram& other, double* const (&state)[3], std::size_t stride) const;
  // After place(): false if the time is outside a table, or if a law is not finite.
  [[nodiscard]] bool defined() const;
  // After evaluate() or replace(): true if value, rate and acceleration of this law are finite.
  [[nodiscard]] bool finite(std::int32_t slot) const {
    const auto i = static_cast<std::size_t>(slot);
    return std::isfinite(jets_[0][i] + jets_[1][i] + jets_[2][i]);
  }
  // The reason at time t: out_of_range or not_finite.
  [[nodiscard]] static Code why_undefined(const System& system, double t);

 private:
  struct Polynomial {
    std::int32_t slot, begin, end;  // range in coefficients_
  };
  struct Sample {
    double time = kNan;
    Motion motion;
  };
  struct Table {
    std::int32_t slot;
    const Law::Spline* of;
  };
  struct Other {
    std::int32_t slot;
    const Law::Part* part;
    Sample from = {}, to = {};  // of a function: where the step begins, and the last evaluation
  };
  struct Bend {
    double acceleration = 0, reach = 0;  // of the harmonics: bounds of the second derivative and of the bow
    double steady = 0;                   // second derivative of the other part, if it is constant
  };
  struct Copy {
    std::int32_t slot;
    Index coordinate;
  };
  using Turn = DrivenOutline::Turn;
  struct Sum {
    Index coordinate;
    std::int32_t begin, end;  // range in terms_
  };
  struct TermOf {
    Index coordinate;
    double factor;
  };
  void turn();
  void compute_bows(double from, double to);
  [[nodiscard]] LawOutline law_outline() const;
  [[nodiscard]] bool evaluate_by_code(double t);
  void evaluate_by_kernels(double t);
  void add(std::int32_t slot, const Motion& motion, double scale);
  [[nodiscard]] static double bow_of_function(const Law::Function& law, Other& of, double from, double to);
  void add_slots(const System& system, const Driven& driven, bool angles);
  void add_law(std::int32_t slot, const Law& law);
  void add_term(std::int32_t slot, const Harmonic& term);
  void add_bend(std::int32_t slot, const Law::Part& part);
  void add_input(const System& system, std::size_t input);
  std::int32_t add_turn(std::vector<Turn>& turns, std::int32_t angle, std::int32_t results);
  void add_copies(std::int32_t slot, Index coordinate, std::int32_t count);
  void add_assignment(const System& system, const Assignment& assignment);

  const AngleKernels* kernels_ = &angle_kernels();
  std::vector<std::int32_t> first_slot_;  // inputs: first law in slot_
  std::vector<std::int32_t> slot_;        // laws
  // Slots: angles, other laws, padding, then sines, cosines and frames of the angles.
  std::size_t angles_ = 0;
  std::size_t laws_ = 0;                 // and angles
  std::vector<double> scale_;            // laws: internal units in one SI unit, a power of two
  std::vector<double> base_;             // laws, padded: constant part
  std::vector<double> jets_[3];          // slots: value, rate, acceleration
  std::vector<double> kept_[3];          // laws, see keep_expansion()
  std::vector<double> sines_, cosines_;  // angles, padded
  std::vector<std::uint8_t> held_;       // laws
  int held_laws_ = 0;
  bool knows_sines_ = false;              // sines_ and cosines_ are those of the values at hand
  std::shared_ptr<const Executor> code_;  // null: there is none
  std::vector<double> numbers_;           // that it reads
  std::vector<HarmonicBlock> harmonics_;
  std::vector<Polynomial> polynomials_;
  std::vector<double> coefficients_;
  std::vector<Table> tables_;
  std::vector<Other> others_;
  std::vector<Bend> bend_;        // laws
  std::vector<Other> uneven_;     // polynomials of degree 3 and more
  bool evenly_ = true;            // the bows depend on the length of the step only
  std::vector<double> bows_;      // laws
  double length_of_bows_ = kNan;  // the step that they are for, if they depend on its length only
  std::vector<double> accepted_angles_;
  std::vector<Copy> copies_;
  std::vector<std::int32_t> slot_of_;  // coordinates; -1: a sum
  std::vector<Turn> directions_, frames_;
  std::vector<Sum> sums_;
  std::vector<TermOf> terms_;
};

}  // namespace assur
