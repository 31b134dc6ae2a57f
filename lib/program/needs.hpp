// What the steps of a mechanism need besides the arithmetic of their step programs, and which of the paths that take
// steps in another way than one after the other supply it. Paths ask this question; none of them names features.
#pragma once

#include <cstdint>
#include <string>

#include "structure/grouped_system.hpp"

namespace assur {

enum class Need : std::uint8_t {
  functions_in_equations,  // calls of the program that uses the library
  functions_in_laws,
  proofs,    // of convergence, for equations that are not quadratic: no ball of uniqueness is known for them
  limits,    // are followed from step to step
  choices,   // of independent equations among redundant ones
  rest,      // unknowns that are solved once, before the first step
  targets,   // of drivers that the program sets
  deadline,  // of each step
};
inline constexpr int kNeeds = 8;

// A set of needs.
class Needs {
 public:
  constexpr Needs() = default;
  template <class... More>
  constexpr Needs(Need first, More... more) : bits_((bit(first) | ... | bit(more))) {}  // NOLINT: one is a set, too

  constexpr void add(Need need, bool is_needed = true) { bits_ |= is_needed ? bit(need) : 0U; }
  constexpr void add(Needs others) { bits_ |= others.bits_; }
  [[nodiscard]] constexpr bool has(Need need) const { return (bits_ & bit(need)) != 0; }
  [[nodiscard]] constexpr bool has_any(Needs of) const { return (bits_ & of.bits_) != 0; }

 private:
  static constexpr std::uint32_t bit(Need need) { return 1U << static_cast<unsigned>(need); }

  std::uint32_t bits_ = 0;
};

enum class Path : std::uint8_t {
  step_program,   // a step of a group as a program of its own
  together,       // the groups of all levels at once
  chunks,         // pieces of a time grid side by side
  ensemble,       // members side by side
  table,          // members whose numbers follow from a row of values
  walk_in_lanes,  // walks of such members to their starts
};

[[nodiscard]] Needs needs_of(const GroupClass& group_class);
// Of all groups, laws, limits and redundant equations.
[[nodiscard]] Needs needs_of(const GroupedSystem& structure);

// The first need that a path does not supply, as a reason for messages; "": the path can be taken.
[[nodiscard]] std::string why_not(Path path, Needs needs);
[[nodiscard]] inline bool can_take(Path path, Needs needs) { return why_not(path, needs).empty(); }

}  // namespace assur
