// The step of a small mechanism, or of mechanisms in the lanes of a tile, as a program: driven coordinates, predictions
// and groups, level after level.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluation/coefficients.hpp"
#include "program/step_program.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// How the driven coordinates follow from the laws. Slots 0, 1, ... are laws, those that are angles first; then results
// of turns.
struct DrivenOutline {
  // Cosine and sine of an angle, or the frame of three, from a slot on.
  struct Turn {
    std::int32_t angle, result;
  };
  struct Copy {
    std::int32_t slot, address;
  };
  struct Term {
    std::int32_t address;
    double factor;
  };
  // Of driven coordinates, and of coordinates at rest.
  struct Sum {
    std::int32_t address;
    std::vector<Term> terms;
  };

  std::int32_t laws = 0;
  std::vector<Turn> directions, frames;
  std::vector<Copy> copies;
  std::vector<Sum> sums;  // in order; Memory::factors has the factors of all terms
};

// What the step of a mechanism consists of.
struct MechanismOutline {
  // W groups of one class.
  struct Groups {
    int lanes;  // W
    const GroupClass& group_class;
    std::span<const std::int32_t> reads;   // see group_step()
    std::span<const std::int32_t> inputs;  // inputs x W addresses
    std::uint32_t unknowns;                // address of the first, relative to the first of the mechanism
  };

  DrivenOutline driven;
  std::uint32_t weights = 1;   // of the prediction
  std::vector<Groups> groups;  // in solving order
  // Of mechanisms side by side. Each coordinate then has a row of them; the driven ones are the same in all.
  int lanes = 1;
};

struct MechanismStep {
  StepProgram program;
  std::uint32_t work = 0;  // numbers in Memory::work
};

// NaN if a law is not defined, else 0; among the memories of the first group.
inline constexpr Slot kUndefined{Memory::undefined, 0, Reach::one};

// For groups that all have a group_step(), with the memories of the driven coordinates in the first group. Inputs that
// never move are not written: they must be in Memory::inputs. Without phases if it would have more than `most`
// instructions.
[[nodiscard]] MechanismStep mechanism_step(const MechanismOutline& outline, std::size_t most);

}  // namespace assur
