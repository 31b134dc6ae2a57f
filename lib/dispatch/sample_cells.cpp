#include "dispatch/sample_cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "dispatch/impossible.hpp"
#include "dispatch/prior.hpp"
#include "median.hpp"

namespace assur {
namespace {

constexpr double kMostNoise = 1;      // the median of deviations from the median of positive numbers is not above it
constexpr double kUsualNoise = 0.02;  // relative; of a quiet machine
constexpr double kMuchNoisier = 3;    // times the scatter of the best sample of a cell: others are left out
constexpr double kMostError = std::numeric_limits<float>::max();

std::vector<std::string> backends_of(const std::vector<Sample>& samples) {
  std::vector<std::string> names;
  const auto add = [&](std::string_view name) {
    if (std::find(names.begin(), names.end(), name) != names.end()) return;
    names.emplace(std::lower_bound(names.begin(), names.end(), name), name);
  };
  for (const Backend& backend : backends()) add(backend.id);
  for (const Sample& s : samples) add(s.strategy.solver.backend);
  return names;
}

// The cell of each sample. Fills `numbers`.
std::vector<SampleCell> cells_of(const std::vector<Sample>& samples, CellNumbers& numbers) {
  numbers.backends = backends_of(samples);
  std::vector<std::pair<std::map<SolverVariant, std::int32_t>::iterator, std::map<KernelShape, std::int32_t>::iterator>>
      at;
  at.reserve(samples.size());
  std::map<KernelShape, std::int32_t> numbered;
  for (const Sample& s : samples) {
    const SolverVariant variant = numbers.variant_of(s.kernel, s.strategy);
    const KernelShape shape = kernel_shape(s.kernel, s.shape);
    // Most samples share one or both of them with the sample before.
    const bool same_variant = !at.empty() && at.back().first->first == variant;
    const bool same_shape = !at.empty() && at.back().second->first == shape;
    at.emplace_back(same_variant ? at.back().first : numbers.variants.try_emplace(variant, 0).first,
                    same_shape ? at.back().second : numbered.try_emplace(shape, 0).first);
  }
  for (std::int32_t next = 0; auto& [variant, number] : numbers.variants) number = next++;
  for (auto& [shape, number] : numbered) {
    number = static_cast<std::int32_t>(numbers.shapes.size());
    numbers.shapes.push_back(shape);
  }
  std::vector<SampleCell> cells;
  cells.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    cells.push_back({samples[i].kernel, at[i].first->second, at[i].second->second});
  }
  return cells;
}

using CellSample = std::pair<SampleCell, const Sample*>;
using Crowd = std::map<SampleCell, std::vector<double>>;  // s for a pack, while several threads solve such packs
using Crowds = std::map<std::int32_t, Crowd>;             // by threads

double noise_of(const Sample& s) { return std::min(s.spread / s.seconds, kMostNoise); }

// 0 if it was not measured.
double error_of(const Sample& s) { return s.backward_error > 0 ? std::min(s.backward_error, kMostError) : 0; }

GatheredCell of_one_cell(std::span<const CellSample> samples) {
  const auto& [cell, first] = samples[0];
  if (samples.size() == 1) return {cell, first, first->seconds, noise_of(*first), error_of(*first)};
  std::vector<double> seconds, noise;
  double error = 0;
  for (const auto& [same, s] : samples) {
    seconds.push_back(s->seconds);
    noise.push_back(noise_of(*s));
    error = std::max(error, error_of(*s));
  }
  const double most = kMuchNoisier * std::max(*std::min_element(noise.begin(), noise.end()), kUsualNoise);
  std::size_t quiet = 0;
  for (std::size_t i = 0; i < noise.size(); ++i) {
    if (noise[i] > most) continue;
    seconds[quiet] = seconds[i];
    noise[quiet++] = noise[i];
  }
  seconds.resize(quiet);
  noise.resize(quiet);
  return {cell, first, median(std::move(seconds)), median(std::move(noise)), error};
}

// Factor for each of p threads, by n. Other programs slow several threads down for seconds at a time, which the lower
// quartile ignores, as does the usual pace that the times of one thread are converted to.
std::map<std::int32_t, double> contentions_of(std::int32_t p, const Crowd& crowd, const GatheredSamples& gathered) {
  std::map<std::int32_t, std::vector<double>> ratios;
  for (const auto& [cell, seconds] : crowd) {
    const auto alone = std::lower_bound(gathered.cells.begin(), gathered.cells.end(), cell);
    if (alone == gathered.cells.end() || alone->cell != cell) continue;
    const double ratio = median(seconds) / alone->seconds;
    ratios[gathered.numbers.shape_at(cell).n].push_back(std::clamp(ratio, 1.0, static_cast<double>(p)));
  }
  std::map<std::int32_t, double> factors;
  for (const auto& [n, of] : ratios) factors[n] = quantile(of, 0.25);
  return factors;
}

}  // namespace

// A solver takes the same time for a bare matrix and for a group with the same pattern.
KernelShape kernel_shape(Kernel kernel, const Shape& shape) {
  const bool solver = kernel == Kernel::factor || kernel == Kernel::solve;
  const bool of_groups = kernel == Kernel::pack || kernel == Kernel::step;
  return {shape.pattern,
          solver ? 0 : shape.terms,
          shape.n,
          shape.nnz,
          of_groups ? shape.groups : 1,
          of_groups ? shape.rhs : 1,
          of_groups && shape.one_program};
}

SolverVariant CellNumbers::variant_of(Kernel kernel, const Strategy& s) const {
  if (kernel == Kernel::around) return {};  // independent of the solvers of the groups
  if (kernel == Kernel::evaluate) return {.lanes = s.solver.lanes};
  const auto found = std::find(backends.begin(), backends.end(), s.solver.backend);
  SolverVariant v{.backend = found == backends.end() ? -1 : static_cast<std::int32_t>(found - backends.begin()) + 1,
                  .single = s.solver.single,
                  .refine = s.solver.refine,
                  .q = s.solver.threads,
                  .lanes = s.solver.lanes};
  if (kernel == Kernel::pack) {
    v.once = s.solver.once;
    v.separate = s.solver.separate;
    v.together = s.run.together;
    v.reuse = s.solver.reuse;
  }
  return v;
}

std::int32_t CellNumbers::number_of(const SolverVariant& variant) const {
  const auto found = variants.find(variant);
  return found == variants.end() ? -1 : found->second;
}

GatheredSamples gather(const std::vector<Sample>& samples) {
  GatheredSamples out;
  std::vector<CellSample> all;
  all.reserve(samples.size());
  Crowds crowds;
  std::map<KernelShape, std::map<std::string, std::vector<CellSample>>> steps;  // by strategy
  const std::vector<SampleCell> cells = cells_of(samples, out.numbers);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    if (!why_impossible(s).empty()) continue;
    if (s.kernel == Kernel::meeting) {
      const double together = std::max(s.seconds - kAloneBeforeMeeting, 0.0);
      (s.shape.n == 0 ? out.threads.meetings : out.threads.handovers)[s.strategy.run.threads].push_back(
          together / std::max(s.shape.n, 1));
    } else if (s.kernel == Kernel::pack && s.strategy.run.threads > 1) {
      crowds[s.strategy.run.threads][cells[i]].push_back(s.seconds);
    } else if (s.kernel == Kernel::step) {
      steps[kernel_shape(s.kernel, s.shape)][to_string(s.strategy)].emplace_back(cells[i], &s);
    } else {
      all.emplace_back(cells[i], &s);
    }
  }
  for (const auto& [shape, by_strategy] : steps) {
    for (const auto& [text, of] : by_strategy) {
      const GatheredCell step = of_one_cell(of);
      out.steps[shape].push_back(
          {step.example->strategy, {step.seconds, std::exp(std::max(step.noise, kUsualNoise)), Origin::measured}});
    }
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  out.cells.reserve(all.size());
  for (auto begin = all.begin(), end = begin; begin != all.end(); begin = end) {
    while (end != all.end() && end->first == begin->first) ++end;
    out.cells.push_back(of_one_cell({begin, end}));
  }
  for (const auto& [p, crowd] : crowds) {
    std::map<std::int32_t, double> factors = contentions_of(p, crowd, out);
    if (!factors.empty()) out.threads.contentions[p] = std::move(factors);
  }
  return out;
}

}  // namespace assur
