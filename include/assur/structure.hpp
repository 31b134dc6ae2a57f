// The kinematic structure: the groups of unknowns that are solved together, their order, and the unknowns that need not
// be solved.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"

namespace assur {

struct GroupedSystem;  // for use inside the library

// Unknowns that are solved together, and the equations that determine them.
struct Group {
  std::string name;                     // name in the scene, or made of the names of its unknowns
  std::int32_t n = 0;                   // unknowns that are solved in each step
  std::int32_t of = 0;                  // unknowns of the whole group
  std::int32_t level = 0;               // place in the solving order; groups of one level do not depend on each other
  std::int32_t group_class = -1;        // groups of one class have equations of the same form; counted from 0
  std::int32_t derivatives = 2;         // highest time derivative that is computed, 0 to 2
  std::int32_t wanted_derivatives = 2;  // highest derivative that the outputs need; the predictor needs the rest
};

// Parts of the mechanism that are not computed in each step, because no output depends on them or because they rest.
struct LeftOut {
  std::vector<std::string> groups;  // names of groups that no output depends on
  std::int64_t unknowns = 0;        // unknowns that no output depends on
  std::int64_t equations = 0;       // equations of these unknowns
  // A group of which the outputs need no accelerations.
  struct Level {
    std::string group;         // name
    std::int32_t derivatives;  // highest derivative that is computed, 0 to 2
    bool for_predictor;        // true if only the prediction needs the highest one
  };
  std::vector<Level> levels;       // all such groups
  std::int64_t static_groups = 0;  // groups without a moving driver, which are solved once
};

// A set of equations that depend on each other at the start posture, with one equation that is checked instead of
// solved.
struct Redundancy {
  // Range of validity of the dependence.
  enum class Kind : std::uint8_t {
    structural,  // the equation follows from the others, for other values of the drivers as well
    motion,      // the equation holds while the drivers follow their laws, but not for other values
    start,       // the equation holds at the start posture, but not along the motion
    unknown,     // no other posture was found to test the equation
  };
  std::vector<std::string> constraints;  // names of the dependent equations
  std::string dropped;                   // name of the equation that is checked in every step
  Kind kind = Kind::unknown;             // range of validity
  // Size of the violation where the equation does not hold, |Phi| / |grad Phi| (Kind::start: along the motion;
  // Kind::motion: at other values of the drivers); in m if is_length.
  double violation = 0;
  bool is_length = false;  // true if the violation is a length
  double time = 0;         // Kind::start: time of the violation, s
};

// Counts of a whole scene; parts that are left out are included.
struct StructureCounts {
  std::int64_t coordinates = 0;  // scalars of points, vectors and auxiliary unknowns
  std::int64_t unknowns = 0;     // coordinates that the equations determine
  std::int64_t derived = 0;      // scalars of body members, which are not unknowns
  std::int64_t equations = 0;    // scalar equations, including redundant ones
  std::int64_t eliminated = 0;   // unknowns that presolve eliminated
  // Degrees of freedom without the drivers: the scalars that are then free, also those that drivers prescribe, less the
  // rank of all equations but those of the drivers. The rank is the largest one at the postures that were examined. The
  // turn of a rod about its own line does not count.
  std::int64_t mobility = 0;
  std::int64_t mobility_at_start = 0;  // the same with the rank at the start posture, which may be singular
};

// The result of analyze(): groups and classes, with counts and findings for people. Copies share their parts.
// References that its functions return are valid as long as one of them. Indices are not checked.
class Structure {
 public:
  // Division of the equations.
  [[nodiscard]] Formulation formulation() const;
  // The groups in solving order: levels ascend.
  [[nodiscard]] std::vector<Group> groups() const;
  // Number of classes of groups.
  [[nodiscard]] std::int32_t classes() const;
  // Number of levels.
  [[nodiscard]] std::int32_t levels() const;
  [[nodiscard]] const StructureCounts& counts() const;
  // Names of unknowns that the equations leave free.
  [[nodiscard]] const std::vector<std::string>& undetermined() const;
  // Redundant equations.
  [[nodiscard]] const std::vector<Redundancy>& redundant() const;
  // Parts that are not computed in each step.
  [[nodiscard]] const LeftOut& left_out() const;
  // Findings of the assembly, e.g. if a group was assembled on another branch.
  [[nodiscard]] const std::vector<Diagnostic>& notes() const;
  // Reason why the start posture cannot be assembled: the group and its most violated constraint; "": it is assembled.
  [[nodiscard]] const std::string& cannot_assemble() const;

  // Name of the group that a status is about; "" for a place of another kind.
  [[nodiscard]] std::string name_of(Place place) const;
  // Size of a group and number of groups of its class. All counts of operations and terms are 0: candidates() needs
  // Plan::Choice::shape, which has them.
  [[nodiscard]] Shape shape(std::int32_t group) const;
  // Pattern of the Jacobian of a class: columns in the order of the unknowns, rows in the order of the equations.
  [[nodiscard]] const Pattern& pattern(std::int32_t group_class) const;
  // Nonzeros of L + U of a group's Jacobian at the start posture, with columns ordered by approximate minimum degree of
  // J^T J and threshold pivoting (CSparse: Davis, Direct Methods for Sparse Linear Systems, 2006). -1 if singular.
  // Needs the library assur::assur.
  [[nodiscard]] std::int32_t fill(std::int32_t group) const;

  explicit Structure(std::shared_ptr<const GroupedSystem> parts);  // for use inside the library

 private:
  friend struct GroupedSystem;
  std::shared_ptr<const GroupedSystem> parts_;
};

// Options of analyze().
struct StructureOptions {
  Formulation formulation = Formulation::groups;  // division of the equations
  // Highest derivative that the predictor reads; 0: none.
  std::int32_t predictor_derivatives = 0;
  // Names of drivers that the program sets. They count as moving even if their law is constant.
  std::vector<std::string> controlled = {};
};

// Finds the groups of a scene and assembles its start posture. Undetermined scenes and scenes that cannot be assembled
// are described by undetermined() and cannot_assemble(). Throws Error (input) for a wrong scene, e.g. a declared group
// that is not a union of irreducible groups. Needs the library assur::assur.
[[nodiscard]] Structure analyze(const Scene& scene, const StructureOptions& options = {});

}  // namespace assur
