// Assembly modes: all postures of a group at the start of a motion. A group with fixed inputs is a system of polynomial
// equations; all of its real solutions are found, not only the one that is near the guess. The functions in this header
// need the library assur::assur.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"

namespace assur {

// Most unknowns of a group whose modes are computed, not counting unknowns that linear equations eliminate.
inline constexpr int kMostUnknownsOfModes = 6;

// One posture of a group.
struct AssemblyMode {
  std::vector<double> values;  // of AssemblyModes::unknowns; SI units
  double residual = 0;         // largest relative residual of the equations
  // Condition number of the Jacobian (2-norm, rows of length 1). Two modes that nearly meet have a large one.
  double condition = 0;
};

// All modes of one group, at the start posture of the groups that it depends on.
struct AssemblyModes {
  std::string group;                  // name, as in Structure::groups() of the formulation `groups`
  std::vector<std::string> unknowns;  // names of scalars: "C.x", "slide.lambda"
  // The start posture first if `has_start`; the others ascend by the values of the unknowns. Mirror images of a body
  // that the equations of the scene allow are modes, too.
  std::vector<AssemblyMode> modes;
  bool has_start = false;  // false: the start posture cannot be assembled, or is a multiple solution (a fold)
  std::string why_none;    // reason why the modes were not computed; "": they were

  // Each of the `paths` ends at a simple solution (real or not), at infinity, at a multiple solution, or is lost.
  int paths = 0;     // 2 to the power of the unknowns that linear equations do not eliminate
  int not_real = 0;  // simple solutions with complex values
  int diverged = 0;  // paths to infinity; a solution farther away than 1000 characteristic lengths may be among them
  int multiple = 0;  // paths to solutions that meet others: folds of the group, or postures that are not isolated
  int lost = 0;      // paths whose ends are unknown
  int excluded = 0;  // real solutions at which a redundant equation or a driver's value fails, or axes are left-handed
  // Real multiple solutions, each once: values of `unknowns`, about six digits. They are not modes.
  std::vector<std::vector<double>> folds;

  // True if no mode within 1000 characteristic lengths is missing: the group was computed, and no path was lost.
  [[nodiscard]] bool complete() const { return why_none.empty() && lost == 0; }
  // Number of the mode in which a point (or vector) of the group is nearest to `at` (m), counted from 0. Components
  // that are no unknowns of the group do not count. Throws Error (input) if there is no mode, if the group does not
  // solve the point, or if two modes are equally near.
  [[nodiscard]] std::size_t nearest(std::string_view point, const Triple& at) const;
};

// A choice among the modes of a group.
struct ModeChoice {
  std::string group;     // name of the group, or of a point, vector or scalar that it solves
  std::size_t mode = 0;  // index into AssemblyModes::modes
};

// The modes of all groups, in solving order, also of those that no output needs. Groups that are too large, or have
// equations of functions or gears, have AssemblyModes::why_none. `chosen`: modes of groups; groups that depend on them
// are assembled anew from their guess, and an index of their modes counts in the list that this function returns with
// the choices for earlier groups. Throws Error: input if the scene is undetermined or a choice is wrong; numerical if
// the scene has contradictory equations. A start posture that cannot be assembled is not an error:
// AssemblyModes::has_start is false for the group at which it fails, and the groups that depend on it have why_none.
[[nodiscard]] std::vector<AssemblyModes> assembly_modes(const Scene& scene, const std::vector<ModeChoice>& chosen = {});

// The modes of one group, given by its name or by a point, vector or scalar that it solves. Throws as above, and Error
// (input) if no group has this name, or with AssemblyModes::why_none.
[[nodiscard]] AssemblyModes assembly_modes(const Scene& scene, std::string_view group,
                                           const std::vector<ModeChoice>& chosen = {});

// Like prepare(), with a start posture in which groups have the chosen modes. Groups that depend on them are assembled
// anew from their guess. Lengths and coordinates that count from the posture as written do not change. Throws like
// assembly_modes() and prepare(); Error (numerical) if a further group cannot be assembled in these modes.
[[nodiscard]] Prepared prepare_in_modes(const Scene& scene, const std::vector<ModeChoice>& chosen,
                                        const PrepareOptions& options = {});

}  // namespace assur
