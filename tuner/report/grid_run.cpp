#include "report/grid_run.hpp"

#include <algorithm>
#include <string>

#include "measure/step_times.hpp"

namespace assur::report {
namespace {

using measure::StepTimes;

constexpr double kLong = 0.02;  // s

int most_threads(const Plan& plan) {
  int q = 1;
  for (const Plan::Choice& c : plan.choices) q = std::max(q, c.solver.threads);
  return plan.run.threads * q;
}

}  // namespace

GridRun::GridRun(const Prepared& prepared, int iterations, const std::vector<int>& cores)
    : grid_(prepared.time),
      threads_(most_threads(prepared.plan)),
      pinned_(prepared.plan.run.threads > 1 && static_cast<std::size_t>(threads_) <= cores.size()),
      simulator_(prepared, {.iterations = iterations, .pin_to = pinned_ ? cores : std::vector<int>{}}),
      at_start_(simulator_.report().counters) {}

std::vector<double> GridRun::first_steps(int count) {
  std::vector<double> rows;
  const double begin = StepTimes::steady();
  for (int k = 0; k < count; ++k) {
    if (!advance()) throw Error(Error::Kind::numerical, std::string(name(simulator_.report().status.code)));
    rows.insert(rows.end(), simulator_.outputs().begin(), simulator_.outputs().end());
  }
  seconds_ = (StepTimes::steady() - begin) / count;
  return rows;
}

void GridRun::get_ready(int) {
  if (seconds_ > kLong) return;
  if (threads_ > 1) {
    measure::repeat_for(pinned_ ? measure::kUntilAwake : measure::kUntilSpread, [this] { (void)advance(); });
  } else {
    (void)advance();
  }
}

bool GridRun::run(int calls) {
  const double begin = StepTimes::steady();
  bool ok = true;
  for (int i = 0; i < calls; ++i) ok = advance() && ok;
  seconds_ = (StepTimes::steady() - begin) / calls;
  return ok;
}

double GridRun::iterations() const {
  const Counters& now = simulator_.report().counters;
  return static_cast<double>(now.newton_iterations - at_start_.newton_iterations) /
         static_cast<double>(std::max<std::int64_t>(now.group_solutions - at_start_.group_solutions, 1));
}

bool GridRun::advance() {
  if (next_ > grid_.steps()) {
    simulator_.reset();
    at_start_ = simulator_.report().counters;
    next_ = 1;
  }
  return simulator_.step(grid_.time(next_++)).arrived();
}

}  // namespace assur::report
