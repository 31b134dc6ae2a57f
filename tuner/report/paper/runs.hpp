// The paper's experiments, run on this machine: every strategy of a cell verified, then all of them timed in turns.
#pragma once

#include <memory>
#include <vector>

#include "assur/performance.hpp"
#include "measure/noise.hpp"
#include "report/energy.hpp"
#include "report/paper/plan.hpp"
#include "report/sections.hpp"

namespace assur::report {

struct PaperOptions {
  Conditions conditions;
  std::shared_ptr<const PerformanceModel> model = nullptr;  // that `auto` decides by; null: machine_model()
  double watts = 0;                                         // of the processor (thermal design power); 0: not known
  EnergyMeter meter = EnergyMeter();
};

struct PaperResults {
  std::vector<PaperTiming> times;  // of what was run, and of what was not, and why
  StandIns stand_ins;
  int threads = 1;
  bool quick = true, interrupted = false;
  measure::Judgement noise = {};
};

// Everything that fits into the time given, the short cells first. Never throws for what cannot run here: it is listed
// with the reason.
[[nodiscard]] PaperResults run_the_paper(const PaperOptions& options);

}  // namespace assur::report
