#include "runs/side_by_side.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "numbers.hpp"
#include "outputs/columns.hpp"
#include "simulation/simulator_access.hpp"

namespace assur {

void Totals::merge(const Totals& o) {
  counters += o.counters;
  effort += o.effort;
  error.merge(o.error);
}

Turns::Turns(const OutputProgram& outputs, const double* before, const double* here) : outputs_(outputs) {
  for (const std::size_t c : outputs.angles()) {
    const double turns = kTurn * std::round((before[c] - here[c]) / kTurn);
    if (turns != 0) turns_.emplace_back(c, turns);
  }
}

void Turns::add_to(double* row) const {
  if (turns_.empty()) return;
  for (const auto& [column, turns] : turns_) row[column] += turns;
  outputs_.add_up(row);
}

namespace {

// Stops a run at the posture of its last row.
void stop(LaneRun& run, const std::vector<double>& posture) {
  if (run.done <= run.posture_wanted) run.posture = posture;
  run.status = {Code::interrupted, {}, run.reached};
}

}  // namespace

SideBySide::SideBySide(const Preparation& prepared, const StepSettings& settings, const BoundMembers* members)
    : prepared_(prepared), settings_(settings), tile_(prepared, settings) {
  if (members == nullptr) return;
  binder_ = members->binder(static_cast<std::size_t>(tile_.lanes()));
  const GroupedSystem& first = *prepared.structure;
  tile_.keep_pivots({first.system, first.start, prepared.time.start, prepared.reselect});
}

Totals SideBySide::totals() const {
  Totals sum{tile_.counters(), tile_.error(), tile_.effort()};
  sum.merge(of_those_alone_);
  return sum;
}

void SideBySide::clear_totals() {
  tile_.clear_figures();
  of_those_alone_ = {};
}

void SideBySide::write_row(int lane, LaneRun& run, std::size_t row) {
  tile_.fill_row(lane, run.row(row, columns().size()));
  run.done = row + 1;
  run.reached = run.times[row];
  tile_.take_events(lane, run.events);
  if (row == run.posture_wanted) run.posture = tile_.posture(lane);
}

// Once for each row: a step that fails is tried again from the row before it.
void SideBySide::give_row(LaneRun& run, std::size_t row) const {
  if (run.consumer == nullptr || row < run.taken) return;
  run.consumer->add_row(run.times[row], run.row(row, columns().size()));
  run.taken = row + 1;
}

// Solves from row `from`, at which the variants are, to the last row that all lanes reach in lockstep. Returns that
// row, and the status of the next step.
std::pair<std::size_t, Status> SideBySide::follow(std::span<LaneRun* const> lanes, std::size_t from,
                                                  const std::function<bool()>& proceed) {
  const std::size_t rows = lanes[0]->times.size();
  std::vector<double> times(lanes.size());
  for (std::size_t row = from + 1; row < rows; ++row) {
    for (std::size_t i = 0; i < lanes.size(); ++i) times[i] = lanes[i]->times[row];
    const bool moves = times[0] != lanes[0]->times[row - 1];
    if (const Status s = moves ? tile_.step(times) : Status{}; !s.ok()) return {row - 1, s};
    for (std::size_t i = 0; i < lanes.size(); ++i) write_row(static_cast<int>(i), *lanes[i], row);
    if (moves) check_accuracy(lanes, row);
    for (LaneRun* lane : lanes) give_row(*lane, row);
    if (!proceed()) {
      stopped_ = true;
      return {row, {}};
    }
  }
  return {rows - 1, {}};
}

// Measures at `row`, which all lanes have reached.
void SideBySide::measure_errors(std::span<LaneRun* const> lanes, std::size_t row) {
  std::array<double, kMostLanes> times{};
  std::array<const double*, kMostLanes> rows{};
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    times[i] = lanes[i]->times[row];
    rows[i] = lanes[i]->row(row, columns().size());
  }
  tile_.measure_errors({times.data(), lanes.size()}, {rows.data(), lanes.size()});
}

void SideBySide::check_accuracy(std::span<LaneRun* const> lanes, std::size_t row) {
  if (tile_.errors_are_due()) {
    measure_errors(lanes, row);
    if (tile_.in_doubt() && tile_.polish()) {
      for (std::size_t i = 0; i < lanes.size(); ++i) write_row(static_cast<int>(i), *lanes[i], row);
      measure_errors(lanes, row);
    }
    tile_.keep_errors();
  }
  if (!tile_.in_doubt()) return;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    LaneRun& run = *lanes[i];
    const Status s = tile_.accuracy(static_cast<int>(i));
    if (s.ok()) continue;
    const std::string group = prepared_.structure->name_of(s.where);
    const std::size_t count = columns().size();
    record_doubt(run.events, {run.times[std::max<std::size_t>(row, 1) - 1], run.times[row], group, s.code, s.figure,
                              without_derivatives(columns(), missing_from({run.row(row, count), count}))});
    if (run.status.ok()) run.status = s;
  }
}

Status SideBySide::start(const Lanes& lanes, std::span<const Variant* const> variants) {
  std::vector<const Variant*> these;
  for (const std::size_t i : lanes) these.push_back(variants[i]);
  return tile_.start(these);
}

// Those of the lanes, which are in the tile, whose posture is near its guess.
SideBySide::Lanes SideBySide::near_guess(const Lanes& lanes, std::span<const Variant* const> variants) const {
  Lanes able;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    if (binder_->is_start(*variants[lanes[i]], tile_.posture(static_cast<int>(i)))) able.push_back(lanes[i]);
  }
  return able;
}

// Those of the lanes that start near their guess. A lane at fault is left out, and the others are tried again: this
// takes less time than to assemble all of them one by one.
SideBySide::Lanes SideBySide::started_near(Lanes lanes, std::span<const Variant* const> variants) {
  while (!lanes.empty()) {
    const Status s = start(lanes, variants);
    if (s.ok()) return near_guess(lanes, variants);
    if (!s.where.is(Place::Kind::lane)) break;
    lanes.erase(lanes.begin() + s.where.index);
  }
  return {};
}

// Those of the lanes that can start. in_tile: receives the lanes that are in the tile, if they started.
SideBySide::Lanes SideBySide::startable(const Lanes& lanes, std::span<const Variant* const> variants, Lanes& in_tile) {
  Lanes able = !lanes.empty() && start(lanes, variants).ok() ? near_guess(lanes, variants) : Lanes();
  in_tile = able.empty() ? Lanes() : lanes;
  if (!able.empty() || lanes.size() <= 1) return able;
  const auto middle = lanes.begin() + static_cast<std::ptrdiff_t>(lanes.size() / 2);
  for (const Lanes& half : {Lanes(lanes.begin(), middle), Lanes(middle, lanes.end())}) {
    const Lanes of_half = startable(half, variants, in_tile);
    able.insert(able.end(), of_half.begin(), of_half.end());
  }
  return able;
}

// Binds the members and assembles them in the lanes, from their guesses. Those that must be prepared leave `together`.
void SideBySide::assemble(std::vector<LaneRun*>& together, std::vector<Variant>& at) {
  std::vector<std::size_t> members;
  for (const LaneRun* lane : together) members.push_back(lane->member);
  std::vector<const Variant*> variants(members.size());
  binder_->bind(members, variants);
  Lanes bound, in_tile;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (variants[i] != nullptr) bound.push_back(i);
  }
  Lanes able = started_near(bound, variants);
  if (able != bound) {
    std::erase_if(bound, [&](std::size_t i) {
      return std::find(able.begin(), able.end(), i) == able.end() && !binder_->assemble(i);
    });
    able = startable(bound, variants, in_tile);
    if (!able.empty() && able != in_tile && !(able.size() < bound.size() && start(able, variants).ok())) able.clear();
  }
  std::vector<LaneRun*> started;
  for (LaneRun* lane : together) lane->unbound = true;
  for (const std::size_t i : able) {
    together[i]->unbound = false;
    started.push_back(together[i]);
    at.push_back(*variants[i]);
  }
  together = std::move(started);
}

void SideBySide::run(std::span<LaneRun* const> lanes, const std::function<bool()>& proceed) {
  const std::size_t last = lanes[0]->times.size() - 1;
  std::vector<LaneRun*> together(lanes.begin(), lanes.end());
  std::vector<Variant> at;
  if (binder_) {
    assemble(together, at);
  } else {
    for (const LaneRun* lane : together) at.push_back(lane->variant);
  }
  bool is_assembled = binder_ != nullptr;
  stopped_ = false;
  latest_.resize(lanes.size() * columns().size());
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    if (lanes[i]->consumer != nullptr) lanes[i]->rows = latest_.data() + i * columns().size();
  }
  for (std::size_t row = 0; !together.empty();) {
    std::vector<const Variant*> variants;
    for (const Variant& v : at) variants.push_back(&v);
    Status failed = std::exchange(is_assembled, false) ? Status{} : tile_.start(variants);
    const bool started = failed.ok();
    if (started && row == 0) {
      for (std::size_t i = 0; i < together.size(); ++i) {
        write_row(static_cast<int>(i), *together[i], 0);
        if (together[i]->posture_wanted < lanes[0]->times.size()) {
          together[i]->uniqueness = tile_.uniqueness(static_cast<int>(i));
        }
      }
      check_accuracy(together, 0);
      for (LaneRun* lane : together) give_row(*lane, 0);
    }
    for (std::size_t i = 0; i < together.size() && started && row > 0; ++i) {
      const std::size_t size = columns().size();
      tile_.continue_from(static_cast<int>(i), {together[i]->row(row, size), size});
    }
    if (started) {
      std::tie(row, failed) = follow(together, row, proceed);
      for (std::size_t i = 0; i < together.size(); ++i) together[i]->error.merge(tile_.estimated(static_cast<int>(i)));
    }
    if (row == last) return;

    // The lane that failed goes on alone. If it is unknown, each lane tries the next step alone, to find those that
    // cannot follow.
    const bool is_known = failed.where.is(Place::Kind::lane);
    const auto at_fault = is_known ? static_cast<std::size_t>(failed.where.index) : together.size();
    std::vector<LaneRun*> able;
    std::vector<Variant> able_at;
    for (std::size_t i = 0; i < together.size(); ++i) {
      Variant here = at[i];
      if (started) {
        here.posture = tile_.posture(static_cast<int>(i));
        here.limited = tile_.limited(static_cast<int>(i));
      }
      here.time = together[i]->times[row];
      if (!stopped_ && (!is_known || i == at_fault)) alone(*together[i], here, row, is_known, proceed);
      if (together[i]->alone) continue;
      able.push_back(together[i]);
      able_at.push_back(std::move(here));
    }
    if (stopped_) {
      for (std::size_t i = 0; i < able.size(); ++i) stop(*able[i], able_at[i].posture);
      return;
    }
    if (able.size() == together.size()) {  // each lane can solve the step alone, but not together
      for (std::size_t i = 0; i < able.size(); ++i) alone(*able[i], able_at[i], row, true, proceed);
      return;
    }
    together = std::move(able);
    at = std::move(able_at);
  }
}

void SideBySide::run_alone(LaneRun& run, const std::function<bool()>& proceed) {
  stopped_ = false;
  alone(run, run.variant, 0, true, proceed);
}

// Solves one step from `row` on; if it is not a plain step, or to_the_end is set, all further steps as well.
void SideBySide::alone(LaneRun& lane, Variant at, std::size_t row, bool to_the_end,
                       const std::function<bool()>& proceed) {
  const double from = at.time;
  const Status before = lane.status;  // ok, or inaccurate
  std::optional<Simulator> simulator = simulator_of(lane, std::move(at));
  if (!simulator) return;
  const GroupedSystem* const structure = preparation(simulator->prepared()).structure.get();
  const std::size_t columns = simulator->columns().size(), rows = lane.times.size();
  double* const first = lane.row(row, columns);
  const bool restarted = lane.done > row;  // the row is stored already, with unwrapped angles
  const std::vector<double> start(simulator->outputs().begin(), simulator->outputs().end());
  if (!restarted) std::copy(start.begin(), start.end(), first);
  const Turns turns(outputs(), first, start.data());
  lane.done = std::max(lane.done, row + 1);
  if (to_the_end) give_row(lane, row);
  if (row == lane.posture_wanted) lane.posture = SimulatorAccess::posture(*simulator);
  for (std::size_t k = row + 1; k < rows && lane.status.arrived() && !stopped_; ++k) {
    lane.status = SimulatorAccess::step_of_run(*simulator, lane.times[k]);
    const Counters& its = simulator->report().counters;
    const bool plain = lane.status.arrived() && its.rejected == 0 && its.substeps == 0 &&
                       preparation(simulator->prepared()).structure.get() == structure;
    if (k == row + 1 && !to_the_end && plain) {
      lane.status = before;
      return;
    }
    if (!lane.alone) {
      lane.alone = true;
      lane.alone_from = from;
      give_row(lane, row);
    }
    if (!lane.status.arrived()) break;
    std::copy(simulator->outputs().begin(), simulator->outputs().end(), lane.row(k, columns));
    turns.add_to(lane.row(k, columns));
    give_row(lane, k);
    lane.done = k + 1;
    if (k == lane.posture_wanted) lane.posture = SimulatorAccess::posture(*simulator);
    stopped_ = !proceed();
  }
  if (!lane.status.arrived() && simulator->time() != lane.times[lane.done - 1]) {
    lane.outputs.assign(simulator->outputs().begin(), simulator->outputs().end());
    turns.add_to(lane.outputs.data());
  }
  if (lane.status.arrived()) lane.status = simulator->report().status;
  if (lane.status.ok()) lane.status = before;
  lane.reached = simulator->time();
  if (lane.done <= lane.posture_wanted) lane.posture = SimulatorAccess::posture(*simulator);
  if (stopped_ && lane.status.arrived() && lane.done < rows) lane.status = {Code::interrupted, {}, lane.reached};
  const Report& report = simulator->report();
  lane.events.insert(lane.events.end(), report.events.begin(), report.events.end());
  lane.fallbacks = report.fallbacks;
  lane.error.merge(report.error);
  of_those_alone_.merge({report.counters, {}, report.effort});
}

// Empty if the posture has no velocities.
std::optional<Simulator> SideBySide::simulator_of(LaneRun& lane, Variant at) const {
  Preparation prepared = prepared_;
  auto structure = std::make_shared<GroupedSystem>(*prepared_.structure);
  structure->system = at.system;
  structure->start = std::move(at.posture);
  prepared.structure = structure;
  prepared.start_time = at.time;
  prepared.start_limits = std::move(at.limited);
  prepared.reselect = at.reselect;
  prepared.plan.run.chunks = prepared.plan.run.threads = 1;
  try {
    return Simulator(Preparation::shared(std::move(prepared)), settings_);
  } catch (const Error& e) {
    if (e.kind() != Error::Kind::numerical) throw;
    lane.alone = true;
    lane.alone_from = at.time;
    lane.status = {Code::singular, {}, 0};
    if (lane.done == 0) lane.cannot = e.what();
    if (lane.done > 0 && lane.done <= lane.posture_wanted) {
      lane.posture = structure->start;
      lane.reached = at.time;
    }
    return std::nullopt;
  }
}

}  // namespace assur
