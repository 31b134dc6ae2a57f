// How each group fares at a posture, looked at from outside: what `assur run --errors` writes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "assur/simulator.hpp"
#include "measure/true_posture.hpp"

namespace assur::measure {

struct GroupFigures {
  double residual = 0;              // as ErrorFigures::position
  std::optional<double> estimated;  // of its unknowns, as `error`; empty: nobody made an estimate
  std::optional<double> error;      // largest |x - x_ref| of its unknowns, internal units: lengths about 1
  // max |J^-1| s over the largest coordinate, s the scale of the equations; empty: too large to tell every time,
  // infinite: singular.
  std::optional<double> condition;
  std::optional<std::int64_t> iterations;  // of the last step; empty: only known of all groups together
};

class Diagnosis {
 public:
  // with_reference: with true errors. Throws Error as forward_error() does.
  Diagnosis(const Prepared& prepared, bool with_reference);
  ~Diagnosis();

  // Of every group of simulator.prepared().structure, at simulator.time(), which never falls. Throws Error (numerical)
  // where the reference is lost.
  [[nodiscard]] std::vector<GroupFigures> look(const Simulator& simulator);

 private:
  struct Probe;
  void prepare_probes(const std::shared_ptr<const Structure>& structure);

  std::shared_ptr<const Structure> structure_;  // that the probes are made for
  std::vector<std::unique_ptr<Probe>> probes_;  // of each class
  std::unique_ptr<TruePosture> truth_;          // null: without reference
  std::int64_t iterations_ = 0;                 // counted so far
};

}  // namespace assur::measure
