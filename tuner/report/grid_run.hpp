// A strategy to be timed: step after step over the time grid of its scene, again from the start when that ends.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "assur/simulator.hpp"
#include "measure/workload.hpp"

namespace assur::report {

class GridRun final : public measure::Workload {
 public:
  // iterations: as StepLimits has them; cores: to pin to, used only if there is one for each thread. Throws Error as
  // Simulator does.
  GridRun(const Prepared& prepared, int iterations, const std::vector<int>& cores);

  // Outputs of the first steps: count rows of columns(). Throws Error (numerical) if one fails.
  [[nodiscard]] std::vector<double> first_steps(int count);

  // Long steps need no preparation, and would take too long for it.
  void get_ready(int calls) override;
  [[nodiscard]] bool run(int calls) override;

  [[nodiscard]] const std::vector<std::string>& columns() const { return simulator_.columns(); }
  [[nodiscard]] const ErrorFigures& error() const { return simulator_.report().error; }
  [[nodiscard]] double seconds() const { return seconds_; }  // of a step, when it was last run
  [[nodiscard]] double iterations() const;                   // of Newton's method, of a group and step, mean

 private:
  bool advance();

  TimeGrid grid_;
  int threads_;
  bool pinned_;
  Simulator simulator_;
  Counters at_start_;
  std::int64_t next_ = 1;
  double seconds_ = 0;
};

}  // namespace assur::report
