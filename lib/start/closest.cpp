#include "start/closest.hpp"

#include <algorithm>
#include <map>

#include "equations/system.hpp"
#include "start/assembly.hpp"
#include "start/other_postures.hpp"

namespace assur {
namespace {

constexpr double kViolated = 1e-6;  // a violation is reported above this: internal units of length, or a number

}  // namespace

ClosestPosture closest_posture(const System& s) {
  ClosestPosture out;
  out.q = s.guess;
  std::vector<Index> unknowns, equations, column(s.coordinates.size(), -1);
  for (Index c = 0; c < static_cast<Index>(s.coordinates.size()); ++c) {
    if (s.coordinates[static_cast<std::size_t>(c)].role == Role::unknown) unknowns.push_back(c);
  }
  for (Index e = 0; e < static_cast<Index>(s.equations.size()); ++e) equations.push_back(e);
  if (!unknowns.empty()) (void)fit(s, equations, unknowns, out.q, column);

  std::map<std::string, ViolatedConstraint> worst;
  for (const Index e : equations) {
    const Violation v = violation(s, e, out.q);
    if (!(v.by > kViolated * (v.is_length ? s.unit(1) : 1))) continue;
    ViolatedConstraint& known = worst[s.equation_name(e)];
    if (v.by > known.by) known = {s.equation_name(e), v.by, v.is_length};
  }
  for (auto& [name, v] : worst) out.violated.push_back(std::move(v));
  std::stable_sort(out.violated.begin(), out.violated.end(),
                   [](const ViolatedConstraint& a, const ViolatedConstraint& b) { return a.by > b.by; });
  return out;
}

}  // namespace assur
