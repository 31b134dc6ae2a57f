// Data that the parts of a group's step share: the class, and the numbers of the current pack.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>

#include "evaluation/coefficients.hpp"
#include "evaluation/evaluator.hpp"
#include "evaluation/lane_array.hpp"
#include "groups/pack.hpp"
#include "groups/pack_kernels.hpp"
#include "index.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// One posture of one pack. A function that evaluates another posture overwrites it. All arrays are [row][lane].
struct Workspace {
  Workspace(const System& system, const GroupClass& its_class, int its_lanes)
      : group_class(its_class),
        lanes(its_lanes),
        evaluator(make_evaluator(system, group_class, lanes)),
        kernels(pack_kernels(lanes)) {
    const std::size_t w = idx(lanes);
    for (LaneArray* v : {&inputs, &input_rates, &input_accelerations}) v->resize(idx(group_class.inputs) * w);
    for (LaneArray* v : {&phi, &scale, &rhs}) v->resize(idx(group_class.n) * w);
    jacobian.resize(idx(group_class.pattern.nnz()) * w);
    correction.resize(idx(group_class.blocks) * w);
  }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  // Reads the inputs of a pack, one row for each, from a state array.
  void gather(const Pack& pack, const double* state, LaneArray& out) const {
    kernels.gather(pack.input_rows.data(), pack.inputs.data(), group_class.inputs, state, out.data());
  }
  void set_inputs(const Pack& pack, const double* state) {
    gather(pack, state, inputs);
    evaluator->set_inputs(pack.coefficients.data(), inputs.data());
  }
  // Fills phi and jacobian. x: the unknowns.
  void evaluate(const double* x) { evaluator->evaluate(x, phi.data(), jacobian.data()); }

  // Of the lanes that a pack uses, the one with the largest size among these numbers, or with one that is not a number.
  // numbers: rows x W
  [[nodiscard]] std::int32_t lane_with_most(const Pack& pack, std::span<const double> numbers) const {
    const std::size_t w = idx(lanes);
    std::size_t found = 0;
    double most = -1;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const double size = std::abs(numbers[i]);
      if (i % w >= idx(pack.used) || size <= most) continue;  // false for NaN
      if (std::isnan(size)) return static_cast<std::int32_t>(i % w);
      most = size;
      found = i % w;
    }
    return static_cast<std::int32_t>(found);
  }

  // Unknowns, or equations, of all lanes.
  [[nodiscard]] std::size_t size() const { return phi.size(); }

  const GroupClass& group_class;
  const int lanes;  // W
  const std::unique_ptr<Evaluator> evaluator;
  const PackKernels& kernels;
  LaneArray inputs, input_rates, input_accelerations;  // inputs x W
  LaneArray phi, scale, rhs;  // n x W: equations, Evaluator::scale, right-hand side of velocity or acceleration
  LaneArray jacobian;         // nnz x W
  LaneArray correction;       // blocks x W: largest entry of Newton's last correction
};

}  // namespace assur
