// Random strategies of the solvers that run here.
#pragma once

#include <vector>

#include "assur/backend.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"
#include "backends/backends.hpp"
#include "dispatch/together_rules.hpp"
#include "properties/small_random_scenes.hpp"
#include "structure/grouped_system.hpp"

namespace assur::test {

inline std::vector<const Backend*> backends_here() {
  std::vector<const Backend*> out;
  for (const Backend& b : backends()) {
    if (b.why_not({}, {}).empty()) out.push_back(&b);
  }
  return out;
}

inline bool can_be_solved_together(const Scene& scene, Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  try {
    return why_not_together(group_equations(scene, options)).empty();
  } catch (const Error&) {
    return false;
  }
}

// A strategy with one chunk and one thread for a scene.
inline Strategy random_strategy(Draw& draw, const Scene& scene) {
  static const std::vector<const Backend*> here = backends_here();
  Strategy s;
  s.run.formulation = draw.of(std::vector{Formulation::global, Formulation::groups, Formulation::irreducible});
  const Backend& backend = *draw.of(here);
  s.solver.backend = backend.id;
  s.solver.lanes = 1 << draw.below(5);
  s.solver.single = backend.single && draw.below(3) == 0;
  s.solver.refine = draw.below(4) == 0;
  s.solver.reuse = draw.of(std::vector{Reuse::fresh, Reuse::fresh, Reuse::step, Reuse::run});
  s.solver.once = draw.below(3) == 0;
  s.solver.separate = !s.solver.once && draw.below(4) == 0;
  using Kind = Predictor::Kind;
  s.run.predictor = draw.of(std::vector<Predictor>{{Kind::automatic, 0},
                                                   {Kind::automatic, 0},
                                                   {Kind::taylor, 1},
                                                   {Kind::taylor, 2},
                                                   {Kind::hermite, 5},
                                                   {Kind::past, 2},
                                                   {Kind::past, 5}});
  if (draw.below(4) == 0 && can_be_solved_together(scene, s.run.formulation)) {
    s.run.together = true;
    s.solver = {.backend = std::string(kLanes.id), .lanes = kLeastTogetherLanes << draw.below(3)};
  }
  return s;
}

}  // namespace assur::test
