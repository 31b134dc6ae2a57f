#include <iostream>

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
  if (common.json) {
    output::print(std::cout, to_json(scene, structure, split));
  } else {
    output::Page page(std::cout);
    print(page, scene, structure, split);
  }
  return kDone;
}

}  // namespace assur::command
