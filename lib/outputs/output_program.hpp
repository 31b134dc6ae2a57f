// Evaluates outputs and measures of a state: forms over addresses, then jets.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "equations/outputs.hpp"
#include "equations/system.hpp"
#include "outputs/angle_kernels.hpp"
#include "outputs/form_kernels.hpp"
#include "outputs/orientation.hpp"
#include "outputs/random_sign.hpp"
#include "program/step_program.hpp"
#include "scene/jet.hpp"

namespace assur {

// A signed angle is atan2(y, x), from its forms: numbers, or jets of them.
template <class N>
struct ArmOf {
  N x, y;
};
template <class N>
ArmOf<N> arm_of(MeasureForms::Kind kind, std::span<const N> f, int dimension) {
  if (kind == MeasureForms::Kind::absolute_angle) return {f[0], f[1]};
  if (dimension == 2) return {f[0] * f[2] + f[1] * f[3], f[0] * f[3] - f[1] * f[2]};
  const auto across = [&](std::size_t i, std::size_t j) { return f[i] * f[3 + j] - f[j] * f[3 + i]; };
  return {f[0] * f[3] + f[1] * f[4] + f[2] * f[5], f[6] * across(1, 2) + f[7] * across(2, 0) + f[8] * across(0, 1)};
}

// The square of the divisor in the derivatives of a measure: the distance itself, the arm of a signed angle, or the
// sine of an unsigned angle; 1 for other measures.
template <class T>
T divisor_of(MeasureForms::Kind kind, std::span<const Jet<T>> f, int dimension) {
  const auto square = [](const T& x) { return x * x; };
  const auto cross = [&](std::size_t i, std::size_t j) {
    return square(f[i].value * f[3 + j].value - f[j].value * f[3 + i].value);
  };
  switch (kind) {
    case MeasureForms::Kind::form:
    case MeasureForms::Kind::sum:
    case MeasureForms::Kind::sum_of_angles:
    case MeasureForms::Kind::quaternion_w:
    case MeasureForms::Kind::quaternion_x:
    case MeasureForms::Kind::quaternion_y:
    case MeasureForms::Kind::quaternion_z:
    case MeasureForms::Kind::turn_x:
    case MeasureForms::Kind::turn_y:
    case MeasureForms::Kind::turn_z:
      return T(1);
    case MeasureForms::Kind::distance:
      return square(f[0].value) + square(f[1].value) + (dimension == 3 ? square(f[2].value) : T(0));
    case MeasureForms::Kind::absolute_angle:
    case MeasureForms::Kind::signed_angle: {
      const ArmOf<Jet<T>> arm = arm_of(kind, f, dimension);
      return square(arm.x.value) + square(arm.y.value);
    }
    case MeasureForms::Kind::unsigned_angle:
      return cross(1, 2) + cross(2, 0) + cross(0, 1);
  }
  return T(1);
}

// Value, rate and acceleration of a measure that is not a sum, from the jets of its forms (internal units).
template <class T>
Jet<T> evaluate_measure(MeasureForms::Kind kind, std::span<const Jet<T>> f, int dimension) {
  const auto dot = [&](std::size_t a, std::size_t b) {
    Jet<T> sum = f[a] * f[b];
    for (int k = 1; k < dimension; ++k)
      sum = sum + f[a + static_cast<std::size_t>(k)] * f[b + static_cast<std::size_t>(k)];
    return sum;
  };
  const auto cross = [&](std::size_t a, std::size_t b, int k) {
    const std::size_t i = static_cast<std::size_t>((k + 1) % 3), j = static_cast<std::size_t>((k + 2) % 3);
    return f[a + i] * f[b + j] - f[a + j] * f[b + i];
  };
  switch (kind) {
    case MeasureForms::Kind::form:
      return f[0];
    case MeasureForms::Kind::distance:
      return length(f.first(static_cast<std::size_t>(dimension)));
    case MeasureForms::Kind::absolute_angle:
    case MeasureForms::Kind::signed_angle: {
      const ArmOf<Jet<T>> arm = arm_of(kind, f, dimension);
      return atan2(arm.y, arm.x);
    }
    case MeasureForms::Kind::unsigned_angle: {
      const Jet<T> across[3] = {cross(0, 3, 0), cross(0, 3, 1), cross(0, 3, 2)};
      return atan2(length(std::span<const Jet<T>>(across)), dot(0, 3));
    }
    case MeasureForms::Kind::quaternion_w:
      return quaternion(f, 0);
    case MeasureForms::Kind::quaternion_x:
      return quaternion(f, 1);
    case MeasureForms::Kind::quaternion_y:
      return quaternion(f, 2);
    case MeasureForms::Kind::quaternion_z:
      return quaternion(f, 3);
    case MeasureForms::Kind::turn_x:
      return turn(f, 0);
    case MeasureForms::Kind::turn_y:
      return turn(f, 1);
    case MeasureForms::Kind::turn_z:
      return turn(f, 2);
    case MeasureForms::Kind::sum:
    case MeasureForms::Kind::sum_of_angles:
      break;
  }
  return {};
}

// A flat program: one entry for each part, in the order of wanted_outputs().
class OutputProgram {
 public:
  // `address`: coordinates -> index into the state arrays; -1: not available (never read by a needed output).
  OutputProgram(const System& system, std::span<const std::int32_t> address) { bind(system, address); }
  // The same for other outputs than the wanted ones.
  OutputProgram(const System& system, std::span<const std::int32_t> address, const std::vector<Output>& outputs) {
    bind(system, address, outputs);
  }

  // Rebuilds the program for another system; reuses its memory.
  void bind(const System& system, std::span<const std::int32_t> address) {
    bind(system, address, wanted_outputs(system));
  }
  void bind(const System& system, std::span<const std::int32_t> address, const std::vector<Output>& outputs);
  // Takes over the numbers of a system that differs from the last one in numbers only. False, with the program invalid,
  // if it must be bound.
  [[nodiscard]] bool renew(const System& system);

  // Evaluates outputs side by side that read neighbouring numbers of the state, as the lanes of a pack are. To be
  // called after mark(); bind() returns to one output after the other. size: of the state.
  void find_rows(std::size_t size);
  [[nodiscard]] std::size_t rows() const { return rows_.size(); }

  // Number of columns.
  [[nodiscard]] std::size_t columns() const { return columns_; }
  // Columns of signed angles, which are unwrapped along a run.
  [[nodiscard]] std::vector<std::size_t> angles() const;
  // The i-th of angles() is atan2(y, x) at a posture.
  void arm(std::size_t i, const double* q, double& x, double& y) const;
  // Size of the terms of x and y: their rounding errors are relative to it.
  [[nodiscard]] double size_of_arm(std::size_t i, const double* q) const;

  // Calls use(number) for each of the numbers() of the mechanism, of which the first one is 0. True if the step
  // programs of another one differ in nothing else.
  template <class Use>
  void each_number(const Use& use) const {
    use(0.0);
    for (const TermAt& t : sum_terms_) use(t.factor);
    for (const TermAt& t : terms_) use(t.factor);
  }
  [[nodiscard]] std::size_t numbers() const { return place_of_terms() + terms_.size(); }
  [[nodiscard]] bool same_shape(const OutputProgram& other) const;
  // Where a program has its numbers.
  enum class Numbers : std::uint8_t {
    constants,  // it is for this mechanism only, and every reach is Reach::one
    loads,      // from Memory::factors: it is for mechanisms side by side, one in each lane
  };
  // Linear outputs with their constants, and signed angles: Memory::settings has the turns of angles(), and
  // Memory::figures takes the divisors of the measures. To be called before find_rows().
  [[nodiscard]] StepProgram output_step(Numbers numbers) const;
  // Each of angles() is atan2(y, x): writes x to a row of Memory::work, and y to a row from first_y on.
  [[nodiscard]] StepProgram arm_step(Numbers numbers, std::size_t first_y) const;
  // differentiate() without differentiate_others(), for mechanisms side by side: Memory::past has the changes of the
  // state, by derivative, and Memory::work roundings() of signed angles, relative to what is rounded.
  [[nodiscard]] StepProgram change_step() const;
  [[nodiscard]] std::size_t roundings() const;
  // Number of instructions of output_step(), about.
  [[nodiscard]] std::size_t operations() const;
  // Marks the addresses that are read.
  void mark(std::vector<std::uint8_t>& addresses) const;

  // Writes the outputs of a state. state[d]: d-th derivative. out: one double for each column, SI units. turns: whole
  // turns to add to angles(). divisors, one for each of measures(): receives divisor_of(). part of parts: a share of
  // the columns, for one of several threads.
  void evaluate(const double* const (&state)[3], double* out, const double* turns, double* divisors,
                std::size_t part = 0, std::size_t parts = 1) const;
  // The rest of evaluate(), which output_step() leaves out, if there is any. out and divisors: their numbers are
  // `apart` from each other.
  void evaluate_others(const double* const (&state)[3], double* out, double* divisors, std::size_t apart = 1) const {
    evaluate_others(state, out, divisors, apart, parts_);
  }
  [[nodiscard]] bool has_others() const {
    return std::any_of(parts_.begin(), parts_.end(), [](const Measured& p) { return !p.is_signed_angle(); });
  }
  // Adds up sums of measures from columns of the same row. To be called after evaluate(), with whole turns added.
  void add_up(double* out) const { add_up(out, 1); }
  // Number of measures without sums.
  [[nodiscard]] std::size_t measures() const { return parts_.size(); }

  // Change of every column, to first order, by a change of the state and, if `sign` is given, by rounding in the
  // measures. Not finite if a measure has a kink.
  void differentiate(const double* const (&state)[3], const double* const (&change)[3], RandomSign* sign,
                     double* out) const;
  // The part that change_step() leaves out. out: its numbers are `apart` from each other
  void differentiate_others(const double* const (&state)[3], const double* const (&change)[3], RandomSign* sign,
                            double* out, std::size_t apart) const;
  // Adds up the changes of sums, as add_up().
  void add_up_changes(double* out) const { add_up(out, 0); }

 private:
  struct TermAt {
    std::int32_t address;
    double factor;

    [[nodiscard]] bool is_like(const TermAt& o) const { return address == o.address; }
  };
  struct Measured {
    MeasureForms::Kind kind;
    std::int32_t forms_begin, forms_end;
    double unit;
    std::array<std::int32_t, 3> column;  // of value, rate, acceleration; -1: not wanted
    std::int32_t angle = -1;             // index into angles(); -1: none
    std::int32_t arm = -1;               // a signed angle is atan2 of the forms arm + 1 and arm; -1: of products

    [[nodiscard]] bool is_signed_angle() const {
      return kind == MeasureForms::Kind::absolute_angle || kind == MeasureForms::Kind::signed_angle;
    }
    [[nodiscard]] bool is_like(const Measured& o) const {
      return kind == o.kind && forms_begin == o.forms_begin && forms_end == o.forms_end && unit == o.unit &&
             column == o.column && angle == o.angle && arm == o.arm;
    }
  };
  // An output that is linear in coordinates: terms in SI units, the same for value, rate and acceleration.
  struct Sum {
    std::int32_t begin, end;
    std::array<std::int32_t, 3> column;  // -1: not wanted

    [[nodiscard]] bool is_like(const Sum& o) const { return begin == o.begin && end == o.end && column == o.column; }
  };
  struct Form;
  struct Neighbours;
  void add_row(const Neighbours& neighbours);
  void evaluate_linear(const double* const (&state)[3], double* out, std::size_t part, std::size_t parts) const;
  void evaluate_forms(const Measured& measure, const double* const (&state)[3], Jet<double> (&forms)[9]) const;
  [[nodiscard]] Jet<double> jet_of(std::int32_t form, const double* const (&state)[3]) const;
  [[nodiscard]] Jet<double> size_of_terms(std::int32_t form, const double* const (&state)[3]) const;
  void evaluate_angles(const double* const (&state)[3], double* out, const double* turns, double* divisors,
                       std::span<const Measured> among) const;
  // The arm of a signed angle. of(form): the form, a number or a jet
  template <class N, class Of>
  [[nodiscard]] ArmOf<N> arm_by(const Measured& measure, const Of& of) const {
    if (measure.arm >= 0) return {of(measure.arm), of(measure.arm + 1)};
    N forms[9] = {};
    for (std::int32_t f = measure.forms_begin; f < measure.forms_end; ++f) forms[f - measure.forms_begin] = of(f);
    return arm_of<N>(measure.kind, {forms, 9}, dimension_);
  }
  static void put(const Measured& measure, const Jet<double>& m, double* out, std::size_t apart = 1);
  void evaluate_others(const double* const (&state)[3], double* out, double* divisors, std::size_t apart,
                       std::span<const Measured> among) const;
  void differentiate(const Measured& measure, const double* const (&state)[3], const double* const (&change)[3],
                     RandomSign* sign, double* out, std::size_t apart) const;
  [[nodiscard]] std::span<const TermAt> terms_of(std::int32_t form) const {
    const auto f = static_cast<std::size_t>(form);
    return {terms_.data() + form_start_[f], terms_.data() + form_start_[f + 1]};
  }
  void add(const System& system, std::span<const std::int32_t> address, const OutputPart& part,
           const std::array<std::int32_t, 3>& column);
  // Measured::arm of a signed angle. Adds the two forms if one direction, and in space the axis, is constant.
  [[nodiscard]] std::int32_t add_arm(const Measured& part);
  // Finds the terms of these two forms, for x and y. False if there are none.
  bool find_arm(const Measured& part);
  [[nodiscard]] bool renew_arm(const Measured& part);
  // A form of the system, whose numbers are those of an output, times the unit.
  struct Source {
    Index form;
    double unit;
  };

  // A column that is a constant and multiples of others.
  struct Total {
    std::int32_t begin, end;  // in total_terms_
    std::int32_t column;
    double constant;
  };
  struct TotalTerm {
    std::int32_t column;
    double factor;
  };
  void add_up(double* out, double constant) const;
  class StepWriter;
  [[nodiscard]] std::size_t place_of_terms() const { return 1 + sum_terms_.size(); }  // among numbers()

  const AngleKernels* kernels_ = &angle_kernels();
  EvaluateForms evaluate_rows_ = assur::evaluate_forms();
  int dimension_ = 2;
  std::size_t columns_ = 0;
  std::int32_t one_ = 0;  // address of the constant 1
  std::vector<Total> totals_;
  std::vector<TotalTerm> total_terms_;
  std::vector<FormRow> rows_;
  std::vector<FormTerm> row_terms_;
  std::vector<Sum> sums_;
  std::vector<TermAt> sum_terms_;
  std::vector<TermAt> terms_;
  std::vector<std::int32_t> form_start_;
  std::vector<Measured> parts_;
  std::vector<std::size_t> angles_;  // parts
  std::vector<Source> of_sums_;
  std::vector<Index> of_forms_;       // those in form_start_: forms of the system; -1: of an arm
  std::vector<TermAt> arm_terms_[2];  // see find_arm()
};

}  // namespace assur
