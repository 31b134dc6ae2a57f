// The kinematic structure: which unknowns are solved together, in which order, and what need not be solved at all.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"

namespace assur {

class System;

// The equations of a group class in local numbering; constants and coordinates are slots that each instance fills.
// Coordinates: 0..n-1 unknowns, n..n+inputs-1 inputs, -1 the constant 1. Constants: -1 = literal +1, -2 = literal -1,
// else a slot.
struct GroupClass {
  struct Term {
    std::int32_t coordinate, constant;
    friend bool operator==(const Term&, const Term&) = default;
  };
  struct Product {
    std::int32_t a, b, constant;  // forms
    friend bool operator==(const Product&, const Product&) = default;
  };
  struct Equation {
    std::int32_t products_begin, products_end;  // of a callback: its arguments, the forms `a`
    std::int32_t linear;                        // form, -1: none
    std::int32_t callback, row;                 // -1: none
    friend bool operator==(const Equation&, const Equation&) = default;
  };

  std::int32_t n = 0;  // unknowns = equations
  std::int32_t inputs = 0;
  std::int32_t constants = 0;             // slots
  std::vector<std::uint8_t> input_moves;  // inputs: 0 if it never changes
  std::vector<std::int32_t> form_start;   // forms + 1
  std::vector<Term> terms;
  std::vector<Product> products;
  std::vector<Equation> equations;           // n
  std::int32_t blocks = 1;                   // irreducible blocks, numbered in solving order
  std::vector<std::int32_t> unknown_block;   // n
  std::vector<std::int32_t> equation_block;  // n
  std::int32_t derivatives = 2;              // highest time derivative computed
  std::int32_t first_wanted = 0;             // unknowns before it are not needed in the highest derivative
  bool quadratic = true;                     // false: contains callback equations

  [[nodiscard]] std::int32_t forms() const { return static_cast<std::int32_t>(form_start.size()) - 1; }
  friend bool operator==(const GroupClass&, const GroupClass&) = default;
};

// Nonzeros of a class's Jacobian, columns in the order of its unknowns, rows in the order of its equations.
[[nodiscard]] Pattern jacobian_pattern(const GroupClass& group_class);

struct Group {
  std::string name;
  std::int32_t of = 0;     // unknowns before the cut; n of the class are solved
  std::int32_t level = 0;  // groups of one level are independent of each other
  std::int32_t group_class = -1;
  std::int32_t derivatives = 2;         // highest derivative computed
  std::int32_t wanted_derivatives = 2;  // highest derivative that an output needs; the rest is for the predictor
  // What fills the class's slots: indices into the coordinates and constants of the system.
  std::vector<std::int32_t> unknowns;   // n
  std::vector<std::int32_t> equations;  // n
  std::vector<std::int32_t> inputs;
  std::vector<std::int32_t> constants;
};

// What is not built, evaluated or stored because no output depends on it.
struct LeftOut {
  std::vector<std::string> groups;  // named whole groups
  std::int64_t unknowns = 0;
  std::int64_t equations = 0;
  struct Level {
    std::string group;
    std::int32_t derivatives;  // highest derivative computed, of 2
    bool for_predictor;        // some of them only to predict the next posture
  };
  std::vector<Level> levels;  // groups that compute less than accelerations, or compute them for the predictor only
  std::int64_t static_groups = 0;  // no moving driver: solved once
};

// An equation set of which one depends on the others at the start posture.
struct Redundancy {
  enum class Kind : std::uint8_t {
    structural,  // it follows from the others: at other values of the drivers, too
    motion,      // it holds while the drivers run as their laws say, at other values of them it does not
    start,       // it holds at the start posture and ceases to as the drivers move
    unknown,     // no other posture was found to look at
  };
  std::vector<std::string> constraints;  // the nonzeros of a left null vector
  std::string dropped;                   // the one that is checked instead of solved
  Kind kind = Kind::unknown;
  // Where it does not hold, elsewhere on the path (start) or off it (motion): by how much, |Phi| / |grad Phi|; in m
  // if is_length.
  double violation = 0;
  bool is_length = false;
  double time = 0;  // start: when
};

// What a watched equation is, for messages.
struct Watched {
  std::string name;
  bool is_length = false;  // |Phi| / |grad Phi| is a length
};

struct Structure {
  std::shared_ptr<const System> system;  // after presolve, if the formulation has it
  Formulation formulation = Formulation::groups;

  std::vector<GroupClass> classes;
  std::vector<Group> groups;  // in solving order, levels ascend
  std::int32_t levels = 0;

  // Counts of the scene, before anything is left out.
  std::int64_t coordinates = 0;  // scalars of points, vectors and auxiliaries
  std::int64_t unknowns = 0;
  std::int64_t derived = 0;  // scalars of body members
  std::int64_t equations = 0;
  std::int64_t eliminated = 0;            // by presolve
  // Degrees of freedom without the drivers: unknowns less the rank of all equations but the drivers', at the postures
  // looked at where that is largest; and at the start posture, which may be singular.
  std::int64_t mobility = 0;
  std::int64_t mobility_at_start = 0;
  std::vector<std::string> undetermined;  // unknowns that nothing fixes
  std::vector<Redundancy> redundant;
  LeftOut left_out;

  std::vector<std::int32_t> checks;  // equations that are watched, not solved
  // The watched ones that move, as a group without unknowns.
  Group watch;
  GroupClass watch_class;                        // no equations: nothing to watch
  std::vector<Watched> watched;                  // its equations
  std::vector<std::int32_t> static_coordinates;  // solved once
  std::vector<double> start;                     // assembled posture, all coordinates, internal units
  std::vector<Diagnostic> notes;                 // assembly: other mode than the guess, a singular start, ...
  // Why the start posture cannot be assembled: the group and its most violated constraint; empty: it can.
  std::string cannot_assemble;

  // The name of a group; "" for any other place.
  [[nodiscard]] std::string name_of(Place place) const {
    return place.is(Place::Kind::group) ? groups[static_cast<std::size_t>(place.index)].name : std::string();
  }
  [[nodiscard]] Shape shape(const Group& group) const;
  // Nonzeros of L + U of a group's Jacobian at the start posture, columns ordered by COLAMD-like minimum degree.
  [[nodiscard]] std::int32_t fill(const Group& group) const;
  [[nodiscard]] Pattern pattern(std::int32_t group_class) const;
};

struct StructureOptions {
  Formulation formulation = Formulation::groups;
  // Highest derivative that the predictor reads: 0 for none.
  std::int32_t predictor_derivatives = 0;
  // Drivers that the program sets itself; they count as moving even if their law is constant.
  std::vector<std::string> controlled;
  // Where to look instead of the guess at the scene's start: a posture (all coordinates of Structure::system, internal
  // units) and its time. The independent ones among redundant equations are chosen there.
  std::vector<double> posture;
  double time = 0;
};

// Finds the groups of a scene and assembles its start posture. Throws Error (input), among others for a declared group
// that is no union of irreducible groups. An undetermined or impossible scene is described, not refused: see
// `undetermined` and `cannot_assemble`.
[[nodiscard]] Structure analyze(const Scene& scene, const StructureOptions& options = {});

}  // namespace assur
