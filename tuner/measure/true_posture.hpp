// True errors of postures against the motion in quadruple precision.
#pragma once

#include <memory>
#include <vector>

#include "assur/plan.hpp"

namespace assur::measure {

class TruePosture {
 public:
  // Begins at the start of the scene. Throws Error: environment if this build has no quadruple precision, numerical if
  // the reference does not converge.
  explicit TruePosture(const Prepared& prepared);
  ~TruePosture();

  // Largest difference of these coordinates of a posture (internal units) from the true ones at time t, in quadruple
  // precision. t must not descend from call to call.
  [[nodiscard]] double error(double t, const std::vector<double>& posture, const std::vector<std::int32_t>& of);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace assur::measure
