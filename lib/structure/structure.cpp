#include "structure/grouped_system.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "equations/lowering.hpp"
#include "graph/freedoms.hpp"
#include "graph/idle_parts.hpp"
#include "index.hpp"
#include "scene/tape.hpp"
#include "start/other_postures.hpp"
#include "start/redundant_sets.hpp"
#include "start/start.hpp"
#include "structure/classes.hpp"
#include "structure/cut.hpp"
#include "structure/grouped_system.hpp"
#include "structure/grouping.hpp"
#include "structure/presolve.hpp"
#include "structure/slides.hpp"

namespace assur {
namespace {

std::vector<Index> all_unknowns(const System& s) {
  std::vector<Index> unknowns;
  for (std::size_t c = 0; c < s.coordinates.size(); ++c) {
    if (s.coordinates[c].role == Role::unknown) unknowns.push_back(static_cast<Index>(c));
  }
  return unknowns;
}

// Counts coordinates, unknowns and equations of the whole scene, before parts of it are left out.
void count(const System& s, const std::vector<Index>& unknowns, GroupedSystem& out) {
  for (const Item& item : s.items) {
    if (item.hidden) continue;
    (item.derived ? out.derived : out.coordinates) += item.components;
  }
  out.unknowns = static_cast<std::int64_t>(unknowns.size());
  out.equations = static_cast<std::int64_t>(s.equations.size());
  for (const DriverInput& in : s.inputs) out.mobility += freedoms_of(s, in);
}

void list_left_out(const Blocks& blocks, const Cut& cut, AtRest at_rest, GroupedSystem& out) {
  for (Index b = 0; b < blocks.size(); ++b) {
    const auto u = blocks.unknowns_of(b);
    if (cut.is_static(b) && at_rest == AtRest::left_out)
      out.static_coordinates.insert(out.static_coordinates.end(), u.begin(), u.end());
    if (cut.is_needed(b)) continue;
    out.left_out.unknowns += static_cast<std::int64_t>(u.size());
    out.left_out.equations += static_cast<std::int64_t>(blocks.equations_of(b).size());
  }
}

// Steps of one block with up to three unknowns run in registers and compute all derivatives. A group that leaves out
// some derivatives could use neither such steps nor predictions from the derivatives of all unknowns.
constexpr std::size_t kInRegisters = 3;

// The content of a group that consists of these blocks. Unknowns that are not wanted in the highest derivative come
// first, unless the predictor reads that derivative of all unknowns, or the group is small.
GroupContent content(const Blocks& blocks, const std::vector<Index>& solved, const Cut& cut, int derivatives,
                     int predictor_derivatives) {
  GroupContent c;
  c.derivatives = derivatives;
  c.blocks = static_cast<Index>(solved.size());
  const bool is_small = solved.size() == 1 && blocks.unknowns_of(solved[0]).size() <= kInRegisters;
  const bool all = derivatives == 0 || predictor_derivatives >= derivatives || is_small;
  const auto wanted = [&](Index u) { return all || cut.need[idx(u)] >= derivatives; };
  for (const bool pass : {false, true}) {
    for (std::size_t k = 0; k < solved.size(); ++k) {
      for (const Index u : blocks.unknowns_of(solved[k])) {
        if (wanted(u) != pass) continue;
        c.unknowns.push_back(u);
        c.unknown_block.push_back(static_cast<Index>(k));
      }
    }
    if (!pass) c.first_wanted = static_cast<Index>(c.unknowns.size());
  }
  for (std::size_t k = 0; k < solved.size(); ++k) {
    for (const Index e : blocks.equations_of(solved[k])) {
      c.equations.push_back(e);
      c.equation_block.push_back(static_cast<Index>(k));
    }
  }
  return c;
}

// The groups at rest, on levels below 0. Only positions are solved: the rates are 0.
void classify_at_rest(const Blocks& blocks, const std::vector<Draft>& drafts, const Cut& cut, ClassTable& table,
                      GroupedSystem& out) {
  std::vector<Index> solved;
  for (const Draft& d : drafts) {
    solved.clear();
    std::copy_if(d.blocks.begin(), d.blocks.end(), std::back_inserter(solved),
                 [&](Index b) { return cut.is_needed(b) && cut.is_static(b); });
    if (solved.empty()) continue;
    SolvedGroup group;
    group.name = d.name;
    group.of = d.of;
    group.level = d.level - static_cast<Index>(drafts.size());
    group.wanted_derivatives = 0;
    table.classify(content(blocks, solved, cut, 0, 0), group);
    out.groups.push_back(std::move(group));
  }
}

void classify(const System& s, const Blocks& blocks, std::vector<Draft> drafts, const Cut& cut,
              int predictor_derivatives, AtRest at_rest, GroupedSystem& out) {
  ClassTable table(s, cut.moves);
  out.groups.reserve(drafts.size());
  if (at_rest == AtRest::in_front) classify_at_rest(blocks, drafts, cut, table, out);
  std::vector<Index> solved;
  for (std::size_t g = 0; g < drafts.size(); ++g) {
    const Draft d = std::move(drafts[g]);
    solved.clear();
    std::copy_if(d.blocks.begin(), d.blocks.end(), std::back_inserter(solved),
                 [&](Index b) { return cut.solved_each_step(b); });
    if (solved.empty()) {
      if (std::any_of(d.blocks.begin(), d.blocks.end(), [&](Index b) { return cut.is_static(b); })) {
        ++out.left_out.static_groups;
      } else if (!d.blocks.empty()) {
        out.left_out.groups.push_back(d.name);
      }
      continue;
    }
    const auto [wanted, computed] = cut.groups[g];
    SolvedGroup group;
    group.name = d.name;
    group.of = d.of;
    group.level = d.level;
    group.wanted_derivatives = wanted;
    table.classify(content(blocks, solved, cut, computed, predictor_derivatives), group);
    if (wanted < 2) out.left_out.levels.push_back({d.name, computed, computed > wanted});
    out.groups.push_back(std::move(group));
  }
  out.classes = table.take();
}

// Closes gaps in the levels after static and unneeded groups were removed.
void close_gaps(GroupedSystem& out) {
  std::set<Index> used;
  for (const SolvedGroup& g : out.groups) used.insert(g.level);
  const std::vector<Index> levels(used.begin(), used.end());
  for (SolvedGroup& g : out.groups) {
    g.level = static_cast<Index>(std::lower_bound(levels.begin(), levels.end(), g.level) - levels.begin());
  }
  out.levels = static_cast<Index>(levels.size());
}

// Equations of joints are named by the joints of their loops.
void name_watched(const System& s, const std::vector<Index>& equations, GroupedSystem& out) {
  std::map<std::string, std::string> names;
  for (const RedundantSet& set : redundant_sets(*s.scene, out.redundant)) {
    if (set.named.joints.empty()) continue;
    const std::string text = set.named.text();
    for (const std::string& checked : set.checked) names.emplace(checked, text);
  }
  for (const Index e : equations) {
    const std::string name = s.equation_name(e);
    const auto set = names.find(name);
    out.watched.push_back({set == names.end() ? name : set->second, is_length(s, e)});
  }
}

// Watches the unsolved equations that move and whose coordinates are known.
void watch_unsolved_equations(const System& s, const Blocks& blocks, const Cut& cut, GroupedSystem& out) {
  std::vector<std::uint8_t> available(s.coordinates.size(), 0);
  for (std::size_t c = 0; c < available.size(); ++c) available[c] = s.coordinates[c].role != Role::unknown;
  for (Index b = 0; b < blocks.size(); ++b) {
    for (const Index u : blocks.unknowns_of(b)) available[idx(u)] = cut.is_static(b) || cut.is_needed(b);
  }
  const auto is_available = [&](Index c) { return available[idx(c)] != 0; };
  const auto moves = [&](Index c) { return cut.moves[idx(c)] != 0; };
  GroupContent watched;
  watched.derivatives = 0;
  watched.blocks = 0;
  std::vector<Index> mentioned;
  for (const Index e : out.checks) {
    s.mentioned(e, mentioned);
    if (std::all_of(mentioned.begin(), mentioned.end(), is_available) &&
        std::any_of(mentioned.begin(), mentioned.end(), moves)) {
      watched.equations.push_back(e);
    }
  }
  name_watched(s, watched.equations, out);
  watched.equation_block.assign(watched.equations.size(), 0);
  ClassTable table(s, cut.moves);
  table.classify(watched, out.watch);
  out.watch_class = table.take().front();
  out.watch.name = "redundant equations";
}

// Keeps the first of equal notes.
void drop_repeated(std::vector<Diagnostic>& notes) {
  std::set<std::pair<std::string, std::string>> known;
  std::erase_if(notes, [&](const Diagnostic& note) { return !known.emplace(note.where, note.what).second; });
}

}  // namespace

GroupedSystem group_equations(const Scene& scene, const StructureOptions& options, const KnownStart& start) {
  const bool irreducible = options.formulation == Formulation::irreducible;
  const bool at_start = start.posture.empty();
  System s = lower(std::make_shared<const Scene>(scene), options.controlled, !irreducible);
  Problem p;
  GroupedSystem out;
  const auto assemble = [&] {
    const Tape::Recording none(nullptr);  // only equations are recorded
    p = {};
    p.unknowns = all_unknowns(s);
    p.q = at_start ? s.guess : start.posture;
    p.is_guess = at_start;
    p.time = at_start ? scene.time().start : start.time;
    p.checked = start.checked;
    out = {};
    out.formulation = options.formulation;
    count(s, p.unknowns, out);
    assemble_start(s, p, out);
  };
  assemble();
  if (!out.undetermined.empty() && separate_idle_parts(s, all_unknowns(s))) assemble();
  out.notes.insert(out.notes.end(), s.notes.begin(), s.notes.end());
  drop_repeated(out.notes);
  if (irreducible && out.cannot_assemble.empty()) {
    out.eliminated = presolve(s, p.equations, p.unknowns);
    if (out.eliminated > 0) p.blocks = decompose(s, p.equations, p.unknowns);
    decouple_slides(s, p.equations, p.unknowns, p.blocks);
  }
  const Tape::Recording none(nullptr);

  std::vector<Draft> drafts = form_groups(s, p.blocks, options.formulation);
  const Cut cut = cut_to_outputs(s, p.blocks, drafts, out.checks, options.predictor_derivatives);
  list_left_out(p.blocks, cut, start.at_rest, out);
  classify(s, p.blocks, std::move(drafts), cut, options.predictor_derivatives, start.at_rest, out);
  close_gaps(out);
  watch_unsolved_equations(s, p.blocks, cut, out);

  out.start = std::move(p.q);
  out.system = std::make_shared<const System>(std::move(s));
  return out;
}

Structure analyze(const Scene& scene, const StructureOptions& options) {
  return Structure(std::make_shared<const GroupedSystem>(group_equations(scene, options)));
}

}  // namespace assur
