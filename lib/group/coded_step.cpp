#include "group/coded_step.hpp"

#include <algorithm>
#include <cmath>

#include "equations/separable.hpp"
#include "index.hpp"
#include "program/step_rules.hpp"

namespace assur {

namespace {

// Machine code computes all unknowns and their derivatives in one block.
bool can_be_coded(const GroupClass& c) {
  return (c.n == 2 || c.n == 3) && c.quadratic && c.blocks == 1 && c.first_wanted == 0;
}

bool has_kernel_of_distances(const Workspace& work) {
  const std::optional<Separable> separable = separate(work.program, work.group_class.input_moves);
  return work.lanes <= 8 && separable && measures_distances(*separable, work.program);
}

}  // namespace

std::unique_ptr<SmallStep> fastest_small_step(const Workspace& work, const BlockConditions& blocks, StepCode* code) {
  if (code != nullptr && can_be_coded(work.group_class) && !has_kernel_of_distances(work)) {
    auto step = code->of(work.group_class, work.program, blocks.reads(0), work.lanes);
    if (step) return std::make_unique<CodedStep>(work, std::move(step));
  }
  return make_small_step(work.group_class, work.program, blocks, work.lanes);
}

CodedStep::CodedStep(const Workspace& work, std::shared_ptr<const Executor> code)
    : work_(work), code_(std::move(code)) {
  const std::size_t w = idx(work.lanes), n = idx(work.program.n);
  for (LaneArray& of : inputs_) of.assign(idx(work.program.inputs) * w, 0.0);
  settings_.assign(kGroupSettings * w, 0.0);
  values_.assign(work_of_group_step(work.program) * w, 0.0);
  figures_.assign(kGroupFigures * w, 0.0);
  matrix_.resize(n * n);
  unknowns_ = n * w;
  at(Memory::inputs) = inputs_[0].data();
  at(Memory::input_rates) = inputs_[1].data();
  at(Memory::input_accelerations) = inputs_[2].data();
  at(Memory::settings) = settings_.data();
  at(Memory::work) = values_.data();
  at(Memory::figures) = figures_.data();
}

// Rows k and i > k are swapped before column k where swaps[...] is positive. Each pivot is then the largest entry of
// its column, relative to its row.
void CodedStep::choose_pivots(Pack& pack, const double* /*state*/) {
  const std::size_t w = idx(work_.lanes), n = idx(work_.program.n);
  for (LaneArray* swaps : {&pack.swaps, &pack.kept.swaps}) swaps->resize(pivots_of_group_step(work_.program) * w);
  const Pattern& pattern = work_.program.pattern;
  for (std::size_t lane = 0; lane < w; ++lane) {
    std::fill(matrix_.begin(), matrix_.end(), 0.0);
    for (std::size_t column = 0; column < n; ++column) {
      for (std::int32_t k = pattern.column_start[column]; k < pattern.column_start[column + 1]; ++k) {
        matrix_[idx(pattern.row[idx(k)]) * n + column] = work_.jacobian[idx(k) * w + lane];
      }
    }
    const auto row = [&](std::size_t i) { return matrix_.begin() + static_cast<std::ptrdiff_t>(i * n); };
    const auto squares = [&](std::size_t i) {
      double sum = 0;
      for (std::size_t j = 0; j < n; ++j) sum += row(i)[j] * row(i)[j];
      return sum;
    };
    double size[3] = {};
    for (std::size_t i = 0; i < n; ++i) size[i] = squares(i);
    double* swaps = pack.swaps.data() + lane;
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t i = k + 1; i < n; ++i, swaps += w) {
        *swaps = row(i)[k] * row(i)[k] * size[k] - row(k)[k] * row(k)[k] * size[i];
        if (!(*swaps > 0)) continue;
        std::swap_ranges(row(i), row(i) + static_cast<std::ptrdiff_t>(n), row(k));
        std::swap(size[i], size[k]);
      }
      for (std::size_t i = k + 1; i < n; ++i) {
        const double factor = row(i)[k] / row(k)[k];
        for (std::size_t j = k + 1; j < n; ++j) row(i)[j] -= factor * row(k)[j];
      }
    }
  }
}

void CodedStep::set(GroupSetting setting, double value) {
  const auto s = static_cast<std::size_t>(setting);
  if (set_[s] == value) return;
  set_[s] = value;
  std::fill_n(settings_.begin() + static_cast<std::ptrdiff_t>(s * idx(work_.lanes)), work_.lanes, value);
}

bool CodedStep::run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
                    SmallStepFigures& figures) {
  work_.kernels.gather_all(pack.input_rows.data(), pack.inputs.data(), work_.program.inputs, state, &at(Memory::inputs),
                           work_.group_class.derivatives + 1);
  set(GroupSetting::converged_at, converged);
  set(GroupSetting::most_iterations, most_iterations);
  set(GroupSetting::largest_first, largest_first_correction(pack.ball_used[0]));
  const auto put = [&](Memory m, const double* from) { at(m) = const_cast<double*>(from); };
  put(Memory::coefficients, pack.coefficients.data());
  put(Memory::unknowns, state[0] + pack.unknowns);
  put(Memory::rates, state[1] + pack.unknowns);
  put(Memory::accelerations, state[2] + pack.unknowns);
  put(Memory::pivots, pack.swaps.data());
  put(Memory::anchor, pack.anchor.data());
  put(Memory::omega, pack.omega.data());
  code_->run(memory_);
  double largest[kGroupFigures];
  work_.kernels.row_maxima(figures_.data(), kGroupFigures, largest);
  const auto figure = [&](GroupFigure f) { return largest[static_cast<std::size_t>(f)]; };
  if (figure(GroupFigure::failed) > 0) return false;
  figures.iterations = static_cast<int>(figure(GroupFigure::iterations));
  figures.position = std::max(figures.position, figure(GroupFigure::position));
  const int derivatives = work_.group_class.derivatives;
  if (derivatives > 0) figures.velocity = std::max(figures.velocity, figure(GroupFigure::velocity));
  if (derivatives > 1) figures.acceleration = std::max(figures.acceleration, figure(GroupFigure::acceleration));
  figures.ball_used = figure(GroupFigure::ball_used);
  double* const x = state[0] + pack.unknowns;
  for (std::size_t i = 0; i < unknowns_; ++i) x[i] = values_[i];
  return true;
}

}  // namespace assur
