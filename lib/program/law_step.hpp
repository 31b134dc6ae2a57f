// Laws of drivers as a program: the laws side by side in the lanes, with sines and cosines of those that are angles.
#pragma once

#include <cstddef>
#include <vector>

#include "assur/law.hpp"
#include "program/step_program.hpp"

namespace assur {

inline constexpr double kLargestAngle = 0x1p20;  // rad; larger angles are left to the C library

// Sums of harmonics, polynomials and tables.
struct LawOutline {
  // Harmonics of neighbouring laws, by lane: amplitude sin(2 pi frequency t + phase). omega: 2 pi frequency
  struct Harmonics {
    std::vector<double> frequency, phase, amplitude, omega;
  };
  // Polynomials of neighbouring laws: [power], by lane.
  using Polynomials = std::vector<std::vector<double>>;
  // Tables of neighbouring laws, by lane; null: none. unit: internal units in one of the table
  struct Tables {
    std::vector<const Law::Spline*> of;
    std::vector<double> unit;
  };
  // W neighbouring laws; lanes without a law give 0.
  struct Block {
    std::vector<double> base;  // W: constant parts
    std::vector<Harmonics> harmonics;
    std::vector<Polynomials> polynomials;
    std::vector<Tables> tables;
    int angles = 0;  // of the first lanes
  };

  int lanes = 1;  // W
  std::vector<Block> blocks;
};

// numbers: Memory::factors. The time is the first number of Memory::settings. Block b has the lanes from b W on in
// Memory::laws and the other memories of laws. Row 0 of Memory::figures is positive where an angle is too large, or not
// finite; its sine and cosine are then meaningless.
struct LawStep {
  StepProgram program;
  std::vector<double> numbers;
};
[[nodiscard]] LawStep law_step(const LawOutline& outline);

}  // namespace assur
