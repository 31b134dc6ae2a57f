#include "simulation/constraint_jacobian.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "equations/system.hpp"

namespace assur {
namespace {

// Power of length of a form, from a term whose factor is +1 or -1; empty if there is none: other factors have units.
std::optional<int> dimension_of_form(const System& s, Index form) {
  for (const Term& t : s.form(form)) {
    if (t.constant < kLiterals && t.coordinate != kOne) return s.coordinates[idx(t.coordinate)].dimension;
  }
  return {};
}

// Power of length of an equation; 0 if unknown, and for callbacks, which are in SI units.
int dimension_of(const System& s, const Equation& e) {
  for (const Product& p : s.products_of(e)) {
    const std::optional<int> a = dimension_of_form(s, p.a), b = dimension_of_form(s, p.b);
    if (p.constant < kLiterals && a && b) return *a + *b;
  }
  return e.linear >= 0 ? dimension_of_form(s, e.linear).value_or(0) : 0;
}

}  // namespace

ConstraintJacobian constraint_jacobian(const GroupedSystem& structure, std::span<const std::int32_t> groups,
                                       std::span<const double> posture) {
  const System& s = *structure.system;
  ConstraintJacobian out;
  std::vector<std::int32_t> column(s.coordinates.size(), -1);
  std::vector<double> unit;
  for (const std::int32_t g : groups) {
    for (const Index u : structure.groups[idx(g)].unknowns) {
      column[idx(u)] = static_cast<std::int32_t>(out.unknowns.size());
      out.unknowns.push_back(s.coordinate_name(u));
      unit.push_back(s.unit(s.coordinates[idx(u)].dimension));
    }
  }
  std::vector<std::map<std::int32_t, double>> entries(out.unknowns.size());  // columns: value by row
  for (const std::int32_t g : groups) {
    for (const Index e : structure.groups[idx(g)].equations) {
      const auto row = static_cast<std::int32_t>(out.equations.size());
      const double factor = s.unit(dimension_of(s, s.equations[idx(e)]));
      gradient<double>(s, e, posture, [&](Index coordinate, double value) {
        const std::int32_t c = column[idx(coordinate)];
        if (c >= 0) entries[idx(c)][row] += value * factor / unit[idx(c)];
      });
      out.equations.push_back(s.equation_name(e));
    }
  }
  out.column_start.push_back(0);
  for (const auto& of_column : entries) {
    for (const auto& [row, value] : of_column) {
      out.row.push_back(row);
      out.values.push_back(value);
    }
    out.column_start.push_back(static_cast<std::int32_t>(out.row.size()));
  }
  return out;
}

}  // namespace assur
