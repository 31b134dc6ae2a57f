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

struct GroupErrors {
  GroupFigures figures;
  std::optional<double> error;             // largest |x - x_ref| of its unknowns, internal units: lengths about 1
  std::optional<std::int64_t> iterations;  // of the last step; empty: only known of all groups together
};

class Diagnosis {
 public:
  // with_reference: with true errors. Throws Error as forward_error() does.
  Diagnosis(const Prepared& prepared, bool with_reference);

  // Of every group of simulator.prepared().structure, at simulator.time(), which never falls. Throws Error (numerical)
  // where the reference is lost.
  [[nodiscard]] std::vector<GroupErrors> look(Simulator& simulator);

 private:
  std::unique_ptr<TruePosture> truth_;  // null: without reference
  std::int64_t iterations_ = 0;         // counted so far
};

}  // namespace assur::measure
