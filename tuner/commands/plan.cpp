#include <optional>
#include <sstream>

#include "assur/machine.hpp"
#include "assur/saved_plan.hpp"
#include "assur/simulator.hpp"
#include "commands/commands.hpp"
#include "commands/plan_report.hpp"
#include "commands/print_result.hpp"
#include "output/replace_file.hpp"
#include "plan/preparation.hpp"

namespace assur::command {
namespace {

void save(const std::string& file, const Prepared& prepared) {
  output::Replacement out("--save", file);
  std::ostringstream text;
  save_plan(text, prepared);
  out.stream() << text.str();
  out.put();
}

// Only a simulator knows. It needs more memory than the plan of a large mechanism.
std::optional<std::string> machine_code_of(const Prepared& prepared, Mode mode) {
  constexpr std::size_t kMostGroups = 10'000;  // a choice: making a simulator of more takes longer than the plan
  if (mode == Mode::throughput || preparation(prepared).structure->groups.size() > kMostGroups) return std::nullopt;
  try {
    return Simulator(prepared).machine_code();
  } catch (const Error&) {  // of the start, which a run will tell
    return std::nullopt;
  }
}

}  // namespace

int plan(const Common& common, const PlanOptions& options) {
  Scene scene = open(common, options.scene, common.set, true);
  if (!options.outputs.empty()) scene = scene.with_outputs(options.outputs);
  refuse_overwriting(common, {{"--save", options.save}}, {options.scene});
  refuse_overwriting({{"--save", options.save}}, scene);
  const bool elsewhere = !options.machine.empty();
  const OtherMachine machine = elsewhere ? other_machine(common, options.machine)
                                         : OtherMachine{machine_model_of(common), this_machine().budget()};
  const MachineModel& known = machine.model;
  const ThreadBudget budget = common.threads > 0 ? ThreadBudget{common.threads} : machine.budget;
  const Prepared prepared = prepare(scene, {.strategy = options.strategy,
                                            .budget = budget,
                                            .mode = options.mode,
                                            .model = known.model,
                                            .without = options.without,
                                            .accuracy = options.accuracy});

  if (!options.save.empty()) save(options.save, prepared);

  output::PlanSummary summary{.prepared = prepared,
                              .mode = options.mode,
                              .budget = budget,
                              .model = *known.model,
                              .messages = known.messages,
                              .candidates = {},
                              .machine_code = elsewhere ? std::nullopt : machine_code_of(prepared, options.mode)};
  for (const Plan::Choice& choice : prepared.plan().choices) {
    std::vector<Candidate>& of_class = summary.candidates.emplace_back(
        candidates(choice.shape, {.model = known.model, .budget = budget, .without = options.without}));
    for (Candidate& c : of_class) c.strategy.run.formulation = prepared.plan().run.formulation;
  }
  print_result(common, summary);
  return kDone;
}

}  // namespace assur::command
