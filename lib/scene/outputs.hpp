// The wanted outputs as forms and columns.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/system.hpp"

namespace assur {

// One component of a point or vector; a measure or a scalar.
struct OutputPart {
  MeasureForms::Kind kind = MeasureForms::Kind::form;
  std::span<const Index> forms;
  std::int8_t dimension = 0;  // of the value, power of length
};

// Views of the system, which must outlive it: every member of an ensemble makes them anew.
struct Output {
  std::string_view name;  // "C", "rocker_angle", "slider.lambda"
  std::array<OutputPart, 3> all_parts;
  std::size_t part_count = 1;
  bool wanted[3] = {true, true, true};  // value, first and second derivative

  [[nodiscard]] std::span<const OutputPart> parts() const { return {all_parts.data(), part_count}; }
  // Highest derivative wanted.
  [[nodiscard]] int derivatives() const { return wanted[2] ? 2 : wanted[1] ? 1 : 0; }
};

// In the order asked for, nothing twice; everything that is not fixed if the scene asks for nothing in particular.
[[nodiscard]] std::vector<Output> wanted_outputs(const System& system);

// Columns of one output in the order value, rate, acceleration: "C.x C.y C.vx ..." or "m m.rate m.acceleration".
void append_columns(const Output& output, std::vector<std::string>& columns);

// Of all wanted outputs.
[[nodiscard]] std::vector<std::string> column_names(const System& system);

}  // namespace assur
