// Examines a step that cannot be divided further: it is at a limit of the motion, at a change point that can be passed,
// or at branches that are only close to each other.
#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "index.hpp"
#include "motion/continuation.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr double kShorter = 1.0 / 4;  // length of the next attempt over that of the last one; a choice
constexpr double kLeast = 0x1p-44;    // shortest attempt, as a part of the step, but not shorter than kResolvedTime
constexpr int kMostWalked = 1000;     // attempts on a part of the way to or from a change point; usually some tens
// singular value over the largest one; below it the error of a posture exceeds eps / kClear^2
constexpr double kClear = 1e-5;
constexpr double kLookedAt = 4e-6;  // singular values below it are too close to predict the least one of a crossing
constexpr double kSeen = 1e-7;      // larger least singular values are not explained by dimensions rounded to 14 digits
constexpr double kNearer = 1.15;    // ratio of singular values between postures that are compared
constexpr int kReach = 12;  // the step over a change point reaches 2^12 first shortest steps before and behind it,
constexpr int kLonger = 8;  // or up to 2^8 times as far
constexpr double kManyRoundings = 256;  // of the inputs: closer to a fold, residuals do not tell if there are solutions
constexpr double kRoomOfBranch = 4;     // for the way up to a fold
constexpr int kMoreHalvings = 6;        // halvings of the shortest step on the way back from a change point
constexpr double kApart = 1.0 / 16;  // part of that reach: least distance from the change point to the end of the step
constexpr double kLittleLever = 1e-3;  // a choice: a lever below this part of its value at the start is about to vanish

// Length of the way of a block's inputs between two postures.
double way(const Singularity& far, const Singularity& near) {
  double sum = 0;
  for (std::size_t i = 0; i < near.reads.size(); ++i) sum = std::hypot(sum, near.reads[i] - far.reads[i]);
  return sum;
}

// Near a singular posture the singular value is a parabola of the unknowns, whose way is that of the inputs over the
// value. Returns its least value, minus infinity if it falls without end.
double least_value(const Singularity& far, const Singularity& middle, const Singularity& near) {
  const double before = 2 * way(far, middle) / (far.smallest + middle.smallest),
               last = 2 * way(middle, near) / (middle.smallest + near.smallest);
  const double falls = (middle.smallest - near.smallest) / last;
  const double bend = ((far.smallest - middle.smallest) / before - falls) / (before + last);
  const double slope = falls - bend * last;
  return bend > 0 ? near.smallest - slope * slope / (4 * bend) : -kInfinity;
}

// True if the singular value of the block reaches zero ahead, by the last four postures that approached it. Close to a
// cusp, turns_back() would see this only in postures that rounding does not allow.
bool falls_to_zero(const Approach& approach, const Singularity& of) {
  const auto last = approach.last<4>(of);
  if (last[0] == nullptr) return false;
  const double before = least_value(*last[0], *last[1], *last[2]), now = least_value(*last[1], *last[2], *last[3]);
  return now == -kInfinity || now + std::abs(now - before) < 0;
}

}  // namespace

// Decides why the shortest step fails: at a limit, at a change point that can be passed, or because shorter steps are
// needed. ok: continue. The decision does not depend on the time grid: if rounding ends the search, it is left open.
Status Continuation::examine_failed_step(const Status& failed, double target, double t, double first) {
  const std::size_t at_fault = failed_pack_;
  expand();
  failed_pack_ = at_fault;
  state_.restore();
  if (deadline_passed()) return late();
  if (const Lever* const l = conditions_.little_lever(state_.at(0), kLittleLever); l != nullptr) {
    const Status gone{Code::actuator_zero, Place::driver(l->driver), state_.at(0)[l->address]};
    record_stop(gone, target);
    return gone;
  }
  any_turn_ = true;
  Pack& pack = packs_[failed_pack_];
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  levels_.solver(pack).diagnose(pack, q, diagnosis_, here_);
  Status found = here_.status;
  const double least =
      std::max(first * (kLeast / kSmallestStep), kResolvedTime * std::max(std::abs(now_), std::abs(t)));
  const bool shorter = kShorter * shortest_ >= least;
  if (found.code == Code::fold && !turns_back() && (shorter || !falls_to_zero(approach_, here_))) {
    found.code = Code::branch_unknown;
  }
  // Close to a change point, rounding would choose one of the branches.
  const bool clear = found.code != Code::change_point_passed || (found.figure > kClear && shorter);
  if (!clear && is_avoided(target - now_, first)) found.code = Code::branch_unknown;
  if (found.code != Code::fold && (clear || found.code == Code::branch_unknown) && shorter) {
    shortest_ *= kShorter;
    any_turn_ = false;
    return {};
  }
  if (found.code == Code::change_point_passed && !pass(target, t, first) && !arrive_on_change_point(t, target - now_)) {
    found.code = Code::branch_unknown;
  }
  if (found.code == Code::branch_unknown && deadline_passed()) return late();
  const bool unclear = failed.code == Code::not_converged && found.figure > 0.05;
  if (found.code == Code::branch_unknown && (failed.code == Code::not_finite || unclear)) found = failed;
  const bool passed = found.code == Code::change_point_passed;
  double from = passed ? last_before_pass_ : now_, until = passed ? now_ : target;
  if (passed && on_change_point() && std::abs(beyond_ - from) > std::abs(until - from)) until = beyond_;
  if (found.code == Code::fold) std::tie(from, until) = fold_between(target, t);
  any_turn_ = false;
  record({from, until, only_group(found.where.is(Place::Kind::group) ? found.where : failed.where), found.code,
          found.figure},
         std::abs(t - until));
  if (!passed) return found;
  shortest_ = first;
  return {};
}

// Growing rates are no evidence of a fold: they also grow before a nearly singular posture that the motion passes. At a
// fold the unknowns turn back like s* - s = y^2, and the square of the smallest singular value falls in proportion to
// the way of the inputs s: the slopes between three postures are equal. Otherwise, as for s = y^3 + e y, it falls ever
// more slowly, at least as slowly as for e = 0.
bool Continuation::turns_back() {
  approach_.drop_behind(here_);
  const Singularity* const nearest = approach_.last<1>(here_)[0];
  if (nearest != nullptr && nearest->smallest < kNearer * here_.smallest) return false;
  approach_.add(here_);
  const auto [first, middle, last] = approach_.last<3>(here_);
  if (first == nullptr) return false;
  const auto fall = [](const auto& far, const auto& near) {
    return far->smallest * far->smallest - near->smallest * near->smallest;
  };
  const auto way_of_cubic = [](const auto& far, const auto& near) {
    return std::pow(far->smallest, 1.5) - std::pow(near->smallest, 1.5);
  };
  const double falls = fall(middle, last) / fall(first, middle);
  const double slopes = falls * way(*first, *middle) / way(*middle, *last);
  const double of_cubic = falls * way_of_cubic(first, middle) / way_of_cubic(middle, last);
  const double least = std::sqrt(of_cubic);  // halfway between both
  return slopes >= least && slopes <= 1 / least;
}

// At a change point the smallest singular value is zero. Where two branches come close but do not meet, it is not zero,
// and shorter steps follow each branch. Close to its minimum the square of the value is a parabola of the way. Two
// parabolas through postures at doubled distances give the minimum and its uncertainty. The search goes no farther than
// the start of a pass, because another singularity there would spoil the parabolas.
bool Continuation::is_avoided(double h, double first) {
  const std::size_t at_fault = failed_pack_;
  const double change = beyond_ = now_;
  std::array<double, 4> way{}, square{};
  std::size_t looks = 0;
  std::int32_t block = -1;
  const double farthest = std::ldexp(first, kReach + kLonger);
  bool same = true;
  for (double back = std::abs(h); looks < way.size() && same; back *= 2) {
    same = back <= farthest && walk(change - std::copysign(back, h), h, change);
    if (!same) break;
    Pack& pack = packs_[at_fault];
    double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
    levels_.solver(pack).diagnose(pack, q, diagnosis_, here_);
    const Singularity& here = here_;
    if (here.status.figure < kLookedAt) continue;
    if (looks == 0) block = here.block;
    same = here.block == block;
    way[looks] = back;
    square[looks++] = here.status.figure * here.status.figure;
  }
  (void)walk(change, h, change);
  state_.restore();
  failed_pack_ = at_fault;
  if (!same) return false;
  // The value falls in proportion to the distance.
  const double near_value = std::sqrt(square[0]), far_value = std::sqrt(square[1]);
  const double distance = (near_value * way[1] - far_value * way[0]) / (far_value - near_value);
  if (distance > 0) beyond_ = change + std::copysign(2 * distance, h);
  const auto least = [&](std::size_t i) {  // of the parabola through three postures
    const double near = (square[i + 1] - square[i]) / (way[i + 1] - way[i]);
    const double far = (square[i + 2] - square[i + 1]) / (way[i + 2] - way[i + 1]);
    const double bend = (far - near) / (way[i + 2] - way[i]);
    const double slope = near - bend * (way[i + 1] - way[i]);
    return square[i] - slope * slope / (4 * bend);
  };
  const double nearer = least(0), farther = least(1);
  return nearer > std::abs(farther - nearer) + kSeen * kSeen;
}

// Times around a fold. Steps end a little before it, where the ball around the posture shrinks to nothing. It lies
// behind the last time at which Newton's method finds a solution on this branch, and before the first one at which it
// finds none. On the branch the unknowns turn back like s* - s = y^2. So a line predicts too large a y, from which
// Newton's method falls to the solution, and the way to it is at most twice that of the line.
std::pair<double, double> Continuation::fold_between(double target, double t) {
  const double smallest = target - now_;
  // Just behind a fold, residuals stop falling so low that Newton's method takes them for rounding.
  const double rounding_left = std::max(kConverged, 2 * last_errors_.position);
  const auto is_solved = [&](double at) {
    state_.begin_expansion(at, prediction_, 1);
    state_.predict(prediction_, 0, state_.unknowns());
    const double farthest = kRoomOfBranch * std::abs(at - now_) * state_.speed();
    for (double before = kInfinity;;) {
      StepErrors errors;
      if (!solve_at(at, Attempt::Branch::anywhere, errors).ok() || !(state_.move() <= farthest)) return false;
      if (errors.position <= rounding_left) return true;
      if (falls_slowly(errors.position, before)) return false;
      before = errors.position;
    }
  };
  double from = now_, until = target;
  bool ends = false;
  for (int k = 0; k <= kStepHalvings && !ends; ++k) {
    const double h = std::ldexp(smallest, k);
    until = std::abs(t - now_) <= std::abs(h) ? t : now_ + h;
    ends = !is_solved(until);
  }
  if (deadline_passed()) until = t;
  const double rounding =
      std::max(kResolvedTime * std::max(std::abs(now_), std::abs(until)), kManyRoundings * state_.time_of_rounding());
  while (ends && settings_.iterations == 0 && std::abs(until - from) > rounding) {
    const double middle = from + (until - from) / 2;
    const bool solved = is_solved(middle);
    if (deadline_passed()) break;
    (solved ? from : until) = middle;
  }
  state_.restore();
  const double room = std::copysign(rounding, smallest);
  from = std::abs(from - now_) <= rounding ? now_ : from - room;
  return {from, std::abs(t - until) <= rounding ? t : until + room};
}

// Passes a change point by the smooth continuation. At a distance d from it a posture is uncertain by eps / d and its
// rates by eps / d^2, so the step starts well before it and ends as far behind it, where the branches differ by more
// than any error. The prediction does not depend on the strategy: it is a cubic through postures on the way back. Other
// packs may be at change points of their own at the same time.
bool Continuation::pass(double target, double t, double first) {
  const std::size_t failed = failed_pack_;
  for (int longer = 0; longer <= kLonger; longer += kLonger / 2) {
    const double reach = std::copysign(std::ldexp(first, kReach + longer), target - now_);
    const double to = std::abs(t - now_) <= std::abs(reach) ? t : now_ + reach;
    if (pass_by(reach, target - now_, to)) return true;
    failed_pack_ = failed;
  }
  return false;
}

bool Continuation::pass_by(double reach, double smallest, double to) {
  last_before_pass_ = now_;
  const std::size_t at_its_change_point = failed_pack_;
  const double change = now_;
  bool passed = false, walked = std::abs(to - change) >= kApart * std::abs(reach);
  history_.count = 0;
  for (const double part : {1.0 / 4, 2.0 / 4, 3.0 / 4, 1.0}) {
    walked = walked && walk(change - part * reach, smallest, change);
    if (walked) state_.save_history(history_);
  }
  if (walked) {
    over_ = &history_;
    passing_[at_its_change_point] = 1;
    largest_correction_ = WalkRules::kSureOfBranch * (to - change) / (to - now_);
    for (std::size_t more = 0; more < packs_.size() && !passed; ++more) {
      passed = try_step(to, Attempt::Branch::inside).ok();
      // failed_pack_ is packs_.size() if no pack failed.
      if (failed_pack_ == packs_.size() || passing_[failed_pack_] != 0) break;
      passing_[failed_pack_] = 1;
    }
    passed_ = passing_;
    std::fill(passing_.begin(), passing_.end(), 0);
    over_ = nullptr;
  }
  if (!passed) {
    (void)walk(change, smallest, change);
    state_.restore();
  }
  return passed;
}

// Moves to `until` in steps of about h. Away from the change point, predictions do not use older postures, which are
// closer to it.
bool Continuation::walk(double until, double h, double change) {
  h = std::abs(h);
  const double shortest = std::ldexp(h, -kMoreHalvings);
  for (int attempts = 0; now_ != until; ++attempts) {
    if (attempts == kMostWalked || rejected_ >= kMostRejected) return false;
    if (std::abs(now_ - change) < std::abs(until - change)) state_.forget();
    const double left = until - now_;
    if (try_step(std::abs(left) <= h ? until : now_ + std::copysign(h, left), Attempt::Branch::inside).ok()) {
      h *= 2;
    } else if ((h /= 2) < shortest) {
      return false;
    }
  }
  return true;
}

}  // namespace assur
