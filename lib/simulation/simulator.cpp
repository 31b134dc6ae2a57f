#include "assur/simulator.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "outputs/columns.hpp"
#include "simulation/constraint_jacobian.hpp"
#include "simulation/output_slopes.hpp"
#include "simulation/run_arguments.hpp"
#include "simulation/simulator_access.hpp"
#include "simulation/simulator_impl.hpp"

namespace assur {
namespace {

constexpr double kStepWithoutGrid = 1;  // s, length of step() if the scene has no time grid

const std::string kNone;  // not in a function, whose first call would take memory

// A quantity has left or entered its limit: undone with the step.
bool is_passage(const Noticed& e) { return e.kind == Code::limit_exceeded || e.kind == Code::within_limits; }

}  // namespace

std::vector<double> SimulatorAccess::posture(const Simulator& simulator) { return simulator.impl_->motion.posture(); }

void SimulatorAccess::use_clock(Simulator& simulator, std::chrono::steady_clock::time_point (*clock)()) {
  simulator.impl_->motion.use_clock(clock);
}

Simulator::Simulator(Prepared prepared, StepSettings settings) {
  check_settings(settings);
  const std::shared_ptr<const Preparation>& parts = Preparation::of(prepared);
  impl_ = std::make_unique<Impl>(parts, settings, parts->start_time.value_or(parts->time.start));
  impl_->know_other_sets();
  impl_->fresh = !impl_->has_functions;
}
Simulator::Simulator(Simulator&&) noexcept = default;
Simulator& Simulator::operator=(Simulator&&) noexcept = default;
Simulator::~Simulator() = default;

Prepared rehearse(Prepared prepared) {
  if (!preparation(prepared).reselect) return prepared;
  Simulator simulator(prepared);
  simulator.stream({}, [](const MemberRows&) {});
  const Simulator::Impl& last = *simulator.impl_;
  Preparation out = preparation(prepared);
  const auto keep = [&](const Simulator::Impl& set) {
    if (set.owned != last.first) out.other_sets.push_back(set.owned);
  };
  out.other_sets.clear();
  for (const auto& set : last.others) keep(*set);
  keep(last);
  return Preparation::shared(std::move(out));
}

double Simulator::time() const { return impl_->motion.time(); }

Status SimulatorAccess::step_of_run(Simulator& simulator, double t) {
  simulator.impl_->begin_step();
  return simulator.go_to(t);
}

Status Simulator::step(double t) {
  impl_->events.bound();
  try {
    const Status status = SimulatorAccess::step_of_run(*this, t);
    if (!status.arrived()) impl_->motion.rest();
    return status;
  } catch (...) {  // from a law or a callback
    impl_->motion.rest();
    throw;
  }
}

Status Simulator::go_to(double t) {
  const double from = impl_->motion.time();
  Status status = impl_->step_to(t, true);
  if (impl_->motion.wants_reselection()) {
    if (impl_->motion.deadline_passed()) {
      status = impl_->report.status = impl_->motion.late();
    } else if (auto next = impl_->reselected()) {
      Impl::replace(impl_, std::move(next));
      return go_to(t);
    } else {
      status = impl_->step_to(t, false);
    }
  }
  if (!impl_->undivided) {
    impl_->in_one_piece = false;
  } else if (status.ok() && t != from) {
    impl_->in_one_piece = true;
  }
  if (!status.ok() || t == from) return status.ok() ? impl_->report_verdict(from) : status;
  if (impl_->prepared.reselect) {
    if (auto next = impl_->reselected_if_poor()) Impl::replace(impl_, std::move(next));
  }
  return impl_->check_accuracy(from);
}

void Simulator::set(std::string_view driver, double value, double rate, double acceleration) {
  set(this->driver(driver), value, rate, acceleration);
}
void Simulator::set(DriverHandle driver, double value, double rate, double acceleration) {
  impl_->fresh = false;
  impl_->motion.inputs().set(driver.index_, driver.among_, {value, rate, acceleration});
}
DriverHandle Simulator::driver(std::string_view name) const {
  const Inputs& inputs = impl_->motion.inputs();
  return {inputs.index(name), inputs.names()};
}

Status Simulator::step() {
  const double length = impl_->prepared.time.step;
  const double t = impl_->motion.time() + (length > 0 ? length : kStepWithoutGrid);
  impl_->events.bound();
  const std::int64_t begin = impl_->events.end();
  const auto undo = [&] {
    impl_->events.erase(begin, impl_->events.end(), is_passage);
    if (impl_->began != nullptr) Impl::restore(impl_, *impl_->began);
  };
  try {
    impl_->begin_step();
    // A function of the program may throw after the step has arrived, while its errors are estimated.
    if (impl_->has_functions) impl_->keep_start_of_step(false);
    const Status status = go_to(t);
    if (status.arrived()) return status;
    undo();
    // Drivers that move towards a limit may overshoot into it before they turn back.
    const bool may_repeat = !impl_->undivided && status.code != Code::deadline && status.code != Code::interrupted;
    if (!may_repeat || !impl_->motion.ask_again_from_rest()) return status;
    const std::int64_t failed = impl_->events.end();
    impl_->motion.count_rejected_from(0);
    impl_->motion.join_events_from(failed);  // the times of an event belong to one try
    const Status again = go_to(t);
    const auto any = [](const Noticed&) { return true; };
    if (again.arrived()) {
      impl_->events.erase(begin, failed, any);
      return again;
    }
    impl_->events.erase(failed, impl_->events.end(), any);
    undo();
    impl_->report.status = status;
    return status;
  } catch (...) {  // from a law or a callback
    undo();
    throw;
  }
}

SimulatorState Simulator::save() {
  SimulatorState state;
  save(state);
  return state;
}

void Simulator::save(SimulatorState& into) {
  if (!into.impl_) into.impl_ = std::make_unique<SimulatorState::Impl>();
  SimulatorState::Impl& state = *into.impl_;
  const bool has_memory = state.now.first && state.now.first->structure == impl_->first->structure;
  impl_->fresh = false;
  impl_->motion.drop_factors();
  impl_->save(state.now, false);
  if (!has_memory) impl_->save(state.inside, false);
  if (!impl_->in_one_piece) state.inside = *impl_->inside;
}

void Simulator::restore(const SimulatorState& from) {
  if (from.empty()) throw Error(Error::Kind::input, "this state is empty; fill it with Simulator::save()");
  const SimulatorState::Impl::Snapshot& now = from.impl_->now;
  const bool other_equations = now.prepared->structure->checks != impl_->structure.checks;
  if (now.first->structure != impl_->first->structure || !(other_equations || impl_->motion.fits(now.motion))) {
    throw Error(Error::Kind::input, "the state belongs to another plan; save it from a simulator of the same Prepared");
  }
  Impl::restore(impl_, now);
  if (!impl_->in_one_piece) *impl_->inside = from.impl_->inside;
  impl_->report.status = impl_->doubt;
}

void Simulator::retreat() {
  if (!impl_->in_one_piece) Impl::restore(impl_, *impl_->inside);
  impl_->report.status = impl_->doubt;
}

SimulatorState::SimulatorState() = default;
SimulatorState::SimulatorState(SimulatorState&&) noexcept = default;
SimulatorState& SimulatorState::operator=(SimulatorState&&) noexcept = default;
SimulatorState::~SimulatorState() = default;
SimulatorState::SimulatorState(const SimulatorState& o) : impl_(o.impl_ ? std::make_unique<Impl>(*o.impl_) : nullptr) {}
SimulatorState& SimulatorState::operator=(const SimulatorState& o) { return *this = SimulatorState(o); }

double SimulatorState::time() const { return impl_ ? impl_->now.motion.time : kNan; }

void Simulator::reset() {
  if (std::exchange(impl_->fresh, false)) return;
  const double start = impl_->first->start_time.value_or(impl_->first->time.start);
  if (impl_->first != impl_->owned) {
    Impl::return_to_first(impl_, start);
  } else {
    impl_->start(start, impl_->structure.start);
  }
  impl_->fresh = !impl_->has_functions;
}

const std::vector<std::string>& Simulator::columns() const { return impl_->columns; }
std::span<const double> Simulator::outputs() const { return impl_->row; }

double Simulator::output(std::string_view column) const { return impl_->row[index(column)]; }
std::size_t Simulator::index(std::string_view column) const { return column_index(impl_->columns, column); }

std::vector<std::string> Simulator::drivers() const {
  std::vector<std::string> names;
  for (const Inputs::Control& c : impl_->motion.inputs().controls()) names.push_back(c.name);
  return names;
}

std::vector<std::string> Simulator::limits() const {
  std::vector<std::string> names;
  for (const Index m : limited_quantities(impl_->system)) names.push_back(impl_->system.measures[idx(m)].name);
  return names;
}

const std::string& Simulator::name_of(Place place) const {
  const System& system = impl_->system;
  switch (place.kind) {
    case Place::Kind::driver:
      return system.drivers[idx(place.index)];
    case Place::Kind::group:
      return impl_->structure.groups[idx(place.index)].name;
    case Place::Kind::target:
      return impl_->motion.inputs().controls()[idx(place.index)].name;
    case Place::Kind::limit:
      return system.measures[idx(limited_quantities(system)[idx(place.index)])].name;
    case Place::Kind::none:
    case Place::Kind::lane:
    case Place::Kind::member:
      break;
  }
  return kNone;
}

const OutputJacobian& Simulator::jacobian() {
  impl_->fresh = false;
  if (!impl_->slopes) {
    impl_->slopes = std::make_unique<OutputSlopes>(impl_->structure, impl_->motion, impl_->outputs);
  }
  return impl_->slopes->compute();
}

ConstraintJacobian Simulator::constraint_jacobian() const {
  std::vector<std::int32_t> all(impl_->structure.groups.size());
  std::iota(all.begin(), all.end(), 0);
  return assur::constraint_jacobian(impl_->structure, all, impl_->motion.posture());
}
ConstraintJacobian Simulator::constraint_jacobian(std::int32_t group) const {
  const auto groups = static_cast<std::int32_t>(impl_->structure.groups.size());
  if (group < 0 || group >= groups) {
    throw Error(Error::Kind::input, "there is no group " + std::to_string(group) + "; there are " +
                                        std::to_string(groups) + ", counted from 0");
  }
  return assur::constraint_jacobian(impl_->structure, {&group, 1}, impl_->motion.posture());
}

std::vector<GroupFigures> Simulator::examine() { return impl_->examine(); }

const Report& Simulator::report() const {
  impl_->report_effort();
  impl_->report_estimate();
  impl_->report_events();
  return impl_->report;
}
std::string Simulator::machine_code() const { return impl_->motion.machine_code(); }
Prepared Simulator::prepared() const { return Preparation::shared(impl_->owned); }

}  // namespace assur
