#include <memory>

#include "c/handles.hpp"
#include "equations/system.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"

using namespace assur;
using assur::c::call;
using assur::c::checked;
using assur::c::give;
using assur::c::name_at;

namespace {

Simulator& simulator_of(assur_simulator* handle) { return checked(handle, "simulator").simulator; }

// Names of the rows of the Jacobian, which are always the same.
const std::vector<std::string>& slopes_of(assur_simulator* handle) {
  assur_simulator& of = checked(handle, "simulator");
  if (of.slopes.empty()) of.slopes = of.simulator.jacobian().outputs;
  return of.slopes;
}

// Runs with rows given to `sink`, which returns true to end the run.
template <class Sink>
std::int32_t stream(Simulator& simulator, const double* times, std::size_t count, std::size_t every, const Sink& sink,
                    std::size_t* rows, assur_status* status) {
  bool ends = false;
  const RowSink take = [&](const MemberRows& block) { ends = ends || sink(block); };
  const Observer observe = [&](std::int64_t, std::int64_t) { return ends; };
  RowSelection selection;
  selection.every = every;
  const std::size_t reached = times != nullptr ? simulator.stream(selection, take, std::span(times, count), observe)
                                               : simulator.stream(selection, take, observe);
  if (rows != nullptr) *rows = reached;
  return give(simulator.report().status, status);
}

}  // namespace

extern "C" {

std::int32_t assur_simulator_new(const assur_plan* plan, const assur_step_settings* settings,
                                 assur_simulator** simulator) {
  return call([&] {
    assur_simulator*& out = checked(simulator, "simulator");
    out = new assur_simulator(Simulator(checked(plan, "plan").prepared, c::settings_of(settings)));
    return ASSUR_OK;
  });
}

void assur_simulator_free(assur_simulator* simulator) { delete simulator; }

std::size_t assur_simulator_column_count(const assur_simulator* simulator) {
  return simulator != nullptr ? simulator->simulator.columns().size() : 0;
}
const char* assur_simulator_column_name(const assur_simulator* simulator, std::size_t column) {
  return simulator != nullptr ? name_at(simulator->simulator.columns(), column) : nullptr;
}
std::int32_t assur_simulator_column(const assur_simulator* simulator, const char* name, std::size_t* column) {
  return call([&] {
    std::size_t& out = checked(column, "column");
    out = checked(simulator, "simulator").simulator.index(&checked(name, "name"));
    return ASSUR_OK;
  });
}

std::size_t assur_simulator_driver_count(const assur_simulator* simulator) {
  return simulator != nullptr ? simulator->drivers.size() : 0;
}
const char* assur_simulator_driver_name(const assur_simulator* simulator, std::size_t driver) {
  return simulator != nullptr ? name_at(simulator->driver_names, driver) : nullptr;
}
std::int32_t assur_simulator_driver(const assur_simulator* simulator, const char* name, std::size_t* driver) {
  return call([&] {
    std::size_t& out = checked(driver, "driver");
    const assur_simulator& of = checked(simulator, "simulator");
    (void)of.simulator.driver(&checked(name, "name"));  // refuses other names
    out = static_cast<std::size_t>(std::find(of.driver_names.begin(), of.driver_names.end(), name) -
                                   of.driver_names.begin());
    return ASSUR_OK;
  });
}

std::int32_t assur_simulator_set(assur_simulator* simulator, std::size_t driver, double value, double rate,
                                 double acceleration) {
  return call([&] {
    assur_simulator& of = checked(simulator, "simulator");
    const DriverHandle handle = driver < of.drivers.size() ? of.drivers[driver] : DriverHandle();  // which is refused
    of.simulator.set(handle, value, rate, acceleration);
    return ASSUR_OK;
  });
}

const char* assur_simulator_place_name(const assur_simulator* simulator, std::int32_t place, std::int32_t index) {
  if (simulator == nullptr) return nullptr;
  const Simulator& of = simulator->simulator;
  const auto among = [&](const auto& all) { return index >= 0 && static_cast<std::size_t>(index) < all.size(); };
  const bool is_known = place == ASSUR_PLACE_DRIVER   ? among(preparation(of.prepared()).structure->system->drivers)
                        : place == ASSUR_PLACE_GROUP  ? among(preparation(of.prepared()).structure->groups)
                        : place == ASSUR_PLACE_TARGET ? among(simulator->driver_names)
                        : place == ASSUR_PLACE_LIMIT  ? among(of.limits())
                                                      : false;
  if (!is_known) return place == ASSUR_PLACE_NONE ? "" : nullptr;
  return of.name_of({static_cast<Place::Kind>(place), index}).c_str();
}

std::int32_t assur_simulator_step(assur_simulator* simulator, assur_status* status) {
  return call([&] { return give(simulator_of(simulator).step(), status); });
}
std::int32_t assur_simulator_step_to(assur_simulator* simulator, double t, assur_status* status) {
  return call([&] { return give(simulator_of(simulator).step(t), status); });
}

double assur_simulator_time(const assur_simulator* simulator) {
  return simulator != nullptr ? simulator->simulator.time() : kNan;
}
const double* assur_simulator_outputs(const assur_simulator* simulator) {
  return simulator != nullptr ? simulator->simulator.outputs().data() : nullptr;
}

std::int32_t assur_simulator_run(assur_simulator* simulator, const double* times, std::size_t count, double* values,
                                 std::size_t row_stride, std::size_t* rows, assur_status* status) {
  return call([&] {
    Simulator& of = simulator_of(simulator);
    const std::size_t columns = of.columns().size();
    if (count > 0) (void)checked(values, "values");
    const std::vector<double> at = c::times_of(times, count, of.prepared().time());
    c::check_stride("row_stride", row_stride, at.size(), columns);
    double* to = values;
    const auto store = [&](const MemberRows& block) {
      for (std::size_t k = 0; k < block.times.size(); ++k, to += row_stride) {
        std::copy_n(block.values.data() + k * columns, columns, to);
      }
      return false;
    };
    return stream(of, at.data(), at.size(), 1, store, rows, status);
  });
}

std::int32_t assur_simulator_stream(assur_simulator* simulator, const double* times, std::size_t count,
                                    std::size_t every, assur_sink sink, void* context, std::size_t* rows,
                                    assur_status* status) {
  return call([&] {
    Simulator& of = simulator_of(simulator);
    if (sink == nullptr) c::refuse_null("sink");
    if (times != nullptr) c::check_extent("times", count, 1);
    const auto pass = [&](const MemberRows& block) {
      return sink(context, block.times.data(), block.values.data(), block.times.size()) != 0;
    };
    return stream(of, times, count, every, pass, rows, status);
  });
}

std::int32_t assur_simulator_reset(assur_simulator* simulator) {
  return call([&] {
    simulator_of(simulator).reset();
    return ASSUR_OK;
  });
}
std::int32_t assur_simulator_retreat(assur_simulator* simulator) {
  return call([&] {
    simulator_of(simulator).retreat();
    return ASSUR_OK;
  });
}
std::int32_t assur_simulator_save(assur_simulator* simulator, assur_state** state) {
  return call([&] {
    Simulator& of = simulator_of(simulator);
    assur_state*& out = checked(state, "state");
    if (out != nullptr) {
      of.save(out->state);
    } else {
      out = new assur_state{of.save()};
    }
    return ASSUR_OK;
  });
}
std::int32_t assur_simulator_restore(assur_simulator* simulator, const assur_state* state) {
  return call([&] {
    simulator_of(simulator).restore(checked(state, "state").state);
    return ASSUR_OK;
  });
}
void assur_state_free(assur_state* state) { delete state; }

std::int32_t assur_simulator_jacobian(assur_simulator* simulator, double* values, std::size_t row_stride,
                                      double* smallest, assur_status* status) {
  return call([&] {
    const OutputJacobian& jacobian = simulator_of(simulator).jacobian();
    const std::size_t drivers = jacobian.drivers.size();
    if (!jacobian.values.empty()) (void)checked(values, "values");
    c::check_stride("row_stride", row_stride, jacobian.outputs.size(), drivers);
    for (std::size_t r = 0; r < jacobian.outputs.size() && drivers > 0; ++r) {
      std::copy_n(jacobian.values.data() + r * drivers, drivers, values + r * row_stride);
    }
    if (smallest != nullptr) *smallest = jacobian.smallest_singular_value;
    return give(jacobian.status, status);
  });
}
std::size_t assur_simulator_jacobian_rows(assur_simulator* simulator) {
  std::size_t rows = 0;
  (void)call([&] {
    rows = slopes_of(simulator).size();
    return ASSUR_OK;
  });
  return rows;
}
const char* assur_simulator_jacobian_row_name(assur_simulator* simulator, std::size_t row) {
  const char* name = nullptr;
  (void)call([&] {
    name = name_at(slopes_of(simulator), row);
    return ASSUR_OK;
  });
  return name;
}

std::int32_t assur_simulator_report(const assur_simulator* simulator, assur_report* report) {
  return call([&] {
    const Report& of = checked(simulator, "simulator").simulator.report();
    const ErrorFigures& e = of.error;
    assur_report out{};
    out.size = sizeof out;
    (void)give(of.status, &out.status);
    out.reached = of.reached;
    out.steps = of.counters.steps;
    out.substeps = of.counters.substeps;
    out.rejected = of.counters.rejected;
    out.newton_iterations = of.counters.newton_iterations;
    out.factorizations = of.counters.factorizations;
    const double residual[3] = {e.position, e.velocity, e.acceleration};
    std::copy_n(residual, 3, out.residual);
    out.estimated_error[0] = e.estimated_position.value_or(kNan);
    out.estimated_error[1] = e.estimated_velocity.value_or(kNan);
    out.estimated_error[2] = e.estimated_acceleration.value_or(kNan);
    out.events = of.events.size();
    out.fallbacks = of.fallbacks.size();
    give(out, report, "report");
    return ASSUR_OK;
  });
}

std::int32_t assur_simulator_event(const assur_simulator* simulator, std::size_t event, assur_event* out) {
  return call([&] {
    const std::vector<Event>& events = checked(simulator, "simulator").simulator.report().events;
    if (event >= events.size()) {
      throw Error(Error::Kind::input, "there is no event " + std::to_string(event) + "; the report has " +
                                          std::to_string(events.size()) + ", counted from 0");
    }
    const Event& e = events[event];
    give(assur_event{sizeof(assur_event), e.time, e.until, e.figure, static_cast<std::int32_t>(e.kind), e.group.c_str(),
                     e.unit.c_str(), e.detail.c_str()},
         out, "out");
    return ASSUR_OK;
  });
}
const char* assur_simulator_fallback(const assur_simulator* simulator, std::size_t fallback) {
  const char* text = nullptr;
  (void)call([&] {
    text = name_at(checked(simulator, "simulator").simulator.report().fallbacks, fallback);
    return ASSUR_OK;
  });
  return text;
}

}  // extern "C"
