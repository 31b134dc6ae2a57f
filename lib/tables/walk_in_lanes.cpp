#include "tables/walk_in_lanes.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "backends/lanes_order.hpp"
#include "backends/with_lanes.hpp"
#include "equations/dense_block.hpp"
#include "index.hpp"
#include "program/needs.hpp"
#include "program/step_rules.hpp"
#include "program/walk_step.hpp"
#include "structure/classes.hpp"

namespace assur {
namespace {

constexpr std::int32_t kMostUnknowns = 24;  // of a part: the program has all columns of an inverse
constexpr double kShortest = 0x1p-8;        // step; one mechanism alone takes steps of any length
constexpr int kMostSteps = 100;             // a choice: members that take more are led to their start alone

// The Jacobian of a part at a posture, in the order of a pattern.
std::vector<double> nonzeros(const System& s, const SolvedGroup& group, const Pattern& pattern,
                             std::span<const double> q) {
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

std::unique_ptr<WalkInLanes> WalkInLanes::make(const System& system, std::span<const WalkedPart> parts,
                                               std::span<const double> posture, int lanes, StepCode* code) {
  std::unique_ptr<WalkInLanes> out(new WalkInLanes(idx(lanes)));
  const std::size_t w = out->w_;
  const std::vector<std::uint8_t> moves(system.coordinates.size(), 1);
  ClassTable table(system, moves);
  std::vector<SolvedGroup> groups;
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
  for (const SolvedGroup& group : groups) {
    const GroupClass& c = classes[idx(group.group_class)];
    if (!can_take(Path::walk_in_lanes, needs_of(c))) return nullptr;
    const Pattern& pattern = c.pattern;
    lanes::Elimination elimination;
    if (pattern.n > kWithoutPivots) {
      const lanes::Order order = lanes::markowitz_order(pattern, nonzeros(system, group, pattern, posture), 1, 1, {});
      if (!order.complete(pattern.n) || order.served != 1) return nullptr;
      elimination = lanes::write_program(pattern, order);
    }
    UnitInLanes& part = out->parts_.emplace_back();
    part.unknowns = group.unknowns;
    part.inputs = group.inputs;
    part.constants = group.constants;
    // Groups of one class often lie so differently that other pivots serve them.
    while (part.by < out->steps_.size() &&
           !(out->steps_[part.by].number == group.group_class && eliminations[part.by] == elimination)) {
      ++part.by;
    }
    if (part.by == out->steps_.size()) {
      Step& step = out->steps_.emplace_back();
      step.number = group.group_class;
      step.group_class = c;
      const StepProgram program = walk_step(c, elimination);
      if (code != nullptr) step.executor = code->of(program, lanes);
      if (!step.executor) step.executor = make_interpreter(program, lanes);
      eliminations.push_back(std::move(elimination));
      inputs = std::max(inputs, idx(c.inputs));
      unknowns = std::max(unknowns, idx(c.n));
      work = std::max(work, work_of_walk_step(c));
    }
    part.numbers.resize(part.constants.size() * w);
    part.coefficients.resize(out->steps_[part.by].group_class.coefficients.size() * w);
    for (LaneArray* v : {&part.open, &part.aims}) v->resize(idx(c.n) * w);
  }
  for (std::size_t c = 0; c < system.coordinates.size(); ++c) {
    if (system.coordinates[c].role != Role::unknown) out->known_.push_back(static_cast<Index>(c));
  }
  for (const Positive& p : system.positive) out->positive_.push_back(p.coordinate);
  for (LaneArray* v : {&out->from_, &out->to_, &out->strays_}) v->resize(system.coordinates.size() * w);
  for (LaneArray* v : {&out->inputs_, &out->from_inputs_, &out->stray_inputs_}) v->resize(inputs * w);
  for (LaneArray* v : {&out->unknowns_, &out->solved_, &out->open_}) v->resize(unknowns * w);
  for (LaneArray* v : {&out->stray_, &out->use_}) v->resize(w);
  out->work_.resize(work * w);
  for (std::vector<double>* v : {&out->one_, &out->one_strays_}) v->resize(system.coordinates.size());
  return out;
}

void WalkInLanes::set(std::size_t lane, const System& numbers, std::span<const double> drawing, bool drivers_move) {
  lanes_[lane] = {Stage::closing, drivers_move};
  for (std::size_t c = 0; c < drawing.size(); ++c) from_[c * w_ + lane] = drawing[c];
  for (UnitInLanes& part : parts_) {
    for (std::size_t k = 0; k < part.constants.size(); ++k) {
      part.numbers[k * w_ + lane] = numbers.constants[idx(part.constants[k])];
    }
  }
}

void WalkInLanes::run(Drivers& drivers) {
  const auto each = [&](const auto& work) {
    bool any = false;
    for (std::size_t lane = 0; lane < w_; ++lane) {
      if (!lanes_[lane].is_on_its_way()) continue;
      any = true;
      work(lane);
    }
    return any;
  };
  for (Lane& lane : lanes_) {
    if (!lane.is_on_its_way()) lane.stage = Stage::unset;
  }
  for (UnitInLanes& part : parts_) {
    bind_coefficients(steps_[part.by].group_class, part.numbers.data(), part.coefficients.data(), w_);
  }
  for (bool is_first = true; each([&](std::size_t lane) { begin_step(lane, drivers); }); is_first = false) {
    set_aims();
    std::fill(used_.begin(), used_.end(), 0.0);
    for (UnitInLanes& part : parts_) run(part, is_first);
    std::fill(goes_on_.begin(), goes_on_.end(), 0.0);
    each([&](std::size_t lane) { end_step(lane, drivers); });
    for (std::size_t row = 0; row < from_.size(); row += w_) {
      for (std::size_t l = 0; l < w_; ++l) from_[row + l] = goes_on_[l] > 0 ? to_[row + l] : from_[row + l];
    }
  }
}

// Sets the known coordinates at the end of the step.
void WalkInLanes::begin_step(std::size_t lane, Drivers& drivers) {
  const Lane& l = lanes_[lane];
  const bool moves = l.stage == Stage::moving;
  left_[lane] = moves ? 0 : 1 - l.target();
  for (const std::int32_t c : known_) one_[idx(c)] = from_[idx(c) * w_ + lane];
  if (moves) drivers.move(lane, l.share, l.target(), one_, one_strays_);
  for (const std::int32_t c : known_) {
    to_[idx(c) * w_ + lane] = one_[idx(c)];
    strays_[idx(c) * w_ + lane] = moves ? one_strays_[idx(c)] : 0;
  }
}

// The residuals at the end of the step. In the first one, nothing is known of those that are open.
void WalkInLanes::set_aims() {
  for (UnitInLanes& part : parts_) {
    for (std::size_t row = 0; row < part.aims.size(); row += w_) {
      for (std::size_t l = 0; l < w_; ++l) part.aims[row + l] = left_[l] > 0 ? left_[l] * part.open[row + l] : 0;
    }
  }
}

void WalkInLanes::end_step(std::size_t lane, Drivers& drivers) {
  Lane& l = lanes_[lane];
  ++l.steps;
  const double by = l.target() - l.share,
               used = used_[lane] <= WalkRules::kSurest && !holds(lane, drivers) ? 1 : used_[lane];
  if (!(used <= WalkRules::kSurest)) {
    l.step = by * WalkRules::after_failure(used);
    if (l.step < kShortest || l.steps >= kMostSteps) l.stage = Stage::given_up;
    return;
  }
  goes_on_[lane] = 1;
  l.share = l.target();
  l.step = by * WalkRules::after_success(used);
  if (l.share < 1) return;
  const bool goes_on = l.stage == Stage::closing && l.drivers_move;
  l.stage = goes_on ? Stage::moving : Stage::arrived;
  l.share = 0;
  l.step = 1;
}

// False if a lever is not positive, or if a driver has not its value any more, because its direction has vanished.
bool WalkInLanes::holds(std::size_t lane, Drivers& drivers) {
  for (const std::int32_t c : positive_) {
    if (!(to_[idx(c) * w_ + lane] > 0)) return false;
  }
  if (lanes_[lane].stage != Stage::moving) return true;
  for (std::size_t c = 0; c < one_.size(); ++c) one_[c] = to_[c * w_ + lane];
  return drivers.hold(lane, one_);
}

void WalkInLanes::run(UnitInLanes& part, bool is_first) {
  const auto gather = [this](const LaneArray& rows, const std::vector<std::int32_t>& coordinates, LaneArray& into) {
    with_lanes(w_, [&](auto w) {
      double* to = into.data();
      for (const std::int32_t c : coordinates) {
        std::memcpy(to, rows.data() + idx(c) * w, w * sizeof(double));
        to += w;
      }
    });
  };
  gather(to_, part.inputs, inputs_);
  gather(from_, part.inputs, from_inputs_);
  gather(strays_, part.inputs, stray_inputs_);
  gather(from_, part.unknowns, unknowns_);
  std::array<double*, kMemories> memory;
  const auto give = [&](Memory m, LaneArray& at) { memory[static_cast<std::size_t>(m)] = at.data(); };
  give(Memory::coefficients, part.coefficients);
  give(Memory::work, work_);
  give(WalkSlots::from, unknowns_);
  give(WalkSlots::inputs, inputs_);
  give(WalkSlots::from_inputs, from_inputs_);
  give(WalkSlots::strays, stray_inputs_);
  give(WalkSlots::aims, part.aims);
  give(WalkSlots::to, solved_);
  give(WalkSlots::open, open_);
  give(WalkSlots::stray, stray_);
  give(WalkSlots::used, use_);
  steps_[part.by].executor->run(memory);
  with_lanes(w_, [&](auto w) {
    const double* from = solved_.data();
    for (const std::int32_t u : part.unknowns) {
      std::memcpy(to_.data() + idx(u) * w, from, w * sizeof(double));
      std::memcpy(strays_.data() + idx(u) * w, stray_.data(), w * sizeof(double));
      from += w;
    }
  });
  for (std::size_t l = 0; l < w_; ++l) used_[l] = use_[l] <= used_[l] ? used_[l] : use_[l];
  if (is_first) std::copy_n(open_.begin(), part.open.size(), part.open.begin());
}

}  // namespace assur
