#include "commands/start_modes.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "output/format.hpp"
#include "scene/names.hpp"

namespace assur::command {
namespace {

// True if the group has this name, or solves a point, vector or scalar of this name.
bool is_meant(const AssemblyModes& m, std::string_view name) {
  return m.group == name || std::any_of(m.unknowns.begin(), m.unknowns.end(), [&](const std::string& unknown) {
           return unknown == name || std::string_view(unknown).substr(0, unknown.rfind('.')) == name;
         });
}

// The group of --start-mode N: the only one that has a choice.
std::string only_group(const std::vector<AssemblyModes>& all) {
  std::vector<std::string> names;
  for (const AssemblyModes& m : all) {
    if (m.modes.size() > (m.has_start ? 1 : 0)) names.push_back(m.group);
  }
  if (names.size() == 1) return names.front();
  refuse("--start-mode", names.empty()
                             ? "no group has a mode to choose; see assur inspect SCENE --modes"
                             : "several groups have modes to choose; name one of them: " + output::listed(names, 12) +
                                   ", as in --start-mode " + names.front() + "=1");
}

// A choice that one of the two options makes.
struct Wish {
  std::string option, name;
  const std::size_t* mode;  // --start-mode; null: --guess
  const Triple* at;
};

}  // namespace

std::vector<ModeChoice> chosen_modes(const Scene& scene, const ModeOptions& options) {
  std::vector<Wish> wishes;
  for (const auto& [name, mode] : options.modes) wishes.push_back({"--start-mode", name, &mode, nullptr});
  for (const auto& [name, at] : options.guesses) {
    if (std::ssize(at) != scene.dimension()) {
      refuse("--guess " + excerpt(name), "the scene has dimension " + std::to_string(scene.dimension()) + "; give " +
                                             (scene.dimension() == 2 ? "x,y" : "x,y,z"));
    }
  }
  std::vector<Triple> places;
  places.reserve(options.guesses.size());
  for (const auto& [name, at] : options.guesses) {
    Triple& place = places.emplace_back();
    std::copy(at.begin(), at.end(), place.begin());
    wishes.push_back({"--guess", name, nullptr, &place});
  }
  std::vector<ModeChoice> chosen;
  // A choice changes the postures, and so the modes, of the groups that depend on it: groups are chosen in their order.
  while (!wishes.empty()) {
    const std::vector<AssemblyModes> all = assembly_modes(scene, chosen);
    for (Wish& wish : wishes) {
      if (wish.name.empty()) wish.name = only_group(all);
      if (std::any_of(all.begin(), all.end(), [&](const AssemblyModes& m) { return is_meant(m, wish.name); })) continue;
      std::vector<std::string_view> known;
      for (const AssemblyModes& m : all) known.emplace_back(m.group);
      refuse(wish.option, "no group has the name " + in_quotes(wish.name) + " or solves a point of that name" +
                              known_instead(wish.name, known));
    }
    for (const AssemblyModes& m : all) {
      const auto meant = [&](const Wish& wish) { return is_meant(m, wish.name); };
      const auto wish = std::find_if(wishes.begin(), wishes.end(), meant);
      if (wish == wishes.end()) continue;
      const std::string option = wish->option + " " + excerpt(wish->name);
      if (std::count_if(wishes.begin(), wishes.end(), meant) > 1) {
        refuse(option, "the mode of group " + m.group + " is chosen twice");
      }
      if (!m.why_none.empty()) refuse(option, "group " + m.group + " " + m.why_none);
      if (m.modes.empty()) refuse(option, "group " + m.group + " has no posture");
      if (wish->mode != nullptr && *wish->mode >= m.modes.size()) {
        refuse(option, "group " + m.group + " has no mode " + std::to_string(*wish->mode) + "; its modes are 0 to " +
                           std::to_string(m.modes.size() - 1) + " (assur inspect SCENE --modes)");
      }
      chosen.push_back({m.group, wish->mode != nullptr ? *wish->mode : m.nearest(wish->name, *wish->at)});
      wishes.erase(wish);
      break;
    }
  }
  return chosen;
}

Prepared prepare(const Scene& scene, const PrepareOptions& how, const std::vector<ModeChoice>& chosen) {
  return chosen.empty() ? assur::prepare(scene, how) : prepare_in_modes(scene, chosen, how);
}

}  // namespace assur::command
