// Runs the experiments of the paper on this machine: verifies every strategy of a cell, then times all of them in
// turns.
#pragma once

#include <memory>
#include <vector>

#include "assur/performance.hpp"
#include "measure/noise.hpp"
#include "report/paper/device_parts.hpp"
#include "report/paper/energy.hpp"
#include "report/paper/plan.hpp"
#include "report/sections.hpp"

namespace assur::report {

struct PaperOptions {
  Conditions conditions;
  std::shared_ptr<const PerformanceModel> model = nullptr;  // model for `auto`; null: machine_model()
  double watts = 0;                                         // thermal design power of the processor; 0: unknown
  EnergyMeter meter = EnergyMeter();
};

struct PaperResults {
  std::vector<PaperTiming> times;  // times of all entrants; entrants that were not run have a reason
  StandIns stand_ins;
  std::vector<DeviceParts> device_parts = {};  // empty without cusolver
  int threads = 1;
  bool quick = true, interrupted = false;
  measure::NoiseAssessment noise = {};
};

// Runs everything that fits into the given time, short cells first. Entrants that cannot run here are listed with the
// reason, and cause no exception.
[[nodiscard]] PaperResults run_the_paper(const PaperOptions& options);

}  // namespace assur::report
