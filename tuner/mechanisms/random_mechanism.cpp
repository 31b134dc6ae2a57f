#include "mechanisms/random_mechanism.hpp"

#include <cmath>
#include <iterator>

#include "mechanisms/families.hpp"

namespace assur::mechanisms {
namespace {

struct Family {
  const char* name;
  int dimension;
  void (*draw)(Draft&);
};
// Another family changes the mechanism of every seed, also of those that tests keep.
constexpr Family kFamilies[] = {{"planar_chain", 2, planar_chain},
                                {"planar_platform", 2, planar_platform},
                                {"six_bar", 2, six_bar},
                                {"trammel", 2, trammel},
                                {"rssr", 3, rssr},
                                {"robot", 3, robot},
                                {"stewart", 3, stewart},
                                {"three_rps", 3, three_rps},
                                {"delta", 3, delta},
                                {"loop_in_space", 3, loop_in_space},
                                {"bennett", 3, bennett},
                                {"cardan", 3, cardan},
                                {"wishbone", 3, wishbone},
                                {"on_rails", 3, on_rails}};

// Commands that lead to limits, back from them, and to other postures.
void draw_commands(RandomMechanism& m, const Draft& draft, Draw& chance) {
  std::vector<double> at, step;
  for (const Draft::Driven& driven : draft.driven()) {
    m.controlled.push_back(driven.name);
    at.push_back(driven.begin);
  }
  m.with_rates = chance.one_in(2);
  const std::size_t steps = 20 + chance.below(60);
  std::size_t left = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    if (left == 0) {
      left = 5 + chance.below(25);
      step.clear();
      for (std::size_t i = 0; i < at.size(); ++i) {
        const Draft::Driven& driven = draft.driven()[i];
        const double target = driven.begin + driven.by * chance.real(-1.5, 1.5);
        step.push_back((target - at[i]) / static_cast<double>(left));
      }
    }
    --left;
    for (std::size_t i = 0; i < at.size(); ++i) at[i] += step[i];
    m.commands.push_back(at);
  }
}

}  // namespace

Scene RandomMechanism::scene() const { return parse_scene(json, family, tables); }

RandomMechanism random_mechanism(std::uint64_t seed, const std::string& tables) {
  Draw chance(seed);
  (void)chance.below(2);
  const Family& family = kFamilies[chance.below(std::size(kFamilies))];
  RandomMechanism m;
  m.seed = seed;
  m.family = family.name;
  m.tables = tables.empty() ? "." : tables;
  Draft draft(family.dimension, chance, tables);
  family.draw(draft);
  m.rough = draft.rough;
  m.exact = draft.finish(family.name, 0);
  m.json = draft.finish(family.name, m.rough);
  if (chance.one_in(5) && !draft.driven().empty()) draw_commands(m, draft, chance);
  m.how.budget = ThreadBudget{1};
  static constexpr const char* kStrategies[] = {"irreducible/lanes",
                                                "global/eigen",
                                                "groups/eigen",
                                                "irreducible/eigen",
                                                "groups/lanes",
                                                "irreducible/lanes+predict=taylor:2",
                                                "irreducible/eigen+predict=past:3",
                                                "irreducible/lanes:8+once"};
  if (chance.one_in(3)) m.how.strategy = kStrategies[chance.below(std::size(kStrategies))];
  if (chance.one_in(5)) m.how.accuracy = std::pow(10, chance.real(-11, -5));
  return m;
}

}  // namespace assur::mechanisms
