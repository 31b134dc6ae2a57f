#include "tuning/cells.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "assur/plan.hpp"
#include "dispatch/strategies.hpp"
#include "dispatch/together_rules.hpp"
#include "mechanisms/random_mechanism.hpp"
#include "plan/preparation.hpp"
#include "tuning/mechanisms.hpp"

namespace assur::tuning {
namespace {

constexpr std::int32_t kSmallest = 3;                  // unknowns
constexpr std::int32_t kOffTheGrid[] = {22, 78, 334};  // unknowns of cells that judge the model, between its sizes
constexpr std::pair<std::int32_t, std::int32_t> kPacksOffTheGrid[] = {
    {2, 11}, {2, 23}, {22, 5}, {78, 11}, {334, 1}};  // n, groups
constexpr double kJudges = 2;                        // weight of held-out cells: few cells judge all choices
constexpr int kEntries = 6;  // entries in a column of random matrices: more than in mechanisms, fewer than in full ones

std::function<Scene()> named(std::string text) {
  return [text = std::move(text)] { return sample(text); };
}

Cell matrix(std::string family, std::int32_t n) {
  Cell c;
  c.family = std::move(family);
  c.n = n;
  c.weight = n > 500 ? 3 : n > 100 ? 1.5 : 1;
  return c;
}

Cell random_cell(std::int32_t n, int per_row) {
  Cell c = matrix(per_row == 0 ? "full" : "random, " + std::to_string(per_row) + " a column", n);
  c.per_row = per_row == 0 ? n : per_row;
  c.at = [per_row](std::int32_t other) { return random_cell(other, per_row); };
  return c;
}

// Planar rings represent the larger groups of mechanisms.
Cell ring_cell(std::int32_t n) {
  n = std::max(12, n / 2 * 2);
  Cell c = matrix("rings", n);
  c.scene = named("rings:legs=1,terminal=12,n=" + std::to_string(n));
  c.at = ring_cell;
  return c;
}

// Four-bars in series as one system, as without group equations.
Cell chain_cell(std::int32_t n) {
  n = std::max(2, n / 2 * 2);
  Cell c = matrix("chain, global", n);
  c.scene = named("n_four_bar:" + std::to_string(n / 2));
  c.formulation = Formulation::global;
  c.at = chain_cell;
  return c;
}

void add_sizes(std::vector<Cell>& cells, const Extent& e) {
  for (const std::int32_t n : spaced(kSmallest, e.largest, e.sizes)) {
    if (n >= 12) cells.push_back(ring_cell(n));
    cells.push_back(chain_cell(n));
    if (n <= e.largest_full) cells.push_back(random_cell(n, 0));
    if (n > 2 * kEntries && n <= e.largest_random) cells.push_back(random_cell(n, kEntries));
  }
  for (const std::int32_t n : {1, 2}) cells.push_back(random_cell(n, 0));
  if (!e.held_out) return;
  for (const std::int32_t n : kOffTheGrid) {
    for (Cell c : {ring_cell(n), chain_cell(n), random_cell(n, 0), random_cell(n, kEntries)}) {
      if (n > e.largest_full && c.per_row >= n) continue;
      if (n > e.largest_random && c.per_row > 0 && c.per_row < n) continue;
      if (n > e.largest) continue;
      c.held_out = true;
      c.weight *= kJudges;
      cells.push_back(std::move(c));
    }
  }
}

// Adds every class of a sample in one formulation.
void add_classes(std::vector<Cell>& cells, const std::string& text, Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  const GroupedSystem structure = group_equations(sample(text), options);
  for (std::size_t k = 0; k < structure.classes.size(); ++k) {
    Cell c = matrix(text + ", " + std::string(name(formulation)), structure.classes[k].n);
    c.scene = named(text);
    c.formulation = formulation;
    c.group_class = static_cast<std::int32_t>(k);
    cells.push_back(std::move(c));
  }
}

Cell packs(std::string family, std::int32_t n, std::int32_t groups, std::function<Scene()> scene, Formulation f) {
  Cell c;
  c.kind = Cell::Kind::packs;
  c.family = std::move(family);
  c.n = n;
  c.groups = groups;
  c.scene = std::move(scene);
  c.formulation = f;
  c.policies = groups == 1 || groups == 8;
  c.weight = n * groups > 10'000 ? 4 : n * groups > 1000 ? 2 : 1;
  return c;
}

Cell dyad_packs(std::int32_t groups) {
  return packs(
      "dyads", 2, groups, [groups] { return dyads(groups); }, Formulation::irreducible);
}
// A platform has six legs, so the number of groups is rounded up to a multiple of six.
Cell leg_packs(std::int32_t groups, Formulation formulation) {
  const std::int32_t platforms = (groups + 5) / 6, n = formulation == Formulation::groups ? 15 : 3;
  return packs("legs, " + std::string(name(formulation)), n, 6 * platforms,
               named("stewart:platforms=" + std::to_string(platforms)), formulation);
}
Cell ring_packs(std::int32_t n, std::int32_t groups) {
  return packs("rings", n, groups,
               named("rings:terminal=12,n=" + std::to_string(n) + ",legs=" + std::to_string(groups)),
               Formulation::groups);
}

// Dyads or tripods in series, solved by +together.
Cell series(std::int32_t n, std::int32_t groups) {
  Cell c = packs(
      n == 2 ? "dyads in series" : "tripods in series", n, groups,
      n == 2 ? named("four_bar:" + std::to_string(groups)) : [groups] { return tripods(groups); },
      Formulation::irreducible);
  c.kind = Cell::Kind::together;
  c.weight = 0.5;
  return c;
}

// Four-bars in series as one system, as without group equations.
Cell chain_packs(std::int32_t n) {
  return packs("chain, global", n, 1, named("n_four_bar:" + std::to_string(n / 2)), Formulation::global);
}

bool is_within(const Cell& c, const Extent& e) {
  return std::int64_t{c.n} * c.groups <= e.most_unknowns && c.n <= e.largest;
}

// Several crowds are spread over a run, because other programs change from second to second how much threads slow each
// other down. groups: a number that no other cell has, because a crowd is compared with samples of its own race.
void add_crowds(std::vector<Cell>& cells, const Extent& e, std::int32_t groups) {
  for (Cell c : {dyad_packs(groups), leg_packs(groups, Formulation::groups), ring_packs(60, groups)}) {
    c.kind = Cell::Kind::crowd;
    c.policies = false;
    if (is_within(c, e)) cells.push_back(std::move(c));
  }
}

void add_packs(std::vector<Cell>& cells, const Extent& e) {
  const auto add = [&](Cell c) {
    if (is_within(c, e)) cells.push_back(std::move(c));
  };
  for (const std::int32_t groups : {1, 8, 100, 1000, 10'000}) {
    if (groups > e.most_groups) continue;
    add(dyad_packs(groups));
    if (groups > 1) add(leg_packs(groups, Formulation::irreducible));
    if (groups > 1) add(leg_packs(groups, Formulation::groups));
    add(ring_packs(60, groups));
  }
  for (const std::int32_t n : {12, 24, 120, 240, 720, 2000}) {
    for (const std::int32_t groups : {1, 8, 64}) {
      if (groups == 1 || n * groups < 20'000) add(ring_packs(n, groups));
    }
  }
  for (const std::int32_t n : {4, 8, 20, 60, 200}) add(chain_packs(n));
  for (const std::int32_t groups : {4, 8, 16, 64, 1000}) {
    if (groups > e.most_groups) continue;
    add(series(2, groups));
    if (groups > 4) add(series(3, groups));
  }
  if (!e.held_out) return;
  for (const auto& [n, groups] : kPacksOffTheGrid) {
    Cell c = n == 2 ? dyad_packs(groups) : ring_packs(n, groups);
    c.held_out = true;
    c.weight *= kJudges;
    add(std::move(c));
  }
}

Cell steps(std::string family, std::function<Scene()> scene, Formulation formulation) {
  Cell c;
  c.kind = Cell::Kind::steps;
  c.family = std::move(family);
  c.scene = std::move(scene);
  c.formulation = formulation;
  return c;
}

Cell around(Cell of_steps) {
  of_steps.kind = Cell::Kind::around;
  return of_steps;
}

// Random mechanisms as users write them, one of each kind: small groups in a few levels, which take few lanes, and in
// `global` one system that could be divided.
void add_mechanisms(std::vector<Cell>& cells) {
  constexpr std::uint64_t kCardan = 13, kRssr = 48, kChain = 53, kWishbone = 60, kLoop = 66, kRobot = 72,
                          kThreeRps = 73, kDelta = 84, kStewart = 85, kPlatform = 102;
  constexpr double kSlowStep = 1e-4;  // s
  constexpr int kSlowSteps = 1000;
  for (const std::uint64_t seed :
       {kCardan, kRssr, kChain, kWishbone, kLoop, kRobot, kThreeRps, kDelta, kStewart, kPlatform}) {
    const mechanisms::RandomMechanism drawn = mechanisms::random_mechanism(seed);
    // Slow enough for one Newton iteration in each step, and for no test of the branch.
    const double start = drawn.scene().time().start;
    const Scene scene = drawn.scene().with_time({start, start + kSlowSteps * kSlowStep, kSlowStep});
    for (const Formulation f : formulations_of(group_equations(scene, {.formulation = Formulation::irreducible}))) {
      Cell c = steps(
          "random " + drawn.family + ", " + std::string(name(f)), [scene] { return scene; }, f);
      c.weight = 0.5;
      cells.push_back(around(std::move(c)));
    }
  }
}

}  // namespace

std::string to_string(const Cell& cell) {
  if (cell.kind == Cell::Kind::meeting) {
    return cell.n == 0 ? "meetings of threads" : "meetings of threads, " + std::to_string(cell.n) + " doubles";
  }
  std::string text = cell.family;
  if (cell.kind == Cell::Kind::steps) return text + ", whole steps";
  if (cell.kind == Cell::Kind::around) return text + ", steps without their packs";
  text += ", n = " + std::to_string(cell.n);
  if (cell.kind != Cell::Kind::matrix)
    text += ", " + std::to_string(cell.groups) + (cell.groups == 1 ? " group" : " groups");
  if (cell.kind == Cell::Kind::together) text += ", together";
  if (cell.kind == Cell::Kind::crowd) text += ", all threads";
  return text;
}

bool is_held_out(Kernel kernel, const Shape& shape) {
  switch (kernel) {
    case Kernel::evaluate:
    case Kernel::factor:
    case Kernel::solve:
      return std::find(std::begin(kOffTheGrid), std::end(kOffTheGrid), shape.n) != std::end(kOffTheGrid);
    case Kernel::pack:
      return std::find(std::begin(kPacksOffTheGrid), std::end(kPacksOffTheGrid), std::pair(shape.n, shape.groups)) !=
             std::end(kPacksOffTheGrid);
    case Kernel::meeting:
    case Kernel::step:
    case Kernel::around:
      break;
  }
  return false;
}

std::vector<std::int32_t> spaced(std::int32_t from, std::int32_t to, int count) {
  std::vector<std::int32_t> out;
  for (int i = 0; i < count; ++i) {
    const double share = count == 1 ? 0 : static_cast<double>(i) / (count - 1);
    const auto n = static_cast<std::int32_t>(std::lround(from * std::pow(static_cast<double>(to) / from, share)));
    if (out.empty() || n > out.back()) out.push_back(n);
  }
  return out;
}

std::vector<Cell> general_cells(const Extent& extent) {
  std::vector<Cell> cells;
  for (const std::int32_t doubles : {0, 4000}) {
    Cell meeting;
    meeting.kind = Cell::Kind::meeting;
    meeting.family = "meeting";
    meeting.n = doubles;
    cells.push_back(std::move(meeting));
  }
  for (const char* text :
       {"four_bar", "andrews", "stewart", "four_bar:64", "rings:legs=6,n=120", "stewart:platforms=40"}) {
    cells.push_back(around(steps(std::string(text) + ", groups", named(text), Formulation::groups)));
  }
  cells.push_back(around(steps("stewart, irreducible", named("stewart"), Formulation::irreducible)));
  add_mechanisms(cells);
  add_crowds(cells, extent, 84);
  add_sizes(cells, extent);
  add_crowds(cells, extent, 90);
  for (const Formulation f : {Formulation::global, Formulation::groups, Formulation::irreducible}) {
    for (const char* text : {"stewart", "andrews", "slider_crank", "four_bar"}) add_classes(cells, text, f);
  }
  add_crowds(cells, extent, 96);
  add_packs(cells, extent);
  for (const char* text : {"stewart", "andrews", "four_bar:64", "rings:legs=6,n=120"}) {
    cells.push_back(steps(std::string(text) + ", groups", named(text), Formulation::groups));
  }
  cells.push_back(steps("stewart, irreducible", named("stewart"), Formulation::irreducible));
  add_crowds(cells, extent, 108);
  return cells;
}

std::vector<Cell> scene_cells(const std::string& text, const Scene& scene) {
  std::vector<Cell> cells;
  const auto same = [scene] { return scene; };
  for (const Formulation f : {Formulation::global, Formulation::groups, Formulation::irreducible}) {
    PrepareOptions options;
    options.strategy = std::string(name(f)) + "/eigen";
    options.budget = ThreadBudget{1};
    const Prepared prepared = prepare(scene, options);
    const GroupedSystem& structure = *preparation(prepared).structure;
    if (structure.classes.empty())
      throw Error(Error::Kind::input, {{text, "nothing in it moves, so there is nothing to time"}});
    const std::string family = text + ", " + std::string(name(f));
    const std::vector<ClassSize> sizes = class_sizes(structure);
    for (std::size_t k = 0; k < structure.classes.size(); ++k) {
      const auto group_class = static_cast<std::int32_t>(k);
      Cell m = matrix(family, structure.classes[k].n);
      m.group_class = group_class;
      Cell p = packs(family, m.n, sizes[k].side_by_side, same, f);
      p.group_class = group_class;
      p.policies = true;
      m.scene = same;
      m.formulation = f;
      cells.push_back(std::move(m));
      cells.push_back(std::move(p));
    }
    // The time of a step together is that of all classes, so it tells the time of a pack only if there is one class.
    if (structure.classes.size() == 1 && structure.levels > 1 && why_not_together(structure).empty()) {
      const auto groups = static_cast<std::int32_t>(structure.groups.size());
      cells.push_back(packs(family, structure.classes[0].n, groups, same, f));
      cells.back().kind = Cell::Kind::together;
    }
    cells.push_back(steps(family, same, f));
    cells.push_back(around(cells.back()));
  }
  return cells;
}

}  // namespace assur::tuning
