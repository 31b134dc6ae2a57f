#include "measure/matrices.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "evaluation/evaluator.hpp"
#include "measure/postures.hpp"

namespace assur::measure {
namespace {

// Magnitude from 0.5 to 1, random sign.
double entry(std::mt19937_64& random) {
  const double magnitude = std::uniform_real_distribution<double>(0.5, 1)(random);
  return random() % 2 == 0 ? magnitude : -magnitude;
}

}  // namespace

Matrices jacobians(const GroupedSystem& structure, std::int32_t group_class, int most) {
  const GroupClass& shape = structure.classes[static_cast<std::size_t>(group_class)];
  const auto evaluator = make_evaluator(*structure.system, shape, 1);
  Matrices out{shape.pattern, {}};
  std::vector<double> phi(static_cast<std::size_t>(shape.n));
  for (const SolvedGroup& group : structure.groups) {
    if (group.group_class != group_class || static_cast<int>(out.values.size()) == most) continue;
    const Posture at = posture(structure, shape, group);
    evaluator->set_inputs(at.coefficients.data(), at.inputs.data());
    auto& values = out.values.emplace_back(shape.pattern.row.size());
    evaluator->evaluate(at.unknowns.data(), phi.data(), values.data());
  }
  return out;
}

Matrices random_matrices(std::int32_t n, int per_row, int count) {
  std::mt19937_64 random(static_cast<std::uint64_t>(1000) * static_cast<std::uint64_t>(n) +
                         static_cast<std::uint64_t>(per_row));
  std::vector<std::int32_t> diagonal(static_cast<std::size_t>(n));
  std::iota(diagonal.begin(), diagonal.end(), 0);
  std::shuffle(diagonal.begin(), diagonal.end(), random);
  Matrices out;
  out.pattern.n = n;
  out.pattern.column_start.push_back(0);
  std::vector<std::int32_t> rows;
  for (const std::int32_t pivot : diagonal) {
    rows.clear();
    if (per_row >= n) {
      rows.resize(diagonal.size());
      std::iota(rows.begin(), rows.end(), 0);
    } else {
      rows.push_back(pivot);
      while (static_cast<int>(rows.size()) < per_row) {
        const auto row = static_cast<std::int32_t>(random() % static_cast<std::uint64_t>(n));
        if (std::find(rows.begin(), rows.end(), row) == rows.end()) rows.push_back(row);
      }
      std::sort(rows.begin(), rows.end());
    }
    out.pattern.row.insert(out.pattern.row.end(), rows.begin(), rows.end());
    out.pattern.column_start.push_back(out.pattern.nnz());
  }
  // The spectral radius by the circular law: sqrt(entries of a row x their mean square).
  const double radius = std::sqrt(7.0 / 12 * std::min<std::int32_t>(per_row, n));
  for (int i = 0; i < count; ++i) {
    auto& values = out.values.emplace_back();
    for (std::int32_t column = 0; column < n; ++column) {
      const auto c = static_cast<std::size_t>(column);
      for (auto k = out.pattern.column_start[c]; k < out.pattern.column_start[c + 1]; ++k) {
        const bool pivot = out.pattern.row[static_cast<std::size_t>(k)] == diagonal[c];
        values.push_back(pivot ? std::copysign(2 * radius, entry(random)) : entry(random));
      }
    }
  }
  return out;
}

}  // namespace assur::measure
