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

class System;  // the equations with their coordinates; for use inside the library

// The equations that all groups of a class share, as a program in local numbers: it computes Phi, the Jacobian, and the
// right-hand sides of velocity and acceleration. It holds no numbers and no pointers: each group fills the slots for
// coordinates and constants with its own, and members of an ensemble share it. Forms (differences) come first, then
// products. Local coordinates are registers: 0 to n - 1 are unknowns, n to n + inputs - 1 inputs; then follow the
// number one, and the forms that are no plain coordinate. Every list is processed in order.
struct GroupClass {
  // Content of a coefficient slot: literal * product of up to three constants of the group (-1: none).
  struct Coefficient {
    double literal = 1;
    std::int32_t constant[3] = {-1, -1, -1};
    friend bool operator==(const Coefficient&, const Coefficient&) = default;
  };
  // One addend: coefficient * register.
  struct Operand {
    std::int32_t coefficient, reg;
    friend bool operator==(const Operand&, const Operand&) = default;
  };
  // One addend: coefficient * a * b.
  struct Product {
    std::int32_t coefficient, a, b;  // a, b: registers
    friend bool operator==(const Product&, const Product&) = default;
  };
  // [begin, end) of a list.
  struct Range {
    std::int32_t begin, end;
    friend bool operator==(const Range&, const Range&) = default;
  };
  // A register as a sum of `operands`: first constants and inputs at rest, then moving inputs, then unknowns.
  struct Form {
    std::int32_t reg, begin, moving, unknowns, end;
    friend bool operator==(const Form&, const Form&) = default;
  };
  // Ranges of the lists with these names. Phi_i = linear + products. -Phi_h h' = -(input_linear + input_products), with
  // the rate of register a. -d/dt(Phi_q) q' = -curvature, with the rates of both registers.
  struct Equation {
    Range linear, products, input_linear, input_products, curvature;
    std::int32_t factors;  // from there on, the linear operands are products with a constant factor
    std::int32_t gear;     // -1: none
    friend bool operator==(const Equation&, const Equation&) = default;
  };
  // A callback of the scene, which gives some of the equations.
  struct CallbackUse {
    // An equation, and the row of the callback that gives it.
    struct Row {
      std::int32_t equation, row;
      friend bool operator==(const Row&, const Row&) = default;
    };
    std::int32_t callback;                // index into the callbacks of the system
    std::vector<Row> rows;                // rows in this group; redundant rows may be missing
    std::vector<std::int32_t> arguments;  // registers; ~coefficient for a constant one
    friend bool operator==(const CallbackUse&, const CallbackUse&) = default;
  };
  // Chain rule through an argument of a callback: J[row, argument] * coefficient.
  struct CallbackEntry {
    std::int32_t nonzero, callback, row, argument, coefficient;  // callback: index into `callbacks`
    friend bool operator==(const CallbackEntry&, const CallbackEntry&) = default;
  };
  // A gear or rack: sin(total) = 0, or total = 0; total = sum of factor * coordinate over its sides.
  struct Gear {
    struct Side {
      double factor;
      // 1: a displacement. 4 in the plane, 9 in space: the angle between two directions, about an axis in space; their
      // components in this order.
      std::int32_t arguments;
      friend bool operator==(const Side&, const Side&) = default;
    };
    std::vector<Side> sides;
    bool is_periodic = false;                 // sin(total)
    std::vector<double> unit;                 // arguments: SI value of one internal unit
    std::vector<std::int32_t> arguments;      // registers; ~coefficient for a constant one
    std::int32_t first = 0, first_angle = 0;  // arguments, and angles, of the gears before it
    friend bool operator==(const Gear&, const Gear&) = default;
  };
  // Chain rule through an argument of a gear, as CallbackEntry; ordered by nonzero.
  struct GearEntry {
    std::int32_t nonzero, gear, argument, coefficient;
    friend bool operator==(const GearEntry&, const GearEntry&) = default;
  };

  std::int32_t n = 0;                        // unknowns, and equations
  std::int32_t inputs = 0;                   // coordinates that the equations read and do not solve
  std::int32_t constants = 0;                // slots for constants
  std::vector<std::uint8_t> input_moves;     // inputs: 0 if the input never changes
  std::int32_t blocks = 1;                   // irreducible blocks, numbered in solving order
  std::vector<std::int32_t> unknown_block;   // n: block of each unknown
  std::vector<std::int32_t> equation_block;  // n: block of each equation
  std::int32_t derivatives = 2;              // highest time derivative that is computed, 0 to 2
  std::int32_t first_wanted = 0;             // unknowns before this one are not needed in the highest derivative

  Pattern pattern;  // of the Jacobian: columns in the order of the unknowns, rows in the order of the equations
  std::vector<Coefficient> coefficients;
  std::vector<Form> forms;
  std::vector<Operand> operands;  // of forms
  std::vector<Equation> equations;
  std::vector<Operand> linear, input_linear;
  std::vector<Product> products, input_products, curvature;
  std::vector<Range> entries;  // nonzeros of the Jacobian: each is a sum of `entry_operands`
  std::vector<Operand> entry_operands;
  std::vector<CallbackUse> callbacks;
  std::vector<CallbackEntry> callback_entries;
  std::vector<Gear> gears;
  std::int32_t gear_arguments = 0, gear_angles = 0;  // of all gears
  std::vector<GearEntry> gear_entries;

  // The register that is 1.
  [[nodiscard]] std::int32_t one() const { return n + inputs; }
  // Number of registers.
  [[nodiscard]] std::int32_t registers() const { return one() + 1 + static_cast<std::int32_t>(forms.size()); }
  // False if there are equations of callbacks or gears.
  [[nodiscard]] bool quadratic() const { return callbacks.empty() && gears.empty(); }
  friend bool operator==(const GroupClass&, const GroupClass&) = default;
};

// Unknowns that are solved together, and the equations that determine them.
struct Group {
  std::string name;                     // name in the scene, or made of the names of its unknowns
  std::int32_t of = 0;                  // number of unknowns of the whole group; GroupClass::n of them are solved
  std::int32_t level = 0;               // place in the solving order; groups of one level do not depend on each other
  std::int32_t group_class = -1;        // index into Structure::classes
  std::int32_t derivatives = 2;         // highest time derivative that is computed, 0 to 2
  std::int32_t wanted_derivatives = 2;  // highest derivative that the outputs need; the predictor needs the rest
  // The slots of the class, filled with indices into the coordinates, equations and constants of the system.
  std::vector<std::int32_t> unknowns;   // n
  std::vector<std::int32_t> equations;  // n
  std::vector<std::int32_t> inputs;     // inputs of the class
  std::vector<std::int32_t> constants;  // constants of the class
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

// Description of a watched equation for messages.
struct Watched {
  std::string name;        // name of the constraint, driver or body that it comes from
  bool is_length = false;  // true if |Phi| / |grad Phi| is a length
};

// The result of analyze(): classes, groups and start posture, with counts and findings for people.
struct Structure {
  std::shared_ptr<const System> system;           // the equations, after presolve if `irreducible`
  Formulation formulation = Formulation::groups;  // division of the equations

  std::vector<GroupClass> classes;  // equations, one for each type of group
  std::vector<Group> groups;        // in solving order: levels ascend
  std::int32_t levels = 0;          // number of levels

  // Counts of the whole scene; parts that are left out are included.
  std::int64_t coordinates = 0;  // scalars of points, vectors and auxiliary unknowns
  std::int64_t unknowns = 0;     // coordinates that the equations determine
  std::int64_t derived = 0;      // scalars of body members, which are not unknowns
  std::int64_t equations = 0;    // scalar equations, including redundant ones
  std::int64_t eliminated = 0;   // unknowns that presolve eliminated
  // Degrees of freedom without the drivers: the scalars that are then free, also those that drivers prescribe, less the
  // rank of all equations but those of the drivers. The rank is the largest one at the postures that were examined. The
  // turn of a rod about its own line does not count.
  std::int64_t mobility = 0;
  std::int64_t mobility_at_start = 0;     // the same with the rank at the start posture, which may be singular
  std::vector<std::string> undetermined;  // names of unknowns that the equations leave free
  std::vector<Redundancy> redundant;      // redundant equations, in the order of `checks`
  LeftOut left_out;                       // parts that are not computed in each step

  std::vector<std::int32_t> checks;  // redundant equations: indices into the equations of the system
  Group watch;                   // those `checks` that move and are watched in each step, as a group without unknowns
  GroupClass watch_class;        // class of `watch`; without equations if nothing is watched
  std::vector<Watched> watched;  // descriptions of its equations
  std::vector<std::int32_t> static_coordinates;  // unknowns that are solved once: indices into the coordinates
  std::vector<double> start;      // for use inside the library: start posture, all coordinates, internal units
  std::vector<Diagnostic> notes;  // findings of the assembly, e.g. if a group was assembled on another branch
  // Reason why the start posture cannot be assembled: the group and its most violated constraint; "": it is assembled.
  std::string cannot_assemble;

  // Name of a group; "" for a place of another kind.
  [[nodiscard]] std::string name_of(Place place) const {
    return place.is(Place::Kind::group) ? groups[static_cast<std::size_t>(place.index)].name : std::string();
  }
  // Size of a group and number of groups of its class. All counts of operations and terms are 0: candidates() needs
  // Plan::Choice::shape, which has them.
  [[nodiscard]] Shape shape(const Group& group) const;
  // Nonzeros of L + U of a group's Jacobian at the start posture, with columns ordered by approximate minimum degree of
  // J^T J and threshold pivoting (CSparse: Davis, Direct Methods for Sparse Linear Systems, 2006). -1 if singular.
  // Needs the library assur::assur.
  [[nodiscard]] std::int32_t fill(const Group& group) const;
  // Pattern of the Jacobian of a class.
  [[nodiscard]] const Pattern& pattern(std::int32_t group_class) const;
};

// Options of analyze().
struct StructureOptions {
  Formulation formulation = Formulation::groups;  // division of the equations
  // Highest derivative that the predictor reads; 0: none.
  std::int32_t predictor_derivatives = 0;
  // Names of drivers that the program sets. They count as moving even if their law is constant.
  std::vector<std::string> controlled;
  // For use inside the library: a posture (all coordinates of Structure::system, internal units) that replaces the
  // guess, for example to choose other independent equations among redundant ones. Empty: the guess of the scene.
  std::vector<double> posture;
  double time = 0;                         // time of `posture`, s
  std::vector<std::int32_t> checked = {};  // the equations that are rather checked than solved, if they are redundant
};

// Finds the groups of a scene and assembles its start posture. Undetermined scenes and scenes that cannot be assembled
// are described by `undetermined` and `cannot_assemble`. Throws Error (input) for a wrong scene, e.g. a declared group
// that is not a union of irreducible groups. Needs the library assur::assur.
[[nodiscard]] Structure analyze(const Scene& scene, const StructureOptions& options = {});

}  // namespace assur
