#include "commands/left_out.hpp"

#include <map>

#include "output/format.hpp"

namespace assur::output {
namespace {

// The derivatives that are not computed for a group of this level.
std::string_view fate(const LeftOut::Level& level) {
  if (level.for_predictor) {
    return level.derivatives == 2 ? "acceleration only for the predictor" : "velocity only for the predictor";
  }
  return level.derivatives == 1 ? "no acceleration" : "no velocity, no acceleration";
}

}  // namespace

Json to_json(const LeftOut& left_out, Formulation formulation) {
  Json levels = Json::array();
  for (const LeftOut::Level& l : left_out.levels) {
    levels.push_back({{"group", l.group}, {"derivatives", l.derivatives}, {"for_predictor", l.for_predictor}});
  }
  return {{"formulation", name(formulation)}, {"groups", left_out.groups},   {"unknowns", left_out.unknowns},
          {"equations", left_out.equations},  {"levels", std::move(levels)}, {"static_groups", left_out.static_groups}};
}

void print(Page& page, const LeftOut& left_out, Formulation formulation, std::string_view label) {
  bool said = false;
  const auto say = [&](const std::string& text) {
    page.fact(label, text);
    label = "";
    said = true;
  };
  if (left_out.unknowns > 0 || left_out.equations > 0) {
    const bool split = formulation == Formulation::irreducible;
    say((split ? "of the irreducible groups " : "") + counted(left_out.unknowns, "unknown") + ", " +
        counted(left_out.equations, "equation"));
  }
  if (const auto& groups = left_out.groups; !groups.empty()) {
    say(counted(groups.size(), "group") + ": " + listed(groups));
  }
  if (left_out.static_groups > 0) say(counted(left_out.static_groups, "group") + " without motion, solved once");
  std::map<std::string_view, std::vector<std::string>> by_fate;
  for (const LeftOut::Level& l : left_out.levels) by_fate[fate(l)].push_back(l.group);
  for (const auto& [what, groups] : by_fate) {
    say(std::string(what) + ": " + (groups.size() > 20 ? counted(groups.size(), "group") : listed(groups)));
  }
  if (!said) say("nothing: the outputs need everything");
}

}  // namespace assur::output
