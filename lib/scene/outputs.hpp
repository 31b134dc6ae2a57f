// The wanted outputs as forms and columns.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/system.hpp"

namespace assur {

// One component of a point or vector; a measure or a scalar.
struct OutputPart {
  MeasureForms::Kind kind = MeasureForms::Kind::form;
  std::int8_t dimension = 0;  // of the value, power of length
  std::span<const Index> forms;
};

// Views of the system, which must outlive it: every member of an ensemble makes them anew.
struct Output {
  std::string_view name;  // "C", "rocker_angle", "slider.lambda"
  int component = -1;     // of a point or vector: this one alone; -1: all
  std::array<OutputPart, 3> all_parts;
  std::size_t part_count = 1;
  bool wanted[3] = {true, true, true};  // value, first and second derivative
  const MeasureForms* sum = nullptr;    // its terms stand before it, in the derivatives that it has itself

  [[nodiscard]] std::span<const OutputPart> parts() const { return {all_parts.data(), part_count}; }
  // Highest derivative wanted.
  [[nodiscard]] int derivatives() const { return wanted[2] ? 2 : wanted[1] ? 1 : 0; }
};

// What a text such as "C.velocity" or "C.vx" asks of C, from what follows the dot.
struct AskedPart {
  int component = -1;   // -1: all
  int derivative = -1;  // 0, 1, 2; -1: all
};
// components: of what is asked, 1 for a scalar. Empty if there is no such part.
[[nodiscard]] std::optional<AskedPart> asked_part(std::string_view part, int components);

// In the order asked for, nothing twice, the measures of a sum before it; everything that is not fixed if the scene
// asks for nothing in particular.
[[nodiscard]] std::vector<Output> wanted_outputs(const System& system);

// Columns of one output in the order value, rate, acceleration: "C.x C.y C.vx ..." or "m m.rate m.acceleration".
void append_columns(const Output& output, std::vector<std::string>& columns);

// Of all wanted outputs.
[[nodiscard]] std::vector<std::string> column_names(const System& system);

}  // namespace assur
