// How the numbers of a system follow from the values of parameters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/law.hpp"
#include "equations/system.hpp"
#include "scene/tape.hpp"
#include "tables/replay.hpp"

namespace assur {

class Recipe {
 public:
  // The numbers of `system` that are on the tape.
  Recipe(const Tape& tape, const System& system);

  [[nodiscard]] const std::vector<Number>& wanted() const { return wanted_; }

  // True if numbers of outputs, of laws, of drivers (laws, or values in the posture as written), or of assignments are
  // among them.
  [[nodiscard]] bool has_outputs() const { return has_outputs_; }
  [[nodiscard]] bool has_laws() const { return !laws_.empty(); }
  [[nodiscard]] bool has_drivers() const { return has_laws() || has_written_; }
  [[nodiscard]] bool has_assignments() const { return has_assignments_; }

  // Places in a copy of the system that receive the numbers.
  class Target {
   public:
    Target(const Recipe& recipe, System& system);
    // Sets the numbers that a replay has computed for a lane; `first`: place of the first one among its wanted numbers.
    void set(const Replay& replay, std::size_t lane, std::size_t first = 0);

   private:
    struct OfLaw {
      Law* law;
      std::vector<Law::Part> parts;
      std::vector<Number*> numbers;
    };
    std::vector<double*> doubles_;  // constants and guesses; then come numbers_
    std::vector<Number*> numbers_;
    std::vector<OfLaw> laws_;
  };

 private:
  struct OfLaw {
    std::size_t input, law;
    std::vector<std::size_t> numbers;  // in the order of each_number() of its parts
  };
  std::vector<std::size_t> numbers_;  // in the order of each_number() of the system
  std::vector<OfLaw> laws_;
  std::vector<Number> wanted_;  // those of numbers_, then those of laws_
  bool has_outputs_ = false, has_written_ = false, has_assignments_ = false;
};

}  // namespace assur
