// Derivatives of the outputs of a posture with respect to the controlled drivers.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "assur/jacobian.hpp"
#include "motion/continuation.hpp"
#include "outputs/output_program.hpp"

namespace assur {

// Memory for the Jacobian of one simulator.
class OutputSlopes {
 public:
  // The arguments must outlive this object.
  OutputSlopes(const GroupedSystem& structure, Continuation& motion, const OutputProgram& outputs);
  ~OutputSlopes();

  // Computes the Jacobian of the current posture.
  [[nodiscard]] const OutputJacobian& compute();

 private:
  struct OutputDerivative {
    std::size_t column, derivative;
  };
  [[nodiscard]] Status follow_drivers();

  Continuation& motion_;
  const OutputProgram& outputs_;
  std::vector<OutputDerivative> rows_;
  std::array<bool, 3> asked_{};        // derivatives in rows_
  std::array<LaneArray, 3> known_;     // the known coordinates and their derivatives, in the layout of the state
  std::vector<LaneArray> changes_;     // drivers: of all coordinates
  std::vector<double*> pointers_;      // to changes_
  LaneArray resting_;                  // zeros
  std::vector<std::uint8_t> regular_;  // packs
  std::vector<double> slopes_;         // columns
  struct Decomposition;                // keeps Eigen out of this header
  std::unique_ptr<Decomposition> decomposition_;  // null without outputs or drivers
  OutputJacobian out_;
};

}  // namespace assur
