#include <algorithm>
#include <iostream>
#include <vector>

#include "assur/modes.hpp"
#include "assur/structure.hpp"
#include "commands/commands.hpp"
#include "commands/modes_report.hpp"
#include "commands/structure_report.hpp"

namespace assur::command {
namespace {

StructureOptions asking_for(Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  return options;
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
  Scene scene = open(common, options.scene, common.set, false);
  if (options.modes) return inspect_modes(common, scene);
  if (!options.outputs.empty()) scene = scene.with_outputs(options.outputs);

  const Structure structure = analyze(scene, asking_for(options.formulation));
  const output::Irreducible split = output::irreducible(options.formulation == Formulation::irreducible
                                                            ? structure
                                                            : analyze(scene, asking_for(Formulation::irreducible)));
  if (common.json) {
    output::print(std::cout, to_json(scene, structure, split));
  } else {
    output::Page page(std::cout);
    print(page, scene, structure, split);
  }
  return kDone;
}

}  // namespace assur::command
