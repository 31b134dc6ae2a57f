// Access to a structure by names.
#pragma once

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "equations/system.hpp"
#include "structure/grouped_system.hpp"

namespace assur::look {

inline GroupedSystem structure(const Scene& scene, Formulation formulation, int predictor_derivatives = 0) {
  StructureOptions options;
  options.formulation = formulation;
  options.predictor_derivatives = predictor_derivatives;
  return group_equations(scene, options);
}

inline const SolvedGroup& group(const GroupedSystem& s, const std::string& name) {
  const auto found =
      std::find_if(s.groups.begin(), s.groups.end(), [&](const SolvedGroup& g) { return g.name == name; });
  if (found == s.groups.end()) throw std::out_of_range("no group " + name);
  return *found;
}

inline const GroupClass& class_of(const GroupedSystem& s, const SolvedGroup& group) {
  return s.classes.at(static_cast<std::size_t>(group.group_class));
}

// Names of a group's unknowns, "B1.x".
inline std::set<std::string> unknowns(const GroupedSystem& s, const SolvedGroup& group) {
  std::set<std::string> out;
  for (const auto u : group.unknowns) out.insert(s.system->coordinate_name(u));
  return out;
}

// Unknowns of each irreducible block of a group, in solving order.
inline std::vector<int> block_sizes(const GroupClass& c) {
  std::vector<int> size(static_cast<std::size_t>(c.blocks), 0);
  for (const auto b : c.unknown_block) ++size.at(static_cast<std::size_t>(b));
  return size;
}

inline std::int64_t solved(const GroupedSystem& s) {
  std::int64_t n = 0;
  for (const SolvedGroup& g : s.groups) n += static_cast<std::int64_t>(g.unknowns.size());
  return n;
}

// Start value of "C.x" in SI units, also if presolve has eliminated it.
inline double start(const GroupedSystem& s, const std::string& coordinate) {
  const System& system = *s.system;
  const bool is_scalar = system.find_item(coordinate) >= 0;
  const std::size_t dot = coordinate.rfind('.');
  const Item& item = system.item(is_scalar ? coordinate : coordinate.substr(0, dot));
  const int k = is_scalar ? 0 : coordinate[dot + 1] - 'x';
  return form_value<double>(system, item.form[k], s.start) * system.unit(item.dimension);
}

// Worst relative residual of the start posture, solved and checked equations alike.
inline double start_residual(const GroupedSystem& s) {
  double worst = 0;
  for (Index e = 0; e < static_cast<Index>(s.system->equations.size()); ++e) {
    const double scale = residual_scale(*s.system, e, s.start);
    const double phi = std::abs(residual<double>(*s.system, e, s.start));
    worst = std::max(worst, scale > 0 ? phi / scale : phi);
  }
  return worst;
}

inline std::string notes(const GroupedSystem& s) {
  std::string out;
  for (const Diagnostic& n : s.notes) out += n.what + "\n";
  return out;
}

// what() of the Error of `kind` that `call` throws, "" if it throws none.
template <class Call>
std::string error(Error::Kind kind, Call&& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.kind() == kind ? e.what() : std::string("wrong kind: ") + e.what();
  }
  return "";
}

}  // namespace assur::look
