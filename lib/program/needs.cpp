#include "program/needs.hpp"

#include <algorithm>
#include <variant>
#include <vector>

#include "equations/system.hpp"
#include "index.hpp"
#include "joints/gear.hpp"

namespace assur {
namespace {

constexpr Needs supplied_by(Path path) {
  using enum Need;
  switch (path) {
    case Path::step_program:
      return {proofs, limits, choices, rest, targets, deadline, functions_in_laws};
    case Path::together:
      return {limits, choices, rest, targets, deadline, functions_in_laws};
    case Path::chunks:
      return {choices, rest, targets, functions_in_laws};
    case Path::ensemble:
      return {proofs, limits, choices, rest, targets, functions_in_laws, functions_in_equations};
    case Path::table:
      return {proofs, limits, rest, targets};
    case Path::walk_in_lanes:
      return {limits, choices, targets, deadline, functions_in_laws};
  }
  return {};
}

std::string text(Need need) {
  switch (need) {
    case Need::functions_in_equations:
    case Need::functions_in_laws:
      return "the scene has functions of the program";
    case Need::proofs:
      return "the scene has equations that are not quadratic, for which convergence is not proved";
    case Need::limits:
      return "limits are followed from step to step";
    case Need::choices:
      return "the scene has redundant equations";
    case Need::rest:
      return "the scene has unknowns that are solved once";
    case Need::targets:
      return "the program sets drivers";
    case Need::deadline:
      return "StepSettings::seconds limits single steps";
  }
  return "";
}

// Redundant equations between constants choose nothing.
bool has_choices(const GroupedSystem& s) {
  std::vector<Index> mentioned;
  return std::any_of(s.checks.begin(), s.checks.end(), [&](std::int32_t e) {
    s.system->mentioned(e, mentioned);
    return !mentioned.empty();
  });
}

}  // namespace

Needs needs_of(const GroupClass& c) {
  Needs needs;
  needs.add(Need::proofs, !c.quadratic());
  needs.add(Need::functions_in_equations, !c.callbacks.empty());
  return needs;
}

Needs needs_of(const GroupedSystem& s) {
  Needs needs;
  for (const GroupClass& c : s.classes) needs.add(needs_of(c));
  for (const CallbackBlock& block : s.system->callbacks) {
    needs.add(Need::functions_in_equations, !numbers_of(*block.callback));
  }
  for_each_function(*s.system,
                    [&](std::size_t, std::size_t, const Law::Function&) { needs.add(Need::functions_in_laws); });
  needs.add(Need::limits, !s.system->bounds.empty());
  needs.add(Need::choices, has_choices(s));
  needs.add(Need::rest, !s.static_coordinates.empty());
  return needs;
}

std::string why_not(Path path, Needs needs) {
  const Needs supplied = supplied_by(path);
  for (int i = 0; i < kNeeds; ++i) {
    const auto need = static_cast<Need>(i);
    if (needs.has(need) && !supplied.has(need)) return text(need);
  }
  return "";
}

}  // namespace assur
