// Sparse LU of many instances of one matrix side by side. Pivots and fill are fixed once, from the values of all lanes;
// each factorisation then runs the same straight-line program in SIMD lanes.
//
// The program chooses no pivots, so every factorisation is checked (Limits). A lane that exceeds the limits is redone
// alone, with its own pivots, in the same call; if that happens repeatedly, the class gets new pivots. The computed
// factors are exact for A + E with |E| <= n eps |L| |U| (Higham, Accuracy and Stability of Numerical Algorithms,
// theorem 9.3). `growth` bounds |L| |U| row by row against |A|, so a limit on it limits the backward error of each
// equation, whatever its scale.
#include "assur/backend.hpp"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include "backends/backends.hpp"
#include "backends/lanes_alone.hpp"
#include "backends/lanes_elimination.hpp"
#include "backends/lanes_factors.hpp"
#include "backends/lanes_kernels.hpp"
#include "backends/lanes_order.hpp"

namespace assur::lanes {
namespace {

constexpr std::int64_t kRecent = 8;  // factorisations: if two within this number are redone, new pivots are due
constexpr std::int64_t kMostPatience = 4096;    // largest number of factorisations between two renewals
constexpr std::int32_t kMostNonzeros = 90'000;  // a choice: those of a full matrix of 300 unknowns

class LanesSolver final : public LinearSolver {
 public:
  explicit LanesSolver(Precision precision) : precision_(precision) {}

  Status analyze(const Pattern& pattern, int lanes) override;
  Status factorize(std::span<const double> values) override;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override;
  Figures figures(int lane) const override;
  Effort effort() const override { return effort_; }
  bool restart() override;
  std::unique_ptr<LinearSolver> clone() const override;

  // See elimination_of(). Null: there is none.
  [[nodiscard]] const std::shared_ptr<const Elimination>* elimination() const {
    return all_served_ && precision_ == Precision::binary64 ? &factors_->program() : nullptr;
  }
  void count(std::int64_t factorizations) { count_ += factorizations; }

 private:
  // reserves: memory for pivots that are chosen later
  void prepare(std::shared_ptr<const Pattern> pattern, int lanes, bool reserves);
  void begin();  // without pivots
  [[nodiscard]] std::uint32_t every_lane() const { return (1u << lanes_) - 1; }
  [[nodiscard]] std::uint32_t finite_lanes(std::span<const double> values);
  void choose_pivots(std::span<const double> values, std::uint32_t wanted);
  [[nodiscard]] std::uint32_t run(std::span<const double> values);
  [[nodiscard]] Status rescue(std::span<const double> values, std::uint32_t alarmed);
  [[nodiscard]] std::uint32_t redo(std::span<const double> values, std::uint32_t alarmed);
  [[nodiscard]] int twin(std::span<const double> values, int lane, std::uint32_t among) const;
  [[nodiscard]] bool renewal_is_due();

  Precision precision_;
  std::shared_ptr<const Pattern> pattern_;
  int lanes_ = 0;
  Limits limits_{};
  std::unique_ptr<PivotMemory> memory_;
  std::unique_ptr<Factors> factors_;
  Effort effort_;

  // True: the pivots of the class serve every lane, and the next members are not read.
  bool all_served_ = false;
  std::vector<Code> code_;   // lanes
  std::vector<int> server_;  // lanes: index of the `alone_` that serves the lane; -1: the class's factors
  std::vector<std::unique_ptr<LaneAlone>> alone_;  // lanes; null until needed
  std::vector<double> lane_values_;                // nnz
  std::vector<double> lane_right_;                 // lanes x kRightSides x n

  std::int64_t count_ = 0, last_redone_ = -kRecent, last_renewed_ = 0;  // factorisations
  std::int64_t patience_ = kRecent;  // factorisations until the next renewal is allowed
};

Status LanesSolver::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  if (lanes > kMostLanes || !std::has_single_bit(static_cast<unsigned>(lanes))) {
    throw Error(Error::Kind::input, "the backend lanes has 1, 2, 4, 8 or 16 lanes, not " + std::to_string(lanes));
  }
  prepare(std::make_shared<const Pattern>(pattern), lanes, true);
  return {};
}

void LanesSolver::prepare(std::shared_ptr<const Pattern> pattern, int lanes, bool reserves) {
  pattern_ = std::move(pattern);
  lanes_ = lanes;
  limits_ = limits(pattern_->n, precision_);
  const auto w = static_cast<std::size_t>(lanes);
  alone_.clear();
  factors_ = std::make_unique<Factors>(lanes, precision_);
  factors_->reserve(pattern_->n);
  memory_ = std::make_unique<PivotMemory>(pattern_->n, lanes, reserves ? w + 1 : 0);
  alone_.resize(w);
  if (memory_->is_reserved()) {
    for (auto& alone : alone_) alone = std::make_unique<LaneAlone>(pattern_, *memory_);
    lane_right_.reserve(w * kRightSides * static_cast<std::size_t>(pattern_->n));
  }
  lane_values_.resize(pattern_->row.size());
  begin();
}

void LanesSolver::begin() {
  const auto w = static_cast<std::size_t>(lanes_);
  effort_ = {};
  all_served_ = false;
  code_.assign(w, Code::singular);
  server_.assign(w, -1);
  lane_right_.clear();
  count_ = last_renewed_ = 0;
  last_redone_ = -kRecent;
  patience_ = kRecent;
}

bool LanesSolver::restart() {
  if (!memory_ || !memory_->is_reserved()) return false;
  factors_->forget();
  for (const auto& alone : alone_) alone->forget();
  begin();
  return true;
}

std::unique_ptr<LinearSolver> LanesSolver::clone() const {
  auto other = std::make_unique<LanesSolver>(precision_);
  if (pattern_) {
    other->prepare(pattern_, lanes_, false);  // there may be thousands
    if (factors_->program()) {
      other->factors_->set_program(factors_->program());
      memory_->give_away(factors_->program());
    }
  }
  return other;
}

Status LanesSolver::factorize(std::span<const double> values) {
  check_size("values", values.size(), pattern_->row.size() * static_cast<std::size_t>(lanes_));
  ++count_;
  if (!factors_->program()) choose_pivots(values, finite_lanes(values));
  const std::uint32_t alarmed = run(values);
  if (alarmed == 0 && all_served_) return {};
  return rescue(values, alarmed);
}

// Returns the lanes that the pivots of the class do not serve.
std::uint32_t LanesSolver::run(std::span<const double> values) {
  return factors_->program() ? factors_->factorize(values, limits_).any() : every_lane();
}

std::uint32_t LanesSolver::finite_lanes(std::span<const double> values) {
  std::uint32_t finite = 0;
  for (int lane = 0; lane < lanes_; ++lane) {
    if (std::isfinite(take_lane(values, lanes_, lane, lane_values_))) finite |= 1u << lane;
  }
  return finite;
}

// Takes the first rule whose pivots keep growth within bounds in all wanted lanes, or else in most of them. Keeps the
// present pivots if the lanes have no complete set of common pivots.
void LanesSolver::choose_pivots(std::span<const double> values, std::uint32_t wanted) {
  std::shared_ptr<const Elimination> best;
  int most = -1;
  for (const PivotRule& rule : kRules) {
    if (rule.rook) continue;  // common pivots that satisfy it hardly exist
    std::pmr::memory_resource* const temporary = memory_->anew();
    const Order order = markowitz_order(*pattern_, values, lanes_, wanted, rule, temporary);
    if (!order.complete(pattern_->n)) break;
    const std::shared_ptr<Elimination> program = memory_->program();
    write_program(*pattern_, order, temporary, *program);
    factors_->set_program(program);
    const int served = std::popcount(wanted & ~factors_->factorize(values, limits_).growth);
    if (served > most) {
      most = served;
      best = factors_->program();
    }
    if ((wanted & ~order.served) == 0 && served == std::popcount(wanted)) break;
  }
  if (best && factors_->program() != best) factors_->set_program(best);
}

Status LanesSolver::rescue(std::span<const double> values, std::uint32_t alarmed) {
  std::uint32_t redone = redo(values, alarmed);
  if (redone != 0 && renewal_is_due()) {
    std::uint32_t regular = 0;
    for (int lane = 0; lane < lanes_; ++lane) {
      if (code_[static_cast<std::size_t>(lane)] == Code::ok) regular |= 1u << lane;
    }
    ++effort_.renewed;
    choose_pivots(values, regular);
    (void)redo(values, run(values));
  }
  all_served_ = std::all_of(code_.begin(), code_.end(), [](Code c) { return c == Code::ok; }) &&
                std::all_of(server_.begin(), server_.end(), [](int s) { return s < 0; });
  return worst(code_);
}

// Factorises the lanes of `alarmed` alone, and returns those that now have their own pivots; sets code_ and server_ of
// all lanes.
std::uint32_t LanesSolver::redo(std::span<const double> values, std::uint32_t alarmed) {
  std::uint32_t redone = 0;
  for (int lane = 0; lane < lanes_; ++lane) {
    Code& code = code_[static_cast<std::size_t>(lane)];
    int& server = server_[static_cast<std::size_t>(lane)];
    code = Code::ok;
    server = -1;
    if ((alarmed >> lane & 1u) == 0) continue;
    if (const int other = twin(values, lane, alarmed); other >= 0) {
      code = code_[static_cast<std::size_t>(other)];
      server = server_[static_cast<std::size_t>(other)];
      continue;
    }
    if (!std::isfinite(take_lane(values, lanes_, lane, lane_values_))) {
      code = Code::not_finite;
      continue;
    }
    auto& alone = alone_[static_cast<std::size_t>(lane)];
    if (!alone) alone = std::make_unique<LaneAlone>(pattern_, *memory_);
    code = alone->factorize(lane_values_);
    if (code != Code::ok) continue;
    server = lane;
    redone |= 1u << lane;
    ++effort_.redone;
  }
  if (redone != 0) lane_right_.resize(static_cast<std::size_t>(lanes_ * kRightSides * pattern_->n));
  return redone;
}

// A lane among the given ones and before this one whose values have the same bits; -1 if there is none. Idle lanes are
// twins of lane 0.
int LanesSolver::twin(std::span<const double> values, int lane, std::uint32_t among) const {
  const auto w = static_cast<std::size_t>(lanes_), l = static_cast<std::size_t>(lane);
  for (std::size_t other = 0; other < l; ++other) {
    if ((among >> other & 1u) == 0) continue;
    std::size_t k = 0;
    const auto bits = [&](std::size_t i) { return std::bit_cast<std::uint64_t>(values[i]); };
    while (k < values.size() && bits(k + other) == bits(k + l)) k += w;
    if (k >= values.size()) return static_cast<int>(other);
  }
  return -1;
}

// True if lanes were redone twice within kRecent factorisations, and the last renewal is patience_ factorisations ago.
// Each renewal doubles the patience; a long time without one resets it.
bool LanesSolver::renewal_is_due() {
  const bool again = count_ - last_redone_ < kRecent;
  if (last_redone_ < 0) last_renewed_ = count_ - 1;  // what came before the first one does not matter
  last_redone_ = count_;
  const std::int64_t since = count_ - last_renewed_;
  if (!again || since < patience_) return false;
  patience_ = since >= 16 * patience_ ? kRecent : std::min(2 * patience_, kMostPatience);
  last_renewed_ = count_;
  return true;
}

Status LanesSolver::solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) {
  const auto n = static_cast<std::size_t>(pattern_->n), w = static_cast<std::size_t>(lanes_);
  check_size("numbers on the right-hand side", b_to_x.size(), n * static_cast<std::size_t>(rhs) * w);
  if (first_wanted < 0 || first_wanted > pattern_->n) {
    throw Error(Error::Kind::input, "the first wanted unknown must be a number from 0 to " + std::to_string(n) +
                                        ", not " + std::to_string(first_wanted));
  }
  if (all_served_) {
    factors_->solve(b_to_x.data(), rhs, transpose, first_wanted);
    return {};
  }
  for (int done = 0; done < rhs; done += kRightSides) {
    const int some = std::min(kRightSides, rhs - done);
    const std::size_t size = n * static_cast<std::size_t>(some);
    double* const b = b_to_x.data() + static_cast<std::size_t>(done) * n * w;
    const auto own = [&](std::size_t lane) { return lane_right_.data() + lane * n * kRightSides; };
    for (std::size_t lane = 0; lane < w; ++lane) {
      for (std::size_t i = 0; server_[lane] >= 0 && i < size; ++i) own(lane)[i] = b[i * w + lane];
    }
    if (factors_->program()) factors_->solve(b, some, transpose, first_wanted);
    for (std::size_t lane = 0; lane < w; ++lane) {
      if (server_[lane] < 0) continue;
      alone_[static_cast<std::size_t>(server_[lane])]->solve(own(lane), some, transpose, first_wanted);
      for (std::size_t i = 0; i < size; ++i) b[i * w + lane] = own(lane)[i];
    }
  }
  for (int lane = 0; lane < lanes_; ++lane) {
    if (code_[static_cast<std::size_t>(lane)] != Code::ok) fill_with_nan(b_to_x, lanes_, lane);
  }
  return worst(code_);
}

Figures LanesSolver::figures(int lane) const {
  const auto l = static_cast<std::size_t>(lane);
  if (code_[l] != Code::ok) return {};
  return server_[l] < 0 ? factors_->figures(lane) : alone_[static_cast<std::size_t>(server_[l])]->figures();
}

}  // namespace

namespace {

// Null for other backends.
const LanesSolver* as_lanes(const LinearSolver& solver) {
  return typeid(solver) == typeid(LanesSolver) ? static_cast<const LanesSolver*>(&solver) : nullptr;
}

}  // namespace

std::shared_ptr<const Elimination> elimination_of(const LinearSolver& solver) {
  const LanesSolver* const of = as_lanes(solver);
  return of != nullptr && of->elimination() != nullptr ? *of->elimination() : nullptr;
}

bool eliminates_by(const LinearSolver& solver, const Elimination* elimination) {
  const LanesSolver* const of = as_lanes(solver);
  return of != nullptr && of->elimination() != nullptr && of->elimination()->get() == elimination;
}

void count_factorizations(LinearSolver& solver, std::int64_t factorizations) {
  if (as_lanes(solver) != nullptr) static_cast<LanesSolver&>(solver).count(factorizations);
}

std::string why_not(const Shape& shape, ThreadBudget budget) {
  if (budget.threads > 1) return "it runs on one thread";
  if (shape.nnz <= kMostNonzeros) return "";
  return "the program for an elimination of " + std::to_string(shape.nnz) + " nonzeros is too long; the limit is " +
         std::to_string(kMostNonzeros);
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision precision) {
  return std::make_unique<LanesSolver>(precision);
}

std::string version() {
  return std::to_string(HWY_MAJOR) + "." + std::to_string(HWY_MINOR) + "." + std::to_string(HWY_PATCH) + " " +
         instruction_set();
}

}  // namespace assur::lanes
