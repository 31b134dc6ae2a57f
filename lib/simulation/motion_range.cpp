#include "assur/motion_range.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "assur/simulator.hpp"
#include "decimal.hpp"
#include "equations/system.hpp"
#include "numbers.hpp"
#include "scene/names.hpp"
#include "simulation/simulator_access.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr int kSteps = 256;           // number of steps to one side; they are divided where needed
constexpr double kFarthestSize = 10;  // longest way of a length, in sizes of the mechanism

std::string chosen(std::string_view driver, const std::vector<std::string>& names) {
  if (driver.empty() && names.size() == 1) return names.front();
  if (std::find(names.begin(), names.end(), driver) != names.end()) return std::string(driver);
  const std::vector<std::string_view> known(names.begin(), names.end());
  throw Error(Error::Kind::input,
              names.empty() ? "the scene has no driver, so that nothing has a range"
              : driver.empty()
                  ? "the scene has " + std::to_string(names.size()) + " drivers; name one of them: " + list_of(known)
                  : "there is no driver " + in_quotes(driver) + known_instead(driver, known));
}

// "rad", "m", or "" for a component of a vector.
std::string unit_of(const System& system, std::string_view name) {
  for (const DriverInput& in : system.inputs) {
    const std::string& driver = system.drivers[static_cast<std::size_t>(in.driver)];
    if (in.kind != DriverInput::Kind::frame) {
      if (driver == name) return in.kind == DriverInput::Kind::direction ? "rad" : in.dimension == 1 ? "m" : "";
      continue;
    }
    for (int k = 0; k < system.dimension; ++k) {
      if (driver + "." + pose_part(static_cast<std::size_t>(k), system.dimension) == name) return "m";
    }
  }
  return "rad";
}

// Moves with time, from 0 to `way`.
RangeEnd end_of(Simulator& simulator, double way, std::vector<double>& change_times, std::vector<PassedLimit>& passed) {
  simulator.reset();
  Status status;
  for (int k = 1; k <= kSteps && status.arrived(); ++k)
    status = SimulatorAccess::step_of_run(simulator, way * k / kSteps);
  RangeEnd end;
  if (!status.arrived()) end.code = status.code;
  end.reached = simulator.time();
  end.beyond = status.arrived() ? end.reached : way;
  for (const Event& e : simulator.report().events) {
    if (e.kind == Code::change_point_passed) change_times.push_back(e.time + (e.until - e.time) / 2);
    const bool leaves = e.kind == Code::limit_exceeded;
    if (leaves || e.kind == Code::within_limits) {
      // A start posture outside is passed once.
      if (e.time != 0 || e.until != 0 || way > 0) passed.push_back({e.group, e.time + (e.until - e.time) / 2, leaves});
    }
    if (e.kind != end.code || end.code == Code::ok) continue;
    end.reached = e.time;
    end.beyond = e.until;
    end.group = e.group;
  }
  return end;
}

}  // namespace

MotionRange motion_range(const Scene& scene, std::string_view driver, double farthest) {
  if (!(farthest >= 0) || !std::isfinite(farthest)) {
    throw Error(Error::Kind::input,
                "the longest way to each side is " + general(farthest, 6) + "; it must be finite and >= 0");
  }
  std::vector<std::string> names;
  (void)scene.with_laws([&](const std::string& name, const Law& law) {
    names.push_back(name);
    return law;
  });
  MotionRange out;
  out.driver = chosen(driver, names);
  const GroupedSystem structure = group_equations(scene);
  out.unit = unit_of(*structure.system, out.driver);
  const bool length = out.unit == "m";
  const double rate = length ? structure.system->unit(1) : 1;  // of the driver, for each second
  if (farthest == 0) farthest = length ? kFarthestSize * rate : kTurn;

  const Scene moving = scene
                           .with_laws([&](const std::string& name, const Law& law) {
                             const double value = law(scene.time().start).value;
                             if (name != out.driver) return Law::constant(value);
                             out.start = value;
                             return Law::polynomial({value, rate});
                           })
                           .with_time({})
                           .with_outputs({});
  Simulator simulator(prepare(moving, {.budget = ThreadBudget{1}}));
  std::vector<double> change_times;
  out.low = end_of(simulator, -farthest / rate, change_times, out.passed);
  out.high = end_of(simulator, farthest / rate, change_times, out.passed);
  const auto value = [&](double time) { return out.start + rate * time; };
  for (RangeEnd* end : {&out.low, &out.high}) {
    end->reached = value(end->reached);
    end->beyond = value(end->beyond);
  }
  for (const double time : change_times) out.change_points.push_back(value(time));
  std::sort(out.change_points.begin(), out.change_points.end());
  for (PassedLimit& p : out.passed) p.at = value(p.at);
  std::stable_sort(out.passed.begin(), out.passed.end(),
                   [](const PassedLimit& a, const PassedLimit& b) { return a.at < b.at; });
  return out;
}

}  // namespace assur
