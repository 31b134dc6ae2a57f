#include <iostream>
#include <optional>

#include "assur/motion_range.hpp"
#include "assur/structure.hpp"
#include "commands/commands.hpp"
#include "commands/structure_report.hpp"

namespace assur::command {
namespace {

StructureOptions asking_for(Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  return options;
}

}  // namespace

int inspect(const Common& common, const InspectOptions& options) {
  Scene scene = open(common, options.scene, common.set, false);
  if (!options.outputs.empty()) scene = scene.with_outputs(options.outputs);

  const Structure structure = analyze(scene, asking_for(options.formulation));
  const output::Irreducible split = output::irreducible(options.formulation == Formulation::irreducible
                                                            ? structure
                                                            : analyze(scene, asking_for(Formulation::irreducible)));
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
