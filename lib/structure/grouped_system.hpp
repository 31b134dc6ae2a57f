// The equations of a scene, divided into groups, with the start posture: what analyze() finds, as the library uses it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "assur/structure.hpp"
#include "start/findings.hpp"

namespace assur {

class System;  // the equations with their coordinates

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
    struct EquationOfRow {
      std::int32_t equation, row;
      friend bool operator==(const EquationOfRow&, const EquationOfRow&) = default;
    };
    std::int32_t callback;                // index into the callbacks of the system
    std::vector<EquationOfRow> rows;      // rows in this group; redundant rows may be missing
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

// A group with the slots of its class, filled with indices into the coordinates, equations and constants of the system.
struct SolvedGroup : Group {
  std::vector<std::int32_t> unknowns;   // n
  std::vector<std::int32_t> equations;  // n
  std::vector<std::int32_t> inputs;     // inputs of the class
  std::vector<std::int32_t> constants;  // constants of the class
};

// Description of a watched equation for messages.
struct Watched {
  std::string name;        // name of the constraint, driver or body that it comes from
  bool is_length = false;  // true if |Phi| / |grad Phi| is a length
};

// Classes, groups and start posture, with counts and findings for people.
struct GroupedSystem : StartFindings {
  std::shared_ptr<const System> system;           // the equations, after presolve if `irreducible`
  Formulation formulation = Formulation::groups;  // division of the equations

  std::vector<GroupClass> classes;  // equations, one for each type of group
  std::vector<SolvedGroup> groups;  // in solving order: levels ascend
  std::int32_t levels = 0;          // number of levels

  LeftOut left_out;              // parts that are not computed in each step
  SolvedGroup watch;             // those `checks` that move and are watched in each step, as a group without unknowns
  GroupClass watch_class;        // class of `watch`; without equations if nothing is watched
  std::vector<Watched> watched;  // descriptions of its equations
  std::vector<std::int32_t> static_coordinates;  // unknowns that are solved once: indices into the coordinates
  std::vector<double> start;                     // start posture: all coordinates, internal units

  // The parts of a Structure.
  [[nodiscard]] static const GroupedSystem& of(const Structure& structure) { return *structure.parts_; }

  // Name of a group; "" for a place of another kind.
  [[nodiscard]] std::string name_of(Place place) const {
    return place.is(Place::Kind::group) ? groups[static_cast<std::size_t>(place.index)].name : std::string();
  }
  [[nodiscard]] Shape shape(const SolvedGroup& group) const;             // Structure::shape()
  [[nodiscard]] std::int32_t fill(const SolvedGroup& group) const;       // Structure::fill()
  [[nodiscard]] const Pattern& pattern(std::int32_t group_class) const;  // Structure::pattern()
};

// Number of groups of a class.
struct ClassSize {
  std::int32_t groups = 0;
  std::int32_t side_by_side = 0;  // largest number on one level
};
// Of all classes.
[[nodiscard]] std::vector<ClassSize> class_sizes(const GroupedSystem& structure);

// How a grouped system has the groups at rest that its outputs need: no driver moves them, or their drivers have
// constant laws.
enum class AtRest : std::uint8_t {
  left_out,  // as static coordinates, which are solved with the start posture
  in_front,  // as groups before all others, so that many mechanisms can solve them side by side
};

[[nodiscard]] inline bool rests(const GroupClass& c) {
  return std::none_of(c.input_moves.begin(), c.input_moves.end(), [](std::uint8_t moves) { return moves != 0; });
}

// The posture at which redundant equations are chosen, and how groups at rest are kept.
struct KnownStart {
  std::vector<double> posture;  // all coordinates, internal units; empty: the posture is assembled from the guess
  double time = 0;              // s
  bool is_first = true;         // false: the functions of the scene have been checked at another posture
  AtRest at_rest = AtRest::left_out;
  std::vector<std::int32_t> checked = {};  // the equations that are rather checked than solved, if they are redundant
};

// Finds the groups of a scene and assembles its start posture, as analyze().
[[nodiscard]] GroupedSystem group_equations(const Scene& scene, const StructureOptions& options = {},
                                            const KnownStart& start = {});

}  // namespace assur
