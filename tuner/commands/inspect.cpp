#include <algorithm>
#include <iostream>
#include <optional>
#include <vector>

#include "assur/modes.hpp"
#include "assur/motion_range.hpp"
#include "commands/commands.hpp"
#include "commands/modes_report.hpp"
#include "commands/structure_report.hpp"
#include "output/replace_file.hpp"
#include "structure/grouped_system.hpp"

namespace assur::command {
namespace {

StructureOptions asking_for(Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  return options;
}

void write(const Scene& scene, const std::string& file) {
  output::Replacement out("--write", file);
  out.stream() << write_scene(scene);
  out.put();
}

// Incomplete answers are numerical failures.
int inspect_modes(const Common& common, const Scene& scene) {
  const std::vector<AssemblyModes> groups = assembly_modes(scene);
  if (common.json) {
    output::print(std::cout, output::to_json(scene, groups));
  } else {
    output::Page page(std::cout);
    output::print(page, scene, groups);
  }
  const bool is_lost = std::any_of(groups.begin(), groups.end(), [](const AssemblyModes& m) { return m.lost > 0; });
  return is_lost ? kNumerical : kDone;
}

}  // namespace

int inspect(const Common& common, const InspectOptions& options) {
  refuse_overwriting(common, {{"--write", options.write}}, {options.scene});
  Scene scene = open(common, options.scene, common.set, false);
  refuse_overwriting({{"--write", options.write}}, scene);
  if (!options.outputs.empty()) scene = scene.with_outputs(options.outputs);
  if (!options.write.empty()) write(scene, options.write);
  if (options.modes) return inspect_modes(common, scene);

  const GroupedSystem structure = group_equations(scene, asking_for(options.formulation));
  const output::Irreducible split = output::irreducible(
      options.formulation == Formulation::irreducible ? structure
                                                      : group_equations(scene, asking_for(Formulation::irreducible)));
  const auto range = options.range ? std::optional(motion_range(scene, options.driver)) : std::nullopt;
  if (common.json) {
    output::Json json = to_json(scene, structure, split);
    if (range) json["range"] = output::to_json(*range);
    output::print(std::cout, json);
  } else {
    output::Page page(std::cout);
    print(page, scene, structure, split);
    if (range) output::print(page, *range);
  }
  return kDone;
}

}  // namespace assur::command
