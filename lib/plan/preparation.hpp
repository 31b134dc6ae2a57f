// What a Prepared holds.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/plan.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

class StepCode;

// A scene that is ready to run.
struct Preparation {
  std::shared_ptr<const Scene> scene;               // null if load_plan() made it
  std::string name;                                 // name of the scene
  TimeGrid time;                                    // the default of a run
  std::shared_ptr<const GroupedSystem> structure;   // groups, their order, and the start posture; never null
  Plan plan;                                        // solvers and threads
  std::span<const Backend> table;                   // has the backends that the plan names; must outlive simulators
  std::vector<std::string> controlled;              // PrepareOptions::controlled
  std::optional<double> start_time = std::nullopt;  // time of structure->start, s; empty: time.start
  std::vector<double> start_limits = {};            // limited quantities at start_time; empty: not known yet
  // Prepares the scene again with redundant equations chosen at a posture, see KnownStart. The plan stays: each class
  // is solved as the one nearest in size was. Empty if the scene has no redundant equations, or if load_plan() made
  // this. Throws like prepare().
  std::function<Preparation(std::vector<double> posture, double time, std::vector<std::int32_t> checked)> reselect;
  // The same with other redundant equations, which simulators know from the start. See rehearse().
  std::vector<std::shared_ptr<const Preparation>> other_sets = {};
  std::shared_ptr<StepCode> code = nullptr;  // null: without machine code

  // A Prepared with these parts.
  [[nodiscard]] static Prepared shared(std::shared_ptr<const Preparation> parts) { return Prepared(std::move(parts)); }
  [[nodiscard]] static Prepared shared(Preparation parts) {
    return shared(std::make_shared<const Preparation>(std::move(parts)));
  }
  [[nodiscard]] static const std::shared_ptr<const Preparation>& of(const Prepared& prepared) {
    return prepared.parts_;
  }
};

// The parts of a Prepared.
[[nodiscard]] inline const Preparation& preparation(const Prepared& prepared) { return *Preparation::of(prepared); }

}  // namespace assur
