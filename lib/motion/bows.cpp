#include "motion/bows.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "numbers.hpp"
#include "outputs/random_sign.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

// omega E: see the header.
constexpr double kMostBow = (1 - kBall) * (1 - kBall);
constexpr double kGrown = 4;  // growth of omega of a block for which the probes are measured again; a choice
// If the bows may be this many times larger, probes are not measured at every anchor: where omega grows by kGrown, the
// probes grow likewise.
constexpr double kFar = kGrown * kGrown;
constexpr std::int64_t kRounds = 2;  // anchors of each block, on average, until they are measured again anyway
// Where an unknown rests although its inputs move, as at a dead centre, it will not rest for long.
constexpr double kLeastFollowed = 0.25;

}  // namespace

void Bows::resize(Layout& layout, std::size_t laws, std::size_t mechanisms) {
  layout_ = &layout;
  laws_ = laws;
  mechanisms_ = laws > 0 ? mechanisms : 0;
  clear();
  if (laws == 0) return;
  bows_.assign(laws * mechanisms, 0.0);
  times_.assign(mechanisms, 0.0);
  rates_.assign(laws, 0.0);
  memory_.assign(std::min(laws, kProbes), LaneArray(layout.size));
  all_probes_.clear();
  for (LaneArray& v : memory_) all_probes_.push_back(v.data());
  sizes_.assign(layout.size, 0.0);
  regular_.assign(layout.packs.size(), 0);
  std::size_t blocks = 0;
  for (const Pack& pack : layout.packs) blocks += pack.omega.size();
  measured_.weights = bows_;
  measured_.part.assign(mechanisms, 0.0);
  measured_.omega.assign(blocks, 0.0);
}

bool Bows::take(std::span<const double> bows, std::size_t mechanism) {
  if (mechanisms_ == 0) return false;
  const std::size_t first = mechanism * laws_;
  std::copy(bows.begin(), bows.end(), bows_.begin() + static_cast<std::ptrdiff_t>(first));
  double times = 0;
  for (std::size_t i = 0; i < laws_; ++i) {
    const double before = measured_.weights[first + i];
    if (bows[i] > times * before) times = bows[i] / before;  // or infinite
  }
  times_[mechanism] = times;
  return times > 0;
}

bool Bows::serve(std::int64_t branch_checks) {
  if (measured_.at < 0 || measured_.doubted) return false;
  const bool is_new = is_fresh_ && measured_.at == branch_checks;
  for (std::size_t m = 0; m < mechanisms_; ++m) {
    if (!std::isfinite(times_[m])) return false;
    if (!is_new && !(kFar * times_[m] * measured_.part[m] <= 1)) return false;
  }
  if (is_new || checked_ == branch_checks) return true;
  const std::int64_t anchors = branch_checks - measured_.at;
  if (anchors < 0 || anchors >= kRounds * static_cast<std::int64_t>(measured_.omega.size()) ||
      conditions_have_grown()) {
    return false;
  }
  checked_ = branch_checks;
  return true;
}

bool Bows::conditions_have_grown() const {
  const double* before = measured_.omega.data();
  for (const Pack& pack : layout_->packs) {
    for (const double omega : pack.omega) {
      if (omega > kGrown * *before++) return true;
    }
  }
  return false;
}

void Bows::begin() {
  std::copy(bows_.begin(), bows_.end(), measured_.weights.begin());
  for (double& times : times_) times = times > 0 ? 1 : 0;
  std::size_t most = 1;
  for (std::size_t m = 0; m < mechanisms_; ++m) {
    const auto bend =
        std::count_if(bows_.begin() + static_cast<std::ptrdiff_t>(m * laws_),
                      bows_.begin() + static_cast<std::ptrdiff_t>((m + 1) * laws_), [](double bow) { return bow > 0; });
    most = std::max(most, static_cast<std::size_t>(bend));
  }
  probes_ = std::span(all_probes_).first(std::min(most, all_probes_.size()));
  for (double* const probe : probes_) std::fill_n(probe, layout_->size, 0.0);
}

// The bows of the laws that a probe carries.
std::span<const double> Bows::share(std::size_t mechanism, std::size_t probe) {
  RandomSign sign(probe);
  std::size_t number = 0;
  for (std::size_t i = 0; i < laws_; ++i) {
    const double bow = bows_[mechanism * laws_ + i];
    rates_[i] = 0;
    if (bow > 0 && number++ % probes_.size() == probe) rates_[i] = sign() * bow;
  }
  return rates_;
}

void Bows::finish(std::int64_t branch_checks) {
  std::fill(sizes_.begin(), sizes_.end(), 0.0);
  for (const double* const probe : probes_) {
    for (std::size_t i = 0; i < sizes_.size(); ++i) sizes_[i] += std::abs(probe[i]);
  }
  std::fill(measured_.part.begin(), measured_.part.end(), 0.0);
  double* omega = measured_.omega.data();
  for (std::size_t p = 0; p < layout_->packs.size(); ++p) {
    const Pack& pack = layout_->packs[p];
    const GroupSolver& solver = *layout_->solvers[idx(pack.group_class)];
    const std::size_t w = idx(solver.lanes()), n = idx(solver.group_class().n);
    omega = std::copy(pack.omega.begin(), pack.omega.end(), omega);
    for (std::size_t l = 0; l < idx(pack.used); ++l) {
      const std::size_t m = mechanisms_ > 1 ? l : 0;
      double of_inputs = 0;
      for (std::size_t i = l; i < pack.inputs.size(); i += w) {
        of_inputs = std::max(of_inputs, sizes_[idx(pack.inputs[i])]);
      }
      for (std::size_t u = 0; u < n; ++u) {
        double& size = sizes_[pack.unknowns + u * w + l];
        size = std::max(size, kLeastFollowed * of_inputs);
      }
      for (std::int32_t b = 0; b < solver.group_class().blocks; ++b) {
        double moved = 0;
        for (const std::int32_t c : solver.blocks().reads(b)) {
          const std::size_t at = idx(c) < n ? pack.unknowns + idx(c) * w + l : idx(pack.inputs[(idx(c) - n) * w + l]);
          if (!(sizes_[at] <= moved)) moved = sizes_[at];
        }
        // Without a ball, of the typical length of the scene.
        const double of_ball = solver.group_class().quadratic() ? pack.omega[idx(b) * w + l] : 1;
        const double part = regular_[p] != 0 ? of_ball * moved / kMostBow : kInfinity;
        if (moved != 0) measured_.part[m] = std::max(measured_.part[m], std::isnan(part) ? kInfinity : part);
      }
    }
  }
  measured_.at = checked_ = branch_checks;
  measured_.doubted = false;
  is_fresh_ = true;
}

double Bows::part(std::size_t mechanism) const {
  const double most = measured_.part[mechanism], square = most > 0 ? times_[mechanism] * most : 0;
  return square > 1 ? std::sqrt(square) : square;
}

}  // namespace assur
