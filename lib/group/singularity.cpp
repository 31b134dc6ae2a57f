#include "group/singularity.hpp"

#include <algorithm>
#include <cmath>

#include "decompositions.hpp"

namespace assur {
namespace {

constexpr double kFold = 30;  // a larger ratio of velocity to input velocity near a singularity indicates a fold

// Norm of the gradient of an equation in one lane, over the unknowns and the inputs that its block reads. A block of
// one unknown has only one singular value, which is small or large against this norm.
double norm_of_gradient(Workspace& work, std::int32_t equation, std::span<const std::int32_t> reads, int lane) {
  const std::size_t w = idx(work.lanes), at = idx(equation) * w + idx(lane);
  const Pattern& pattern = work.program.pattern;
  double norm = 0;
  for (std::size_t k = 0; k < pattern.row.size(); ++k) {
    if (pattern.row[k] == equation) norm = std::hypot(norm, work.jacobian[k * w + idx(lane)]);
  }
  LaneArray rates(work.input_rates.size()), rhs(work.rhs.size());
  for (const std::int32_t read : reads) {
    if (read < work.program.n) continue;
    const std::size_t input = idx(read - work.program.n) * w;
    std::fill_n(rates.begin() + static_cast<std::ptrdiff_t>(input), w, 1.0);
    work.evaluator->velocity_rhs(rates.data(), rhs.data());
    std::fill_n(rates.begin() + static_cast<std::ptrdiff_t>(input), w, 0.0);
    norm = std::hypot(norm, rhs[at]);
  }
  return norm;
}

}  // namespace

Singularity nearest_singularity(Workspace& work, const BlockConditions& blocks, const Pack& pack,
                                double* const (&state)[3]) {
  const std::size_t w = idx(work.lanes);
  work.set_inputs(pack, state[0]);
  work.evaluate(state[0] + pack.unknowns);
  work.gather(pack, state[1], work.input_rates);
  work.evaluator->velocity_rhs(work.input_rates.data(), work.rhs.data());
  // The right-hand side of each block, by the inputs and by the group's other blocks: rhs - J v over the unknowns of
  // other blocks.
  const Pattern& pattern = work.program.pattern;
  const double* rate = state[1] + pack.unknowns;
  for (std::int32_t c = 0; c < work.program.n; ++c) {
    for (std::int32_t k = pattern.column_start[idx(c)]; k < pattern.column_start[idx(c) + 1]; ++k) {
      const std::int32_t row = pattern.row[idx(k)];
      if (work.program.equation_block[idx(row)] == work.program.unknown_block[idx(c)]) continue;
      for (std::size_t l = 0; l < w; ++l)
        work.rhs[idx(row) * w + l] -= work.jacobian[idx(k) * w + l] * rate[idx(c) * w + l];
    }
  }
  const auto input_rate = [&](std::size_t lane) {
    double largest = 0;
    for (std::size_t i = lane; i < work.input_rates.size(); i += w)
      largest = std::max(largest, std::abs(work.input_rates[i]));
    return largest;
  };
  Singularity nearest;
  Status& worst = nearest.status = pack.failed(Code::branch_unknown, 1.0, 0);
  std::vector<double> matrix;
  for (int lane = 0; lane < pack.used; ++lane) {
    for (std::int32_t b = 0; b < work.program.blocks; ++b) {
      const auto n = static_cast<Eigen::Index>(blocks.size(b));
      if (n > 400) continue;  // minutes for a dense SVD
      matrix.resize(static_cast<std::size_t>(n * n));
      blocks.extract(work.jacobian.data(), b, lane, matrix);
      const Eigen::BDCSVD<Eigen::MatrixXd> svd(Eigen::Map<const Eigen::MatrixXd>(matrix.data(), n, n),
                                               Eigen::ComputeFullU);
      const double largest =
          n > 1 ? svd.singularValues()[0] : norm_of_gradient(work, blocks.equations(b)[0], blocks.reads(b), lane);
      const double ratio = svd.singularValues()[n - 1] / largest;
      if (!(ratio < worst.figure)) continue;
      worst = pack.failed(Code::branch_unknown, ratio, lane);
      nearest.block = b;
      nearest.lane = lane;
      nearest.smallest = svd.singularValues()[n - 1];
      if (ratio > 0.05) continue;
      // Towards a fold the velocity along the null vector grows like 1/sigma; at a change point it stays bounded.
      Eigen::VectorXd g(n);
      for (Eigen::Index i = 0; i < n; ++i)
        g[i] = work.rhs[idx(blocks.equations(b)[static_cast<std::size_t>(i)]) * w + idx(lane)];
      const double velocity = std::abs(svd.matrixU().col(n - 1).dot(g)) / svd.singularValues()[n - 1];
      worst.code = velocity > kFold * input_rate(idx(lane)) ? Code::limit_reached : Code::change_point_passed;
    }
  }
  if (nearest.block < 0) return nearest;
  for (const std::int32_t c : blocks.reads(nearest.block)) {
    const bool unknown = c < work.program.n;
    if (unknown && work.program.unknown_block[idx(c)] == nearest.block) continue;
    const std::size_t at = idx(unknown ? c : c - work.program.n) * w + idx(nearest.lane);
    nearest.reads.push_back(unknown ? state[0][pack.unknowns + at] : work.inputs[at]);
  }
  return nearest;
}

}  // namespace assur
