// Wanted outputs as forms and columns.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// One component of a point or vector; a measure or a scalar.
struct OutputPart {
  MeasureForms::Kind kind = MeasureForms::Kind::form;
  std::int8_t dimension = 0;  // of the value, power of length
  std::span<const Index> forms;
};

// An output. It refers to the system, which must outlive it; every member of an ensemble makes its own.
struct Output {
  std::string_view name;  // "C", "rocker_angle", "slider.lambda"
  int component = -1;     // of a point or vector: this one alone; -1: all
  std::array<OutputPart, 3> all_parts;
  std::size_t part_count = 1;
  bool wanted[3] = {true, true, true};  // value, first and second derivative
  const MeasureForms* sum = nullptr;    // a sum; its terms come before it, with the same derivatives

  [[nodiscard]] std::span<const OutputPart> parts() const { return {all_parts.data(), part_count}; }
  // Highest derivative wanted.
  [[nodiscard]] int derivatives() const { return wanted[2] ? 2 : wanted[1] ? 1 : 0; }
};

// All wanted outputs in the order of the scene, without repetitions; the measures of a sum come before it. If the scene
// names no outputs: everything that is not fixed.
[[nodiscard]] std::vector<Output> wanted_outputs(const System& system);

// The limited measures with all derivatives; the measures of a sum come before it.
[[nodiscard]] std::vector<Output> limited_outputs(const System& system);

// Columns of one output in the order value, rate, acceleration: "C.x C.y C.vx ..." or "m m.rate m.acceleration".
void append_columns(const Output& output, std::vector<std::string>& columns);

// The columns of all wanted outputs.
[[nodiscard]] std::vector<std::string> column_names(const System& system);

}  // namespace assur
