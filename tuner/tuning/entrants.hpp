// Cells that are ready for measuring.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "assur/performance.hpp"
#include "measure/workload.hpp"
#include "tuning/candidates.hpp"
#include "tuning/cells.hpp"

namespace assur::tuning {

// A candidate with its kernel; factor stands for factor and solve.
struct Candidate {
  Kernel kernel = Kernel::factor;
  Strategy strategy;
};

// One workload of a candidate, verified.
struct Entrant {
  Kernel kernel = Kernel::factor;
  Shape shape;
  Strategy strategy;
  measure::Workload* work = nullptr;
  std::shared_ptr<void> owner = nullptr;  // owner of `work`
  double backward_error = 0;              // NaN: not measured
  double forward_error = 0;
  int packs_of_step = 0;  // of a pack: number of such packs in the step that precedes it; 0: no part of a step
  int packs_of_call = 1;  // of a pack: number of packs that a call solves
};

class Ground {
 public:
  virtual ~Ground() = default;

  [[nodiscard]] const Shape& shape() const { return shape_; }
  // Shape for Kernel::around, in cells that measure it.
  [[nodiscard]] const std::optional<Shape>& around() const { return around_; }
  [[nodiscard]] const std::vector<Candidate>& candidates() const { return candidates_; }

  // Makes the workloads of a candidate. Throws Error if it cannot run, fails, or computes wrong results; it is then
  // never timed.
  [[nodiscard]] virtual std::vector<Entrant> enter(const Candidate& candidate) = 0;

 protected:
  Shape shape_;
  std::optional<Shape> around_;
  std::vector<Candidate> candidates_;
};

// Prepares a cell. Throws Error like prepare().
[[nodiscard]] std::unique_ptr<Ground> open(const Cell& cell, const Field& field);

}  // namespace assur::tuning
