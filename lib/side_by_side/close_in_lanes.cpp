#include "side_by_side/close_in_lanes.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "backends/lanes_order.hpp"
#include "index.hpp"
#include "program/closing_step.hpp"
#include "structure/classes.hpp"
#include "structure/dense_block.hpp"

namespace assur {
namespace {

constexpr std::int32_t kMostUnknowns = 24;  // of a part: the program has all columns of an inverse

// The Jacobian of a part at a posture, in the order of a pattern.
std::vector<double> nonzeros(const System& s, const Group& group, const Pattern& pattern, std::span<const double> q) {
  std::vector<Index> column(s.coordinates.size(), -1);
  const std::vector<double> posture(q.begin(), q.end());
  const Eigen::MatrixXd j = DenseBlock(s, group.equations, group.unknowns, column).jacobian(posture);
  std::vector<double> out;
  for (Index c = 0; c < pattern.n; ++c) {
    for (Index k = pattern.column_start[idx(c)]; k < pattern.column_start[idx(c) + 1]; ++k) {
      out.push_back(j(pattern.row[idx(k)], c));
    }
  }
  return out;
}

}  // namespace

std::unique_ptr<CloseInLanes> CloseInLanes::make(const System& system, std::span<const WalkedPart> parts,
                                                 std::span<const double> posture, int lanes, StepCode* code) {
  std::unique_ptr<CloseInLanes> out(new CloseInLanes(idx(lanes)));
  const std::size_t w = out->w_;
  const std::vector<std::uint8_t> moves(system.coordinates.size(), 1);
  ClassTable table(system, moves);
  std::vector<Group> groups;
  for (const WalkedPart& part : parts) {
    if (part.equations.size() != part.unknowns.size() || std::ssize(part.unknowns) > kMostUnknowns) return nullptr;
    GroupContent content;
    content.unknowns = part.unknowns;
    content.equations = part.equations;
    content.unknown_block.assign(part.unknowns.size(), 0);
    content.equation_block.assign(part.equations.size(), 0);
    table.classify(content, groups.emplace_back());
  }
  std::size_t inputs = 0, unknowns = 0, work = 0;
  const std::vector<GroupClass> classes = table.take();
  std::vector<lanes::Elimination> eliminations;  // of the programs
  for (const Group& group : groups) {
    const GroupClass& c = classes[idx(group.group_class)];
    if (!c.quadratic || !c.gears.empty()) return nullptr;
    const Pattern pattern = jacobian_pattern(c);
    const lanes::Order order = lanes::markowitz_order(pattern, nonzeros(system, group, pattern, posture), 1, 1, {});
    if (!order.complete(pattern.n) || order.served != 1) return nullptr;
    lanes::Elimination elimination = lanes::write_program(pattern, order);
    Part& part = out->parts_.emplace_back();
    part.unknowns = group.unknowns;
    part.inputs = group.inputs;
    part.constants = group.constants;
    // Groups of one class often lie so differently that other pivots serve them.
    while (part.by < out->steps_.size() &&
           !(out->steps_[part.by].group_class == group.group_class && eliminations[part.by] == elimination)) {
      ++part.by;
    }
    if (part.by == out->steps_.size()) {
      Step& step = out->steps_.emplace_back();
      step.group_class = group.group_class;
      step.program = compile(c, pattern);
      const StepProgram program = closing_step(step.program, elimination);
      if (code != nullptr) step.executor = code->of(program, lanes);
      if (!step.executor) step.executor = make_interpreter(program, lanes);
      eliminations.push_back(std::move(elimination));
      inputs = std::max(inputs, idx(c.inputs));
      unknowns = std::max(unknowns, idx(c.n));
      work = std::max(work, work_of_closing_step(step.program));
    }
    part.coefficients.resize(out->steps_[part.by].program.coefficients.size() * w);
  }
  for (LaneArray* v : {&out->drawing_, &out->closed_, &out->strays_, &out->end_, &out->strays_to_end_}) {
    v->resize(system.coordinates.size() * w);
  }
  for (LaneArray* v : {&out->inputs_, &out->drawn_inputs_, &out->stray_inputs_}) v->resize(inputs * w);
  for (LaneArray* v : {&out->unknowns_, &out->solved_}) v->resize(unknowns * w);
  for (LaneArray* v : {&out->stray_, &out->is_open_}) v->resize(w);
  out->work_.resize(work * w);
  return out;
}

void CloseInLanes::set(std::size_t lane, const System& numbers, std::span<const double> drawing) {
  for (std::size_t c = 0; c < drawing.size(); ++c) {
    drawing_[c * w_ + lane] = end_[c * w_ + lane] = drawing[c];
    strays_to_end_[c * w_ + lane] = 0;
  }
  for (Part& part : parts_) {
    constants_.clear();
    for (const std::int32_t k : part.constants) constants_.push_back(numbers.constants[idx(k)]);
    bind_coefficients(steps_[part.by].program, constants_, part.coefficients.data() + lane, w_);
  }
}

void CloseInLanes::move(std::size_t lane, std::span<const double> end, std::span<const double> strays) {
  for (std::size_t c = 0; c < end.size(); ++c) {
    end_[c * w_ + lane] = end[c];
    strays_to_end_[c * w_ + lane] = strays[c];
  }
  moves_ = true;
}

void CloseInLanes::run() {
  std::fill(open_.begin(), open_.end(), 0.0);
  std::copy(drawing_.begin(), drawing_.end(), closed_.begin());
  std::fill(strays_.begin(), strays_.end(), 0.0);
  run_parts();
  if (!std::exchange(moves_, false)) return;
  std::swap(drawing_, closed_);
  std::copy(end_.begin(), end_.end(), closed_.begin());
  std::swap(strays_, strays_to_end_);
  run_parts();
}

void CloseInLanes::run_parts() {
  for (Part& part : parts_) run(part);
}

void CloseInLanes::run(Part& part) {
  const auto copy = [this](const LaneArray& from, std::size_t row, LaneArray& to, std::size_t to_row) {
    std::copy_n(from.data() + row * w_, w_, to.data() + to_row * w_);
  };
  for (std::size_t i = 0; i < part.inputs.size(); ++i) {
    const std::size_t c = idx(part.inputs[i]);
    copy(closed_, c, inputs_, i);
    copy(drawing_, c, drawn_inputs_, i);
    copy(strays_, c, stray_inputs_, i);
  }
  for (std::size_t j = 0; j < part.unknowns.size(); ++j) copy(drawing_, idx(part.unknowns[j]), unknowns_, j);
  std::array<double*, kMemories> memory;
  const auto give = [&](Memory m, LaneArray& at) { memory[static_cast<std::size_t>(m)] = at.data(); };
  give(Memory::coefficients, part.coefficients);
  give(Memory::work, work_);
  give(ClosingSlots::drawn, unknowns_);
  give(ClosingSlots::inputs, inputs_);
  give(ClosingSlots::drawn_inputs, drawn_inputs_);
  give(ClosingSlots::strays, stray_inputs_);
  give(ClosingSlots::closed, solved_);
  give(ClosingSlots::stray, stray_);
  give(ClosingSlots::open, is_open_);
  steps_[part.by].executor->run(memory);
  for (std::size_t j = 0; j < part.unknowns.size(); ++j) {
    copy(solved_, j, closed_, idx(part.unknowns[j]));
    copy(stray_, 0, strays_, idx(part.unknowns[j]));
  }
  for (std::size_t l = 0; l < w_; ++l) open_[l] = open_[l] + is_open_[l];
}

}  // namespace assur
