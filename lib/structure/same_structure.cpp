#include "structure/same_structure.hpp"

#include <algorithm>

#include "structure/class_gears.hpp"

namespace assur {
namespace {

bool same_group(const SolvedGroup& a, const SolvedGroup& b) {
  return a.group_class == b.group_class && a.level == b.level && a.unknowns == b.unknowns &&
         a.equations == b.equations && a.inputs == b.inputs && a.constants == b.constants;
}

bool same_input(const DriverInput& a, const DriverInput& b) {
  return a.kind == b.kind && a.first == b.first && a.count == b.count && a.laws.size() == b.laws.size() &&
         a.dimension == b.dimension && a.must_not_vanish == b.must_not_vanish;
}

bool same_bound(const Bound& a, const Bound& b) {
  return a.measure == b.measure && a.is_max == b.is_max && a.ends == b.ends && a.input == b.input;
}

bool same_assignments(const System& a, const System& b) {
  const auto same_term = [](const Term& x, const Term& y) { return x.coordinate == y.coordinate; };
  return std::equal(a.assignments.begin(), a.assignments.end(), b.assignments.begin(), b.assignments.end(),
                    [&](const Assignment& x, const Assignment& y) {
                      const auto terms = a.form(x.form), others = b.form(y.form);
                      return x.coordinate == y.coordinate &&
                             std::equal(terms.begin(), terms.end(), others.begin(), others.end(), same_term);
                    });
}

// True if everything that lanes share is the same in both.
bool same_known(const System& a, const System& b) {
  const auto same_coordinate = [](const Coordinate& x, const Coordinate& y) { return x.role == y.role; };
  return a.dimension == b.dimension && a.constants.size() == b.constants.size() &&
         std::equal(a.coordinates.begin(), a.coordinates.end(), b.coordinates.begin(), b.coordinates.end(),
                    same_coordinate) &&
         std::equal(a.inputs.begin(), a.inputs.end(), b.inputs.begin(), b.inputs.end(), same_input) &&
         std::equal(a.bounds.begin(), a.bounds.end(), b.bounds.begin(), b.bounds.end(), same_bound) &&
         same_assignments(a, b);
}

// Functions cannot be compared.
bool same_gears(const System& a, const System& b) {
  const auto same_gear = [](const CallbackBlock& x, const CallbackBlock& y) {
    const auto gear = gear_of_class(x);
    return gear && gear == gear_of_class(y);
  };
  return std::equal(a.callbacks.begin(), a.callbacks.end(), b.callbacks.begin(), b.callbacks.end(), same_gear);
}

}  // namespace

bool same_structure(const GroupedSystem& a, const GroupedSystem& b) {
  if (a.system == b.system) return true;
  return a.classes == b.classes &&
         std::equal(a.groups.begin(), a.groups.end(), b.groups.begin(), b.groups.end(), same_group) &&
         a.static_coordinates == b.static_coordinates && a.watch_class == b.watch_class &&
         a.watch.inputs == b.watch.inputs && a.watch.constants == b.watch.constants &&
         same_known(*a.system, *b.system) && same_gears(*a.system, *b.system);
}

}  // namespace assur
