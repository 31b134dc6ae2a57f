#include "commands/modes_report.hpp"

#include <algorithm>
#include <string_view>

#include "output/format.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kMostGroups = 40;   // further groups are only counted
constexpr std::size_t kLongestName = 20;  // columns

// "C = (1.6, 1.2), slide.lambda = 0.3"
std::string posture(const std::vector<std::string>& unknowns, const std::vector<double>& values) {
  // The point or vector of a component "C.x"; "": the unknown is a scalar.
  const auto base = [&](std::size_t j) -> std::string_view {
    const std::string_view name = unknowns[j];
    const bool is_component =
        name.size() > 2 && name[name.size() - 2] == '.' && name.back() >= 'x' && name.back() <= 'z';
    return is_component ? name.substr(0, name.size() - 2) : std::string_view();
  };
  std::string text;
  for (std::size_t j = 0; j < unknowns.size();) {
    std::size_t end = j + 1;
    while (end < unknowns.size() && !base(j).empty() && base(end) == base(j)) ++end;
    text += text.empty() ? "" : ", ";
    if (end - j == 1) {
      text += unknowns[j] + " = " + number(values[j]);
    } else {
      text += std::string(base(j)) + " = (" + number(values[j]);
      for (std::size_t k = j + 1; k < end; ++k) text += ", " + number(values[k]);
      text += ")";
    }
    j = end;
  }
  return text;
}

Table mode_table(const std::vector<AssemblyModes>& groups, std::size_t shown) {
  using enum Table::Align;
  Table table({left, right, left, right, right, left});
  table.row({"group", "mode", "", "residual", "condition", "unknowns"});
  for (std::size_t g = 0; g < shown; ++g) {
    const AssemblyModes& m = groups[g];
    const std::string name = shortened(m.group, kLongestName);
    if (m.modes.empty()) table.row({name, "-", "", "", "", m.why_none.empty() ? "no mode" : "not computed"});
    for (std::size_t k = 0; k < m.modes.size(); ++k) {
      const AssemblyMode& mode = m.modes[k];
      table.row({k == 0 ? name : "", std::to_string(k), k == 0 && m.has_start ? "start" : "",
                 error_figure(mode.residual), error_figure(mode.condition), posture(m.unknowns, mode.values)});
    }
  }
  return table;
}

// Findings about one group; the name of the group comes first.
std::vector<std::string> findings(const AssemblyModes& m) {
  std::vector<std::string> out;
  const auto say = [&](const std::string& text) { out.push_back(m.group + ": " + text); };
  if (!m.why_none.empty()) say("not computed: it " + m.why_none);
  if (m.lost > 0) {
    say("may be incomplete: " + grouped(m.lost) + " of " + counted(m.paths, "path") + " ended at unknown places");
  }
  if (m.multiple > 0) {
    std::vector<std::string> at;
    at.reserve(m.folds.size());
    for (const std::vector<double>& fold : m.folds) at.push_back(posture(m.unknowns, fold));
    say(counted(m.multiple, "path") + (m.multiple == 1 ? " ends" : " end") +
        " at multiple solutions (folds) or at solutions that are not isolated, none of which is a mode" +
        (at.empty() ? "; none of these solutions is certainly real" : ": " + listed(at, 4)));
  }
  if (m.excluded > 0) {
    say(counted(m.excluded, "further solution") + (m.excluded == 1 ? " breaks" : " break") +
        " a redundant equation, the value of a driver or the right-handedness of axes");
  }
  return out;
}

}  // namespace

Json to_json(const Scene& scene, const std::vector<AssemblyModes>& groups) {
  Json all = Json::array();
  for (const AssemblyModes& m : groups) {
    Json modes = Json::array();
    for (const AssemblyMode& mode : m.modes) {
      modes.push_back({{"values", mode.values}, {"residual", mode.residual}, {"condition", mode.condition}});
    }
    all.push_back({{"group", m.group},
                   {"unknowns", m.unknowns},
                   {"start", or_null(m.has_start, 0)},
                   {"modes", std::move(modes)},
                   {"complete", m.complete()},
                   {"why_none", or_null(m.why_none)},
                   {"paths", m.paths},
                   {"not_real", m.not_real},
                   {"diverged", m.diverged},
                   {"multiple", m.multiple},
                   {"lost", m.lost},
                   {"excluded", m.excluded},
                   {"folds", m.folds}});
  }
  return {{"scene", scene.name()}, {"dimension", scene.dimension()}, {"groups", std::move(all)}};
}

void print(Page& page, const Scene& scene, const std::vector<AssemblyModes>& groups) {
  page.title(scene.name() + ", " + std::to_string(scene.dimension()) + "D: assembly modes at the start");
  page.gap();
  if (groups.empty()) {
    page.fact("", "no group: nothing has to be solved");
    return;
  }
  const std::size_t shown = std::min(groups.size(), kMostGroups);
  page.table(mode_table(groups, shown));
  if (shown < groups.size()) {
    page.fact("", "and " + counted(groups.size() - shown, "group") + " more; --json has all");
  }
  std::vector<std::string> all;
  for (const AssemblyModes& m : groups) {
    for (std::string& finding : findings(m)) all.push_back(std::move(finding));
  }
  if (!all.empty()) page.gap();
  page.list("findings", all);
}

}  // namespace assur::output
