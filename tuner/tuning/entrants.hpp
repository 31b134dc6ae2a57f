// A cell made ready to be measured.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "assur/performance.hpp"
#include "measure/workload.hpp"
#include "tuning/candidates.hpp"
#include "tuning/cells.hpp"

namespace assur::tuning {

// What a candidate is tried at: factor stands for factor and solve.
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
  std::shared_ptr<void> owner = nullptr;  // of what `work` lives in
  double backward_error = 0;              // NaN: not measured
  double forward_error = 0;
  int packs_of_step = 0;  // of a pack: that a step of this cell has of its class; 0: it is no part of one
};

class Ground {
 public:
  virtual ~Ground() = default;

  [[nodiscard]] const Shape& shape() const { return shape_; }
  // Of Kernel::around, in cells that are about it.
  [[nodiscard]] const std::optional<Shape>& around() const { return around_; }
  [[nodiscard]] const std::vector<Candidate>& candidates() const { return candidates_; }

  // Throws Error if the candidate cannot run, fails, or computes what is wrong: such a one is never timed.
  [[nodiscard]] virtual std::vector<Entrant> enter(const Candidate& candidate) = 0;

 protected:
  Shape shape_;
  std::optional<Shape> around_;
  std::vector<Candidate> candidates_;
};

// Throws Error as prepare() does.
[[nodiscard]] std::unique_ptr<Ground> open(const Cell& cell, const Field& field);

}  // namespace assur::tuning
