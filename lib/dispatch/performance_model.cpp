#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "assur/performance.hpp"
#include "assur/status.hpp"
#include "dispatch/prior.hpp"
#include "dispatch/sample_cells.hpp"
#include "dispatch/time_fit.hpp"
#include "median.hpp"

namespace assur {
namespace {

struct NamedKernel {
  Kernel kernel;
  std::string_view name;
};
constexpr std::array kKernels = {NamedKernel{Kernel::evaluate, "evaluate"}, NamedKernel{Kernel::factor, "factor"},
                                 NamedKernel{Kernel::solve, "solve"},       NamedKernel{Kernel::pack, "pack"},
                                 NamedKernel{Kernel::meeting, "meeting"},   NamedKernel{Kernel::step, "step"},
                                 NamedKernel{Kernel::around, "around"}};

// Figures of a cell.
struct MeasuredCell {
  SampleCell cell{};
  double seconds = 0;
  float noise = 0, backward_error = 0;
  bool is_outlier = false;  // contradicts its neighbours: it is predicted like any other shape

  [[nodiscard]] Prediction prediction() const {
    return {seconds, std::exp(std::max<double>(noise, 0.02)), Origin::measured};
  }
  friend bool operator<(const MeasuredCell& a, const SampleCell& b) { return a.cell < b; }
};

using TimeFits = std::map<std::int32_t, TimeFit>;

double positive_log(double x) { return std::log(std::max(x, 1.0)); }

// Bytes of a group: coefficients, state and factors.
double bytes_of_group(const Shape& s) { return 8 * (4.0 * s.n + 2.0 * s.nnz + static_cast<double>(s.fill + s.terms)); }

// Rises from 0 to 1 as `bytes` outgrow a cache of this size.
double beyond(double bytes, double cache) {
  const double ratio = bytes / cache;
  return ratio * ratio / (1 + ratio * ratio);
}
constexpr double kApart = 10;      // distance of two paths, beyond the reach of any neighbour
constexpr double kMostOff = 20;    // a machine is at most this many times as fast as the prior assumes
constexpr double kFewSamples = 5;  // this many samples weigh as much as the prior in the speed of a machine
constexpr double kSmallCache = 1 << 20, kLargeCache = 1 << 24;  // bytes; nearby samples correct for the own caches

FitPoint point_of(Kernel kernel, const Shape& shape, const Strategy& strategy) {
  const double n = shape.n, nnz = shape.nnz, fill = static_cast<double>(shape.fill);
  const double operations = static_cast<double>(shape.operations), terms = static_cast<double>(shape.terms);
  const double deep = static_cast<double>(shape.depth);
  const double size = positive_log(n), filled = positive_log(fill / std::max(n, 1.0));
  switch (kernel) {
    case Kernel::factor:
      if (is_dense(strategy)) return {{1, n, n * n, n * n * n, fill}, {size, filled}};
      return {{1, n, fill, operations, deep}, {size, filled}};
    case Kernel::solve:
      if (is_dense(strategy)) return {{1, n, n * n}, {size, filled}};
      return {{1, n, fill, nnz, deep}, {size, filled}};
    case Kernel::evaluate:
      return {{1, n, terms, nnz}, {size, positive_log(terms / std::max(n, 1.0))}};
    default: {
      const double one = bytes_of_group(shape), all = one * shape.groups, moved = one * strategy.solver.lanes;
      return {{1, n, nnz, moved * beyond(all, kSmallCache), moved * beyond(all, kLargeCache)},
              {size, filled, kApart * static_cast<double>(path_of(shape, strategy)), 0.15 * positive_log(all)}};
    }
  }
}

Prediction combined(std::initializer_list<std::pair<double, Prediction>> parts) {
  Prediction sum{0, 1, Origin::measured};
  double variance = 0;
  for (const auto& [times, part] : parts) {
    if (times <= 0) continue;
    sum.seconds += times * part.seconds;
    variance += std::pow(times * part.seconds * std::log(part.factor), 2);
    sum.origin = std::max(sum.origin, part.origin);
  }
  if (sum.seconds > 0) sum.factor = std::exp(std::sqrt(variance) / sum.seconds);
  return sum;
}

}  // namespace

std::string_view name(Kernel kernel) noexcept {
  for (const NamedKernel& k : kKernels) {
    if (k.kernel == kernel) return k.name;
  }
  return "unknown";
}

Kernel parse_kernel(std::string_view text) {
  for (const NamedKernel& k : kKernels) {
    if (k.name == text) return k.kernel;
  }
  std::string known;
  for (const NamedKernel& k : kKernels) known += (known.empty() ? "" : ", ") + std::string(k.name);
  throw Error(Error::Kind::input, '"' + std::string(text) + "\" is not a kernel; the kernels are " + known);
}

std::string_view name(Origin origin) noexcept {
  constexpr std::array<std::string_view, 4> kNames = {"measured", "interpolated", "extrapolated", "prior"};
  return kNames[static_cast<std::size_t>(origin)];
}

struct PerformanceModel::Impl {
  // Times of kernels for one shape, which most strategies share.
  class Kernels {
   public:
    Kernels(const Impl& model, const Shape& shape) : model_(model), shape_(shape) {}

    [[nodiscard]] const Shape& shape() const { return shape_; }
    const Prediction& of(Kernel kernel, const Strategy& strategy) {
      const auto [at, is_new] = known_.try_emplace({kernel, model_.numbers.variant_of(kernel, strategy)});
      if (is_new) at->second = model_.predict(kernel, shape_, strategy);
      return at->second;
    }
    // Depends only on W for packs that are not solved in registers.
    const Prediction& rest_of_pack(const Strategy& strategy) {
      const auto [at, is_new] = rests_.try_emplace(strategy.solver.lanes);
      if (is_new) at->second = model_.measured_rest(shape_, strategy);
      return at->second;
    }

   private:
    const Impl& model_;
    const Shape& shape_;
    std::map<std::pair<Kernel, SolverVariant>, Prediction> known_;
    std::map<std::int32_t, Prediction> rests_;
  };

  // Such times for the shapes of all packs.
  class KernelsOfShapes {
   public:
    explicit KernelsOfShapes(const Impl& model) : model_(model) {}

    Kernels& of(const GatheredCell& g) {
      return shapes_.try_emplace(g.cell.shape, model_, g.example->shape).first->second;
    }

   private:
    const Impl& model_;
    std::map<std::int32_t, Kernels> shapes_;
  };

  Impl(const std::vector<Sample>& samples, std::string from) : source(std::move(from)), count(samples.size()) {
    GatheredSamples gathered = gather(samples);
    numbers = std::move(gathered.numbers);
    threads = std::move(gathered.threads);
    steps = std::move(gathered.steps);
    const GatheredCells& cells = gathered.cells;
    known.reserve(cells.size());
    for (const GatheredCell& g : cells) {
      known.push_back({g.cell, g.seconds, static_cast<float>(g.noise), static_cast<float>(g.backward_error)});
    }
    for (const Kernel kernel : {Kernel::evaluate, Kernel::factor, Kernel::solve}) fit(kernel, cells);
    KernelsOfShapes kernels(*this);
    fit_rest(cells, kernels);
    fit_packs(cells, kernels);
    fit_around(cells);
  }

  // Fits one sum for each variant of a kernel, and marks its outliers; point(g): the place of a measurement.
  template <class Point>
  TimeFits fits_of(Kernel kernel, const GatheredCells& cells, const Point& point) {
    TimeFits fits;
    std::vector<TimeFit::Measured> measured;
    std::vector<SampleCell> of_points;
    const SampleCell first{kernel, 0, 0};
    auto g = std::lower_bound(cells.begin(), cells.end(), first);
    while (g != cells.end() && g->cell.kernel == kernel) {
      const std::int32_t variant = g->cell.variant;
      measured.clear();
      of_points.clear();
      for (; g != cells.end() && g->cell.kernel == kernel && g->cell.variant == variant; ++g) {
        measured.push_back({point(*g), g->seconds, g->noise});
        of_points.push_back(g->cell);
      }
      const TimeFit& fit = fits.emplace_hint(fits.end(), variant, TimeFit(measured))->second;
      for (const std::size_t i : fit.outliers()) {
        std::lower_bound(known.begin(), known.end(), of_points[i])->is_outlier = true;
      }
    }
    return fits;
  }

  void fit(Kernel kernel, const GatheredCells& cells) {
    std::vector<double> ratios;
    ratios.reserve(cells.size());
    const auto k = static_cast<std::size_t>(kernel);
    fit_of[k] = fits_of(kernel, cells, [&](const GatheredCell& g) {
      const Sample& s = *g.example;
      ratios.push_back(g.seconds / prior_seconds(kernel, s.shape, s.strategy));
      return point_of(kernel, s.shape, s.strategy);
    });
    if (ratios.empty()) return;
    // A few samples may be of kernels that the prior predicts worst.
    const double trust = static_cast<double>(ratios.size()) / (static_cast<double>(ratios.size()) + kFewSamples);
    speed[k] = std::pow(median(std::move(ratios)), trust);
  }

  // Fits the time of a pack besides its kernels, by W. It does not depend on the solver, so the fastest solver shows it
  // best.
  void fit_rest(const GatheredCells& cells, KernelsOfShapes& kernels) {
    using CellKey = std::tuple<std::int32_t, std::uint64_t, std::int64_t, std::int32_t>;
    std::map<CellKey, const GatheredCell*> quickest;
    for (const GatheredCell& g : cells) {
      if (g.cell.kernel != Kernel::pack) continue;
      const Strategy& s = g.example->strategy;
      if (path_of(g.example->shape, s) != StepPath::composed) continue;
      if (s.solver.once || s.solver.reuse != Reuse::fresh) continue;
      const auto& [pattern, terms, n, nnz, groups, rhs, one_program] = numbers.shape_at(g.cell);
      const GatheredCell*& best = quickest[{s.solver.lanes, pattern, terms, groups}];
      if (best == nullptr || g.seconds < best->seconds) best = &g;
    }
    std::map<std::int32_t, std::vector<TimeFit::Measured>> points;
    for (const auto& [place, g] : quickest) {
      const auto& [shape, strategy] = std::tie(g->example->shape, g->example->strategy);
      const Prediction parts = kernels_of_pack(kernels.of(*g), strategy);
      const double rest_of_it = g->seconds - parts.seconds;
      if (parts.origin == Origin::prior || rest_of_it < 0.05 * g->seconds) continue;  // else it is only noise
      points[strategy.solver.lanes].push_back({point_of(Kernel::pack, shape, strategy), rest_of_it, g->noise});
    }
    for (auto& [lanes, measured] : points) rest.emplace(lanes, TimeFit(measured));
  }

  // Fits the time of whole packs beyond the sum of their parts.
  void fit_packs(const GatheredCells& cells, KernelsOfShapes& kernels) {
    packs = fits_of(Kernel::pack, cells, [&](const GatheredCell& g) {
      const auto& [shape, strategy] = std::tie(g.example->shape, g.example->strategy);
      return pack_point(shape, strategy, composed(kernels.of(g), strategy).seconds);
    });
  }

  // Fits the ratio to the prior, because mechanisms are too few to separate its terms. Differences of times scatter
  // more than times do; nearby measurements are still better than the fit.
  void fit_around(const GatheredCells& cells) {
    std::vector<TimeFit::Measured> points;
    for (const GatheredCell& g : cells) {
      if (g.cell.kernel != Kernel::around) continue;
      const KernelShape& shape = numbers.shape_at(g.cell);
      points.push_back({around_point(shape.n, shape.terms), g.seconds, 0});
    }
    if (!points.empty()) around.emplace(points);
  }

  [[nodiscard]] static FitPoint around_point(std::int64_t unknowns, std::int64_t pieces) {
    return {{prior_around_seconds(unknowns, pieces)},
            {positive_log(static_cast<double>(unknowns)), positive_log(static_cast<double>(pieces))}};
  }

  // parts: seconds of composed().
  [[nodiscard]] static FitPoint pack_point(const Shape& shape, const Strategy& strategy, double parts) {
    FitPoint point = point_of(Kernel::pack, shape, strategy);
    point.terms = {};
    point.terms[static_cast<std::size_t>(path_of(shape, strategy))] = parts;
    return point;
  }

  [[nodiscard]] static Prediction kernels_of_pack(Kernels& kernels, const Strategy& s) {
    const StepCounts counts = step_counts(s, kernels.shape().rhs - 1);
    return combined({{counts.evaluations, kernels.of(Kernel::evaluate, s)},
                     {counts.factorizations, kernels.of(Kernel::factor, s)},
                     {counts.solutions, kernels.of(Kernel::solve, s)}});
  }

  [[nodiscard]] Prediction composed(Kernels& kernels, const Strategy& s) const {
    const Shape& shape = kernels.shape();
    if (path_of(shape, s) == StepPath::in_registers)
      return {prior_seconds(Kernel::pack, shape, s) * speed_of_all(), 2, Origin::prior};
    return combined({{1, kernels_of_pack(kernels, s)}, {1, rest_of_pack(kernels, s)}});
  }

  [[nodiscard]] Prediction rest_of_pack(Kernels& kernels, const Strategy& s) const {
    if (!rest.empty()) return kernels.rest_of_pack(s);
    const Shape& shape = kernels.shape();
    const StepCounts counts = step_counts(s, shape.rhs - 1);
    const double of_kernels = counts.evaluations * prior_seconds(Kernel::evaluate, shape, s) +
                              counts.factorizations * prior_seconds(Kernel::factor, shape, s) +
                              counts.solutions * prior_seconds(Kernel::solve, shape, s);
    return {(prior_seconds(Kernel::pack, shape, s) - of_kernels) * speed_of_all(), 2, Origin::prior};
  }

  // Uses the fit of this W, or else of the nearest W. At least one exists.
  [[nodiscard]] Prediction measured_rest(const Shape& shape, const Strategy& s) const {
    const FitPoint point = point_of(Kernel::pack, shape, s);
    if (const auto found = rest.find(s.solver.lanes); found != rest.end()) return found->second.at(point);
    const auto nearest = std::min_element(rest.begin(), rest.end(), [&](const auto& a, const auto& b) {
      return std::abs(a.first - s.solver.lanes) < std::abs(b.first - s.solver.lanes);
    });
    Prediction there = nearest->second.at(point);
    there.origin = Origin::extrapolated;
    return there;
  }

  // Speed of this machine relative to that of the prior.
  [[nodiscard]] double speed_of_all() const { return speed[static_cast<std::size_t>(Kernel::evaluate)]; }

  [[nodiscard]] const MeasuredCell* exactly(Kernel kernel, const Shape& shape, std::int32_t variant) const {
    if (shape.pattern == 0 || variant < 0) return nullptr;
    const KernelShape wanted = kernel_shape(kernel, shape);
    const auto at = std::lower_bound(numbers.shapes.begin(), numbers.shapes.end(), wanted);
    if (at == numbers.shapes.end() || *at != wanted) return nullptr;
    const SampleCell cell{kernel, variant, static_cast<std::int32_t>(at - numbers.shapes.begin())};
    const auto found = std::lower_bound(known.begin(), known.end(), cell);
    return found == known.end() || found->cell != cell || found->is_outlier ? nullptr : &*found;
  }

  [[nodiscard]] Prediction predict(Kernel kernel, const Shape& shape, const Strategy& strategy) const {
    const SolverVariant wanted = numbers.variant_of(kernel, strategy);
    const std::int32_t variant = numbers.number_of(wanted);
    if (const MeasuredCell* k = exactly(kernel, shape, variant)) return k->prediction();
    const auto& fits = fit_of[static_cast<std::size_t>(kernel)];
    const FitPoint point = point_of(kernel, shape, strategy);
    const double prior = prior_seconds(kernel, shape, strategy);
    const double otherwise = prior * speed[static_cast<std::size_t>(kernel)];
    const auto plausible = [&](Prediction p) {
      p.seconds = std::max(p.seconds, prior / kMostOff);
      return p;
    };
    if (const auto found = fits.find(variant); found != fits.end()) {
      return plausible(found->second.at(point, otherwise));
    }
    if (const auto next = stand_in(fits, wanted); next != numbers.variants.end()) {
      Strategy other = strategy;
      other.solver.lanes = next->first.lanes;
      other.solver.threads = next->first.q;
      const double scale = prior / prior_seconds(kernel, shape, other);
      Prediction there = fits.at(next->second).at(point, otherwise / scale);
      there.seconds *= scale;
      there.factor *= 1.5;
      there.origin = Origin::extrapolated;
      return plausible(there);
    }
    return plausible({otherwise, 2, Origin::prior});
  }

  // The nearest variant of the same solver, with another W or other threads, that has a fit; end: there is none.
  [[nodiscard]] std::map<SolverVariant, std::int32_t>::const_iterator stand_in(const TimeFits& fits,
                                                                               const SolverVariant& wanted) const {
    auto best = numbers.variants.end();
    double least = 0;
    SolverVariant first = wanted;  // first variant of this solver; its variants are consecutive
    first.q = first.lanes = 0;
    const auto same_solver = [&](const SolverVariant& v) {
      const auto solver = [](const SolverVariant& of) {
        return std::tie(of.backend, of.single, of.refine, of.once, of.separate, of.together, of.reuse);
      };
      return solver(v) == solver(wanted);
    };
    for (auto at = numbers.variants.lower_bound(first); at != numbers.variants.end() && same_solver(at->first); ++at) {
      if (!fits.contains(at->second)) continue;
      const double distance = std::abs(std::log(static_cast<double>(at->first.lanes) / wanted.lanes)) +
                              std::abs(std::log(static_cast<double>(at->first.q) / wanted.q));
      if (best != numbers.variants.end() && distance >= least) continue;
      best = at;
      least = distance;
    }
    return best;
  }

  [[nodiscard]] Prediction pack(Kernels& kernels, const Strategy& strategy) const {
    const Shape& shape = kernels.shape();
    SolverVariant variant = numbers.variant_of(Kernel::pack, strategy);
    const std::int32_t number = numbers.number_of(variant);
    if (const MeasuredCell* k = exactly(Kernel::pack, shape, number)) return k->prediction();
    const Prediction sum = composed(kernels, strategy);
    auto found = packs.find(number);
    if (found == packs.end()) {  // same solver with another W, or else with the plain policy
      const auto next = stand_in(packs, variant);
      variant.once = variant.separate = variant.together = false;
      variant.reuse = Reuse::fresh;
      found = packs.find(next == numbers.variants.end() ? numbers.number_of(variant) : next->second);
    }
    if (found == packs.end()) return sum;
    Prediction whole = found->second.at(pack_point(shape, strategy, sum.seconds), sum.seconds);
    whole.seconds = std::max(whole.seconds, prior_seconds(Kernel::pack, shape, strategy) / kMostOff);
    if (path_of(shape, strategy) != StepPath::composed) return whole;
    return {whole.seconds, std::max(whole.factor, std::min(sum.factor, 1.5)), std::max(sum.origin, whole.origin)};
  }

  std::string source;
  std::size_t count = 0;
  CellNumbers numbers;
  std::vector<MeasuredCell> known;       // ascending
  std::array<TimeFits, 3> fit_of;        // evaluate, factor, solve; by variant
  std::array<double, 3> speed{1, 1, 1};  // measured over prior time of each of these kernels
  TimeFits rest;                         // W
  TimeFits packs;                        // by variant
  std::optional<TimeFit> around;
  ThreadCosts threads;
  std::map<KernelShape, std::vector<MeasuredStep>> steps;
};

PerformanceModel::PerformanceModel() : PerformanceModel(std::vector<Sample>{}, "nothing was measured") {}

PerformanceModel::PerformanceModel(std::vector<Sample> samples, std::string source)
    : impl_(std::make_shared<Impl>(samples, std::move(source))) {}

PerformanceModel::~PerformanceModel() = default;

Prediction PerformanceModel::kernel(Kernel kernel, const Shape& shape, const Strategy& strategy) const {
  switch (kernel) {
    case Kernel::pack:
      return pack(shape, strategy);
    case Kernel::meeting:
      return meeting(strategy.run.threads);
    case Kernel::step: {
      Prediction whole = pack(shape, strategy);
      const double packs = std::ceil(static_cast<double>(shape.groups) / strategy.solver.lanes);
      whole.seconds *= std::ceil(packs / strategy.run.threads) * contention(strategy.run.threads, shape.n);
      whole.seconds += meeting(strategy.run.threads).seconds + around(std::int64_t{shape.n} * shape.groups).seconds;
      return whole;
    }
    case Kernel::around:
      return around(shape.n, shape.terms);
    default:
      return impl_->predict(kernel, shape, strategy);
  }
}

Prediction PerformanceModel::pack(const Shape& shape, const Strategy& strategy) const {
  return packs(shape, {&strategy, 1})[0];
}

std::vector<Prediction> PerformanceModel::packs(const Shape& shape, std::span<const Strategy> strategies) const {
  Impl::Kernels kernels(*impl_, shape);
  std::vector<Prediction> all;
  for (const Strategy& strategy : strategies) all.push_back(impl_->pack(kernels, strategy));
  return all;
}

// The cost of a meeting grows evenly with threads, as far as measured; that of a handover does not.
Prediction PerformanceModel::meeting(std::int32_t p, double doubles) const {
  if (p < 2) return {0, 1, Origin::measured};
  const auto nearest = [p](const std::map<std::int32_t, std::vector<double>>& known) {
    const auto at = known.lower_bound(p);
    return at == known.end() ? std::prev(at) : at;
  };
  Prediction sum{prior_meeting_seconds(p), 2, Origin::prior};
  if (!impl_->threads.meetings.empty()) {
    const auto& [threads, seconds] = *nearest(impl_->threads.meetings);
    sum = {median(seconds) * p / threads, threads == p ? 1.2 : 1.5,
           threads == p ? Origin::measured : Origin::extrapolated};
  }
  // A measurement with many doubles includes the meeting, which is a small part of its time.
  const double each =
      impl_->threads.handovers.empty() ? kPriorHandover : median(nearest(impl_->threads.handovers)->second);
  sum.seconds += each * doubles;
  return sum;
}

// Numbers of threads and sizes of groups outside the measured range are replaced by the nearest measured ones.
double PerformanceModel::contention(std::int32_t p, std::int32_t n) const {
  const auto& known = impl_->threads.contentions;
  if (p < 2 || known.empty()) return 1;
  const auto of = known.lower_bound(p);
  const auto& sizes = of == known.end() ? std::prev(of)->second : of->second;
  const auto above = sizes.lower_bound(n);
  if (above == sizes.begin()) return above->second;
  const auto below = std::prev(above);
  if (above == sizes.end()) return below->second;
  const double share =
      std::log(static_cast<double>(n) / below->first) / std::log(static_cast<double>(above->first) / below->first);
  return below->second + share * (above->second - below->second);
}

Prediction PerformanceModel::around(std::int64_t unknowns, std::int64_t pieces) const {
  if (impl_->around) return impl_->around->at(Impl::around_point(unknowns, pieces));
  return {prior_around_seconds(unknowns, pieces) * impl_->speed_of_all(), 1.5, Origin::prior};
}

std::vector<PerformanceModel::MeasuredStep> PerformanceModel::steps(const Shape& shape) const {
  const auto found = impl_->steps.find(kernel_shape(Kernel::step, shape));
  return found == impl_->steps.end() || shape.pattern == 0 ? std::vector<MeasuredStep>() : found->second;
}

double PerformanceModel::backward_error(const Shape& shape, const Strategy& strategy) const {
  const std::int32_t wanted = impl_->numbers.number_of(impl_->numbers.variant_of(Kernel::solve, strategy));
  if (wanted < 0) return 0;
  double worst = 0;
  const auto& known = impl_->known;
  const SampleCell first{Kernel::solve, wanted, 0};
  for (auto k = std::lower_bound(known.begin(), known.end(), first); k != known.end(); ++k) {
    if (k->cell.kernel != first.kernel || k->cell.variant != wanted) break;
    const double n = impl_->numbers.shape_at(k->cell).n;
    if (n <= 2.0 * shape.n && 2.0 * n >= shape.n) worst = std::max<double>(worst, k->backward_error);
  }
  return worst;
}

std::size_t PerformanceModel::samples() const { return impl_->count; }
const std::string& PerformanceModel::source() const { return impl_->source; }

}  // namespace assur
