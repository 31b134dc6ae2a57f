// The motion in quad precision, rounded to doubles: what postures are held against.
#pragma once

#include <memory>
#include <vector>

#include "assur/plan.hpp"

namespace assur::measure {

class TruePosture {
 public:
  // At the scene's start. Throws Error: environment if this build has no quad arithmetic, numerical if the reference
  // does not converge.
  explicit TruePosture(const Prepared& prepared);
  ~TruePosture();

  // Largest difference of these coordinates of a posture (internal units) from the true ones at time t, which never
  // falls. The difference is taken in quad precision.
  [[nodiscard]] double error(double t, const std::vector<double>& posture, const std::vector<std::int32_t>& of);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace assur::measure
