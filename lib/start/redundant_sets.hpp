// Redundant equations in sets: one set for all equations that depend on each other, with the number of
// equations too many, and the joints of the scene that make them.
#pragma once

#include <string>
#include <vector>

#include "assur/scene.hpp"
#include "assur/structure.hpp"

namespace assur {

// Names of equations, in the words of the scene.
struct Named {
  std::vector<std::string> joints;  // the joints of the loops that the equations close, in the order of the scene
  std::vector<std::string> others;  // constraints, drivers and bodies without joints, in alphabetic order

  // "joints A, B, C, D", "joints A, B; rod1"; of many names, the first ones and their number.
  [[nodiscard]] std::string text() const;
};

// names: names of equations as System::equation_name() gives them.
[[nodiscard]] Named in_words_of(const Scene& scene, const std::vector<std::string>& names);

// Equations that depend on each other. Two dependences belong to one set if they share an equation or, among equations
// of joints, a body; so the sets do not depend on the choice of the equations that are solved.
struct RedundantSet {
  Named named;
  std::vector<std::string> checked;  // names of the equations that are checked, not solved; one for each too many
  Redundancy::Kind kind = Redundancy::Kind::unknown;  // kind of all dependences in the set
  Redundancy worst;                                   // the dependence with the largest violation
};

// In the order of Structure::redundant().
[[nodiscard]] std::vector<RedundantSet> redundant_sets(const Scene& scene, const std::vector<Redundancy>& redundant);

}  // namespace assur
