#include "commands/structure_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "commands/left_out.hpp"
#include "decimal.hpp"
#include "equations/system.hpp"
#include "index.hpp"
#include "output/format.hpp"
#include "output/notes.hpp"
#include "start/redundant_sets.hpp"
#include "status_text.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kMostRows = 20;     // above this, groups are shown by class
constexpr std::size_t kMostClasses = 40;  // further classes are only counted
constexpr std::size_t kLongestName = 20;  // columns

// Figures of all groups of a class.
struct ClassFigures {
  std::int64_t groups = 0;
  const Group* first = nullptr;
  std::int32_t lowest_level = 0, highest_level = 0;
  std::int32_t nnz = 0;
  std::int32_t fill = -1;  // -1: the Jacobian is singular at the start posture
};

std::vector<ClassFigures> class_figures(const GroupedSystem& s) {
  std::vector<ClassFigures> figures(s.classes.size());
  for (const SolvedGroup& g : s.groups) {
    ClassFigures& f = figures[idx(g.group_class)];
    if (f.groups++ == 0) {
      f.first = &g;
      f.lowest_level = g.level;
      f.nnz = s.pattern(g.group_class).nnz();
      if (s.cannot_assemble.empty()) f.fill = s.fill(g);
    }
    f.highest_level = g.level;  // groups ascend by level
  }
  return figures;
}

// Unknowns of the irreducible blocks of a class, in solving order.
std::vector<std::int32_t> block_sizes(const GroupClass& c) {
  std::vector<std::int32_t> sizes(idx(c.blocks), 0);
  for (const std::int32_t b : c.unknown_block) ++sizes[idx(b)];
  return sizes;
}

std::string kind_name(Redundancy::Kind kind) {
  static constexpr std::array kNames = {"structural", "motion", "start", "unknown"};
  return kNames[static_cast<std::size_t>(kind)];
}

Json to_json(const Limit& l) {
  return {{"quantity", l.quantity},
          {"min", or_null(std::isfinite(l.min), l.min)},
          {"max", or_null(std::isfinite(l.max), l.max)},
          {"reaction", l.reaction == Limit::Reaction::end ? "end" : "flag"}};
}

}  // namespace

Irreducible irreducible(const GroupedSystem& s) {
  Irreducible out;
  out.groups = static_cast<std::int64_t>(s.groups.size());
  out.eliminated = s.eliminated;
  out.left_out = s.left_out;
  for (const SolvedGroup& g : s.groups) ++out.sizes[static_cast<std::int32_t>(g.unknowns.size())];
  return out;
}

Json to_json(const Scene& scene, const GroupedSystem& s, const Irreducible& split) {
  const std::vector<ClassFigures> figures = class_figures(s);
  Json groups = Json::array();
  for (const SolvedGroup& g : s.groups) {
    const ClassFigures& f = figures[idx(g.group_class)];
    groups.push_back({{"name", g.name},
                      {"n", g.unknowns.size()},
                      {"of", g.of},
                      {"nnz", f.nnz},
                      {"fill", or_null(f.fill >= 0, f.fill)},
                      {"level", g.level},
                      {"class", g.group_class},
                      {"derivatives", g.derivatives}});
  }
  Json redundant = Json::array(), too_many = Json::array(), checked = Json::array(), kinds = Json::array();
  for (const RedundantSet& set : redundant_sets(scene, s.redundant)) {
    std::vector<std::string> names = set.named.joints;
    names.insert(names.end(), set.named.others.begin(), set.named.others.end());
    redundant.push_back(names);
    too_many.push_back(set.checked.size());
    checked.push_back(set.checked);
    kinds.push_back(kind_name(set.kind));
  }
  Json limits = Json::array();
  for (const Limit& l : scene.limits()) limits.push_back(to_json(l));
  Json blocks = Json::array();
  for (const GroupClass& c : s.classes) blocks.push_back(block_sizes(c));
  Json sizes = Json::array();
  for (const auto& [n, count] : split.sizes) sizes.push_back({{"n", n}, {"groups", count}});
  return {{"scene", scene.name()},
          {"dimension", scene.dimension()},
          {"formulation", name(s.formulation)},
          {"coordinates", s.coordinates},
          {"unknowns", s.unknowns},
          {"derived", s.derived},
          {"equations", s.equations},
          {"eliminated", s.eliminated},
          {"mobility", s.mobility},
          {"mobility_at_start", s.mobility_at_start},
          {"undetermined", s.undetermined},
          {"redundant", std::move(redundant)},
          {"too_many", std::move(too_many)},
          {"checked", std::move(checked)},
          {"redundancy", std::move(kinds)},
          {"limits", std::move(limits)},
          {"groups", std::move(groups)},
          {"levels", s.levels},
          {"classes", s.classes.size()},
          {"characteristic_length", s.system->unit(1)},
          {"left_out", to_json(s.left_out, s.formulation)},
          {"irreducible",
           {{"groups", split.groups},
            {"eliminated", split.eliminated},
            {"sizes", std::move(sizes)},
            {"left_out", to_json(split.left_out, Formulation::irreducible)},
            {"blocks_of_classes", std::move(blocks)}}},
          {"cannot_assemble", or_null(s.cannot_assemble)},
          {"notes", to_json(notes(scene, s))}};
}

namespace {

std::string unknowns_of(const Group& g) {
  const std::int64_t n = g.n;
  return n == g.of ? grouped(n) : grouped(n) + " of " + grouped(g.of);
}

std::string fill_of(const ClassFigures& f) { return f.fill < 0 ? "-" : grouped(f.fill); }

std::string up_to(const Group& g) {
  static constexpr std::array kNames = {"position", "velocity", "acceleration"};
  return kNames[idx(std::clamp(g.derivatives, 0, 2))];
}

void print_counts(Page& page, const GroupedSystem& s) {
  using enum Table::Align;
  Table table({left, right, left});
  const auto row = [&](const char* label, std::int64_t count, const std::string& note = "") {
    table.row({std::string(label) + std::string(16 - std::string_view(label).size(), ' '), grouped(count), note});
  };
  row("coordinates", s.coordinates, "of points, vectors and auxiliaries");
  if (s.derived > 0) row("derived", s.derived, "of body members: no unknowns, no equations");
  row("unknowns", s.unknowns);
  row("equations", s.equations);
  if (s.formulation == Formulation::irreducible) row("eliminated", s.eliminated, "by linear equations");
  row("mobility", s.mobility,
      "without the drivers" +
          (s.mobility_at_start != s.mobility ? "; " + grouped(s.mobility_at_start) + " at the start posture" : ""));
  row("groups", static_cast<std::int64_t>(s.groups.size()),
      s.formulation == Formulation::groups ? "declared ones, else irreducible" : std::string(name(s.formulation)));
  row("classes", static_cast<std::int64_t>(s.classes.size()), "of groups with the same equations");
  row("levels", s.levels, "of groups independent of each other");
  page.table(table);
  page.fact("length", number(s.system->unit(1)) + " m, the characteristic length");
}

Table group_table(const GroupedSystem& s, const std::vector<ClassFigures>& figures) {
  using enum Table::Align;
  Table table({right, left, right, right, right, right, left});
  table.row({"level", "group", "unknowns", "nonzeros", "fill", "class", "up to"});
  for (const SolvedGroup& g : s.groups) {
    const ClassFigures& f = figures[idx(g.group_class)];
    table.row({std::to_string(g.level), shortened(g.name, kLongestName), unknowns_of(g), grouped(f.nnz), fill_of(f),
               std::to_string(g.group_class), up_to(g)});
  }
  return table;
}

// One row for each class, with the name of its first group.
Table class_table(const std::vector<ClassFigures>& figures) {
  using enum Table::Align;
  Table table({right, right, left, right, right, right, left, left});
  table.row({"class", "groups", "first", "unknowns", "nonzeros", "fill", "levels", "up to"});
  for (std::size_t c = 0; c < std::min(figures.size(), kMostClasses); ++c) {
    const ClassFigures& f = figures[c];
    const std::string level = std::to_string(f.lowest_level);
    table.row({std::to_string(c), grouped(f.groups), shortened(f.first->name, kLongestName - 6), unknowns_of(*f.first),
               grouped(f.nnz), fill_of(f),
               f.lowest_level == f.highest_level ? level : level + "-" + std::to_string(f.highest_level),
               up_to(*f.first)});
  }
  return table;
}

void print_groups(Page& page, const GroupedSystem& s, const std::vector<ClassFigures>& figures) {
  if (s.groups.empty()) return;
  page.gap();
  if (s.groups.size() <= kMostRows) {
    page.table(group_table(s, figures));
  } else {
    page.table(class_table(figures));
    if (figures.size() > kMostClasses) {
      page.fact("", "and " + counted(figures.size() - kMostClasses, "class") + " more");
    }
  }
}

// "9 + 3 + 3", runs as "40 x 2".
std::string blocks_of(const GroupClass& c) {
  constexpr std::size_t kMostTerms = 8;
  const std::vector<std::int32_t> sizes = block_sizes(c);
  std::string text;
  std::size_t terms = 0;
  for (std::size_t k = 0; k < sizes.size() && terms <= kMostTerms; ++terms) {
    const auto run_end = std::find_if(sizes.begin() + static_cast<std::ptrdiff_t>(k), sizes.end(),
                                      [&](std::int32_t n) { return n != sizes[k]; });
    const std::size_t run = static_cast<std::size_t>(run_end - sizes.begin()) - k;
    const std::size_t written = run > 3 ? run : 1;
    text += text.empty() ? "" : " + ";
    text += terms == kMostTerms ? "..."
            : written > 1       ? std::to_string(run) + " x " + std::to_string(sizes[k])
                                : std::to_string(sizes[k]);
    k += written;
  }
  return text;
}

// "12 of 3, 6 of 9"
std::string sizes_of(const Irreducible& split) {
  std::vector<std::string> parts;
  for (const auto& [n, count] : split.sizes) parts.push_back(grouped(count) + " of " + grouped(n));
  return listed(parts);
}

void print_irreducible(Page& page, const GroupedSystem& s, const Irreducible& split) {
  std::string_view label = "irreducible";
  const auto say = [&](const std::string& text) {
    page.fact(label, text);
    label = "";
  };
  if (s.classes.size() <= kMostRows) {
    for (std::size_t c = 0; c < s.classes.size(); ++c) {
      if (s.classes[c].blocks < 2) continue;
      say("class " + std::to_string(c) + ": " + grouped(s.classes[c].n) + " = " + blocks_of(s.classes[c]));
    }
  }
  const std::string left = split.sizes.size() == 1
                               ? counted(split.groups, "group") + " of " + grouped(split.sizes.begin()->first)
                               : counted(split.groups, "group") + ": " + sizes_of(split);
  say(split.eliminated > 0
          ? "linear equations eliminate " + counted(split.eliminated, "unknown") + "; this leaves " + left
          : left + "; no linear equation eliminates an unknown");
}

// "joints A, B, C, D: 3 equations too many; checked, not solved"
std::string said(const RedundantSet& set) {
  const std::string what = set.named.text() + ": " + counted(set.checked.size(), "equation") + " too many";
  const std::string by = number(set.worst.violation) + (set.worst.is_length ? " m" : "");
  switch (set.kind) {
    case Redundancy::Kind::structural:
      return what + "; checked, not solved";
    case Redundancy::Kind::motion:
      return what + " for these driver laws; checked, not solved; for other driver values violated by " + by;
    case Redundancy::Kind::start:
      return what + " at the start posture only: at t = " + number(set.worst.time) + " s violated by " + by;
    case Redundancy::Kind::unknown:
      break;
  }
  return what + " at the start posture; checked, not solved";
}

// "knee.angle from 0 to 2.2 rad, ends the motion"
std::string said(const Limit& l, const System& s) {
  const auto has_name = [&](const MeasureForms& m) { return m.name == l.quantity; };
  const std::string unit = unit_of(*std::find_if(s.measures.begin(), s.measures.end(), has_name));
  const std::string of = (std::isfinite(l.min) ? " from " + number(l.min) : "") +
                         (std::isfinite(l.max) ? (std::isfinite(l.min) ? " to " : " up to ") + number(l.max) : "");
  return l.quantity + of + (unit == "1" ? "" : " " + unit) +
         (l.reaction == Limit::Reaction::end ? ", ends the motion" : ", flags");
}

void print_findings(Page& page, const Scene& scene, const GroupedSystem& s) {
  std::vector<std::string> limits;
  for (const Limit& l : scene.limits()) limits.push_back(said(l, *s.system));
  page.list("limits", limits);
  if (!s.undetermined.empty()) page.fact("undetermined", listed(s.undetermined) + ": no equation determines them");
  std::vector<std::string> redundant;
  for (const RedundantSet& set : redundant_sets(scene, s.redundant)) redundant.push_back(said(set));
  page.list("redundant", redundant);
  if (!s.cannot_assemble.empty()) page.fact("start posture", s.cannot_assemble);
  print_notes(page, scene, s);
}

}  // namespace

void print(Page& page, const Scene& scene, const GroupedSystem& s, const Irreducible& split) {
  page.title(scene.name() + ", " + std::to_string(scene.dimension()) + "D");
  page.gap();
  print_counts(page, s);
  print_groups(page, s, class_figures(s));
  page.gap();
  if (split.groups > 0) print_irreducible(page, s, split);
  print(page, s.left_out, s.formulation);
  if (s.formulation != Formulation::irreducible && s.left_out.unknowns != split.left_out.unknowns) {
    print(page, split.left_out, Formulation::irreducible, "");
  }
  print_findings(page, scene, s);
}

Json to_json(const MotionRange& range) {
  const auto end = [](const RangeEnd& e) -> Json {
    return {{"status", name(e.code)}, {"reached", e.reached}, {"beyond", e.beyond}, {"group", or_null(e.group)}};
  };
  Json passed = Json::array();
  for (const PassedLimit& p : range.passed)
    passed.push_back({{"limit", p.quantity}, {"at", p.at}, {"leaves", p.leaves}});
  return {{"driver", range.driver},
          {"unit", range.unit},
          {"start", range.start},
          {"low", end(range.low)},
          {"high", end(range.high)},
          {"change_points", range.change_points},
          {"limits_passed", std::move(passed)}};
}

void print(Page& page, const MotionRange& range) {
  const auto value = [](double x) { return general(x, 12); };
  const auto end = [&](const RangeEnd& e) {
    if (e.code == Code::ok) return value(e.reached) + ": no end up to here";
    return value(e.reached + (e.beyond - e.reached) / 2) + " ± " + error_figure(std::abs(e.beyond - e.reached) / 2) +
           place_of(e.code, e.group) + ": " + explained(e.code);
  };
  page.gap();
  page.fact("range", range.driver + ", now at " + value(range.start) + (range.unit.empty() ? "" : " " + range.unit));
  page.fact("  least", end(range.low));
  page.fact("  greatest", end(range.high));
  for (const double at : range.change_points) page.fact("", "branches cross at " + value(at));
  for (const PassedLimit& p : range.passed) {
    page.fact("", p.quantity + (p.leaves ? " leaves its limit at " : " returns into its limit at ") + value(p.at));
  }
}

}  // namespace assur::output
