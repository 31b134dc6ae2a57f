// Outputs and measures from a state: forms over addresses, then jets.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/jet.hpp"
#include "scene/outputs.hpp"
#include "scene/system.hpp"

namespace assur {

// Value, rate and acceleration of a measure from the jets of its forms (internal units).
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
      return sqrt(dot(0, 0));
    case MeasureForms::Kind::absolute_angle:
      return atan2(f[1], f[0]);
    case MeasureForms::Kind::signed_angle:
      if (dimension == 2) return atan2(f[0] * f[3] - f[1] * f[2], dot(0, 2));
      return atan2(f[6] * cross(0, 3, 0) + f[7] * cross(0, 3, 1) + f[8] * cross(0, 3, 2), dot(0, 3));
    case MeasureForms::Kind::unsigned_angle: {
      const Jet<T> x = cross(0, 3, 0), y = cross(0, 3, 1), z = cross(0, 3, 2);
      const Jet<T> square = x * x + y * y + z * z;
      // At 0 and pi the angle has a kink: value only, the rate is none.
      if (!(square.value > T(0))) return {dot(0, 3).value < T(0) ? acos(T(-1)) : T(0), T(0), T(0)};
      return atan2(sqrt(square), dot(0, 3));
    }
  }
  return {};
}

// A flat program: one entry for each part, in the order of wanted_outputs().
class OutputProgram {
 public:
  // `address`: coordinates -> index into the state arrays; -1: not available (never read by a needed output).
  OutputProgram(const System& system, std::span<const std::int32_t> address) { bind(system, address); }

  // The same for another system, in the memory at hand.
  void bind(const System& system, std::span<const std::int32_t> address);

  // Columns of signed angles, which are unwrapped along a run.
  [[nodiscard]] std::vector<std::size_t> angles() const;

  // Marks the addresses that are read.
  void mark(std::vector<std::uint8_t>& addresses) const;

  // state[d]: d-th derivative. out: one double for each column, SI units.
  // `previous`: the row before at a time dt earlier, to unwrap signed angles; null: the first row.
  // part of parts: a share of the columns, for one of several threads.
  void evaluate(const double* const (&state)[3], double* out, const double* previous, double dt, std::size_t part = 0,
                std::size_t parts = 1) const;

 private:
  struct TermAt {
    std::int32_t address;
    double factor;
  };
  struct Part {
    MeasureForms::Kind kind;
    std::int32_t forms_begin, forms_end;
    double unit;
    std::array<std::int32_t, 3> column;  // of value, rate, acceleration; -1: not wanted
    bool angle;
  };
  // What is linear in one coordinate, in SI units: offset + factor * coordinate.
  struct Line {
    std::int32_t address;
    std::array<std::int32_t, 3> column;  // of value, rate, acceleration; -1: not wanted
    double factor, offset;
  };
  // What is linear in more of them: terms in SI units, the same for value, rate and acceleration.
  struct Sum {
    std::int32_t begin, end;
    std::array<std::int32_t, 3> column;  // -1: not wanted
  };
  void add(const System& system, std::span<const std::int32_t> address, const OutputPart& part,
           const std::array<std::int32_t, 3>& column);
  // False if more than one coordinate takes part.
  bool add_line(const System& system, std::span<const std::int32_t> address, Index form, double unit,
                const std::array<std::int32_t, 3>& column);

  int dimension_ = 2;
  std::vector<Line> motions_;  // value, rate and acceleration wanted
  std::vector<Line> lines_;    // not all of them
  std::vector<Sum> sums_;
  std::vector<TermAt> sum_terms_;
  std::vector<TermAt> terms_;
  std::vector<std::int32_t> form_start_;
  std::vector<Part> parts_;
};

}  // namespace assur
