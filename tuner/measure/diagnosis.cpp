#include "measure/diagnosis.hpp"

#include <utility>

namespace assur::measure {

Diagnosis::Diagnosis(const Prepared& prepared, bool with_reference) {
  if (with_reference) truth_ = std::make_unique<TruePosture>(prepared);
}

std::vector<GroupErrors> Diagnosis::look(Simulator& simulator) {
  const std::vector<double> posture = posture_of(simulator);
  const std::int64_t counted = simulator.report().counters.newton_iterations,
                     before = std::exchange(iterations_, counted);
  std::vector<GroupErrors> all;
  for (const GroupFigures& figures : simulator.examine()) {
    GroupErrors errors{figures, {}, {}};
    const std::vector<Group>& groups = simulator.prepared().structure->groups;
    if (groups.size() == 1) errors.iterations = counted - before;
    if (truth_) {
      const Group& group = groups[static_cast<std::size_t>(figures.group)];
      errors.error = truth_->error(simulator.time(), posture, group.unknowns);
    }
    all.push_back(std::move(errors));
  }
  return all;
}

}  // namespace assur::measure
