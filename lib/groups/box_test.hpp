// The test of a tube (groups/branch.hpp): do boxes around postures of one lane hold exactly one solution each of an
// irreducible block? Four postures are tested side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "evaluation/coefficients.hpp"

namespace assur {

// For the blocks of one class.
class BoxTest {
 public:
  static constexpr std::size_t kPostures = 4;  // along the tube, side by side: kAlongTheTube
  // An entry of the Jacobian of a block: nonzero of the pattern, and its place in the block.
  struct JacobianEntry {
    std::int32_t nonzero, row, column;
  };
  struct Block {
    std::span<const JacobianEntry> entries;
    std::span<const std::int32_t> unknowns, equations;
  };
  // One of W lanes. All arrays are [row][lane].
  struct Lane {
    int lanes, lane;
    const double *coefficients, *jacobian;  // of the pack; of the posture in whose inverse the boxes are tested
  };

  virtual ~BoxTest() = default;

  // Takes four postures: n x 4 and inputs x 4.
  virtual void take(const Lane& of, const double* unknowns, const double* inputs) = 0;
  // Takes the posture of the Jacobian, by its equations and their scales (Evaluator::scale).
  virtual void take(const Lane& of, const double* phi, const double* scale, std::size_t equations) = 0;
  // True if a box was found around each posture. inverse: of the block, column after column
  [[nodiscard]] virtual bool hold(const Lane& of, const Block& block, const double* inverse) = 0;
};

[[nodiscard]] std::unique_ptr<BoxTest> make_box_test(const GroupClass& group_class);

}  // namespace assur
