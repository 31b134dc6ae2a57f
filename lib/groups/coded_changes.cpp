#include "groups/coded_changes.hpp"

#include <algorithm>

#include "groups/pack_memory.hpp"
#include "program/class_step.hpp"

namespace assur {

CodedChanges::CodedChanges(const Workspace& work) : work_(work) {
  if (!has_class_step(work.group_class)) return;
  const std::size_t w = idx(work.lanes);
  for (LaneArray* of : {&inputs_, &input_changes_}) of->assign(work.inputs.size(), 0.0);
  values_.assign(work_of_changes(work.group_class) * w, 0.0);
  failed_.assign(w, 0.0);
  at(Memory::inputs) = inputs_.data();
  at(Memory::input_rates) = input_changes_.data();
  at(Memory::work) = values_.data();
  at(Memory::figures) = failed_.data();
}

bool CodedChanges::follow(const Pack& pack, LinearSolver& solver, const double* posture,
                          std::span<double* const> changes) {
  static_assert(slot_of(GroupFigure::failed).index == 0);
  const CodeOfClass& code = pack.machine_code;
  if (!code.factors || !code.changes || !lanes::eliminates_by(solver, pack.eliminates.get())) return false;
  point_to(pack, memory_.data());
  at(Memory::unknowns) = const_cast<double*>(posture) + pack.unknowns;
  work_.gather(pack, posture, inputs_);
  code.factors->run(memory_);
  for (double* const change : changes) {
    work_.gather(pack, change, input_changes_);
    at(Memory::rates) = change + pack.unknowns;
    code.changes->run(memory_);
  }
  if (!std::all_of(failed_.begin(), failed_.end(), [](double failed) { return failed <= 0; })) return false;
  lanes::count_factorizations(solver, 1);
  return true;
}

}  // namespace assur
