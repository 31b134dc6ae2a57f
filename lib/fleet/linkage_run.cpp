#include "fleet/linkage_run.hpp"

#include <algorithm>
#include <cmath>

#include "numbers.hpp"

namespace assur {
namespace {

// Intervals are divided at most so often: to 1e-9 of an interval between two times.
constexpr std::size_t kDeepest = 10;
// From here on, the time of a limit is found by the cubic through both ends of an interval.
constexpr std::size_t kSmooth = 2;
constexpr double kTimeTolerance = 1e-10;  // of a limit, relative to the interval between two times
// Speed of the link of a triad, relative to those of its parents, from which on it is folded: at 1e-9 of an interval
// from the limit, it is 1e4 times as fast as usual.
constexpr double kFolded = 300;
// Next to a limit, doubtful intervals shorter than this part of the interval with the limit are not divided: rounding
// looks like doubt there.
constexpr double kCloseToLimit = 1e-4;

// The zero in [0, 1] of the cubic with these values and slopes at 0 and 1; values have different signs.
double zero_of_cubic(double from, double from_slope, double to, double to_slope) {
  const auto value = [&](double u) {
    const double v = 1 - u;
    return v * v * ((1 + 2 * u) * from + u * from_slope) + u * u * ((1 + 2 * v) * to - v * to_slope);
  };
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    ((value(middle) > 0) == (from > 0) ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

LinkageRun::LinkageRun() : blocks_(kDeepest + 2) {}

LinkageRun::Block& LinkageRun::block(std::size_t level) {
  Block& block = blocks_[level];
  if (block.joints.size() < linkage_->joints().size()) block.joints.resize(linkage_->joints().size());
  return block;
}

// Sets what is known of the time before a block: time i of a block, or (-1) the time before that.
void LinkageRun::set_before(Block& block, const Block& from, int i) const {
  const auto place = static_cast<std::size_t>(static_cast<int>(kTimes) + i);
  for (std::size_t j = 0; j < linkage_->joints().size(); ++j) {
    block.joints[j].square[JointBlock::kBefore] = from.joints[j].square[place];
    block.joints[j].rate[JointBlock::kBefore] = from.joints[j].rate[place];
    block.joints[j].sensitivity[JointBlock::kBefore] = from.joints[j].sensitivity[place];
  }
}

// start: the time before the block, at which squares and rates are in their places.
void LinkageRun::evaluate(Block& block, double start) {
  for (std::size_t i = 0; i < kTimes; ++i) block.steps[i] = block.times[i] - (i > 0 ? block.times[i - 1] : start);
  block.figures =
      linkage_kernels().evaluate(linkage_->joints(), block.times.data(), block.steps.data(), block.joints.data());
  motion_.residual = std::max(motion_.residual, block.figures.residual);
}

void LinkageRun::end(Code code, double reached, double not_beyond, std::int32_t joint) {
  motion_.status = {code, {}, reached};
  motion_.reached = reached;
  motion_.not_beyond = not_beyond;
  motion_.joint = joint;
}

// Passes all intervals of a block, and takes the rows of the run; false if the motion ends within one.
bool LinkageRun::pass(std::size_t level) {
  Block& block = blocks_[level];
  block.doubtful = linkage_kernels().doubtful(linkage_->joints(), block.steps.data(), block.joints.data());
  for (unsigned i = 0; i < kTimes; ++i) {
    const bool ends = i == block.figures.closed, divides = ends || (block.doubtful >> i & 1) != 0;
    if (divides && !pass_interval(level, i)) return false;
    if (divides && linkage_->has_triads()) go_on_from(level, i);
    if (level == 0) write_row(block, i);
    if (ends && i == block.figures.closed) {  // Rounding: closed at the end of the interval when it was divided.
      end(Code::branch_unknown, block.times[i], block.times[i], block.figures.joint);
      return false;
    }
  }
  return true;
}

// The block was solved from the posture before it, which may have led a triad to another posture than that at which its
// divided interval ends: solves the times after i again, from there.
void LinkageRun::go_on_from(std::size_t level, unsigned i) {
  Block& block = blocks_[level];
  std::fill_n(block.times.begin(), i, block.times[i]);
  set_before(block, blocks_[level + 1], static_cast<int>(kTimes) - 1);
  evaluate(block, block.times[i]);
  block.doubtful = linkage_kernels().doubtful(linkage_->joints(), block.steps.data(), block.joints.data());
}

// Divides the interval that ends at time i of a block by eight.
bool LinkageRun::pass_interval(std::size_t level, unsigned i) {
  ++divided_;
  Block& inner = this->block(level + 1);
  const Block& outer = blocks_[level];
  const double to = outer.times[i], from = to - outer.steps[i];
  const bool ends = i == outer.figures.closed;
  if (level + 1 > kDeepest || !(from < to)) {
    if (const std::int32_t triad = folded_triad(outer, i); triad >= 0) {
      end(Code::fold, from, to, triad);
      return false;
    }
    end(ends ? Code::fold : Code::branch_unknown, from, to, ends ? outer.figures.joint : -1);
    return false;
  }
  if (ends && level >= kSmooth && !linkage_->has_triads()) {
    follow_to_limit(level, i);
    return false;
  }
  set_before(inner, outer, static_cast<int>(i) - 1);
  for (std::size_t k = 0; k < kTimes; ++k) {
    inner.times[k] = from + (to - from) * static_cast<double>(k + 1) / kTimes;
  }
  inner.times[kTimes - 1] = to;
  evaluate(inner, from);
  return pass(level + 1);
}

// Finds the time at which the motion ends within an interval, so short that the squared distance of the parents is
// close to a cubic there.
void LinkageRun::follow_to_limit(std::size_t level, unsigned i) {
  Block& inner = blocks_[level + 1];
  const Block& outer = blocks_[level];
  double to = outer.times[i], from = to - outer.steps[i];
  const double whole = to - from;
  std::int32_t joint = outer.figures.joint;
  struct End {
    double square, rate;
  };
  const auto at = [&](const Block& block, std::size_t place) {
    const JointBlock& of = block.joints[static_cast<std::size_t>(joint)];
    return End{of.square[place], of.rate[place]};
  };
  set_before(inner, outer, static_cast<int>(i) - 1);
  End after = at(outer, kTimes + i);
  for (int tries = 0; tries < 50 && to - from > std::max(tolerance_, 4 * kEps * std::abs(to)); ++tries) {
    const PreparedJoint& dyad = linkage_->joints()[static_cast<std::size_t>(joint)];
    const End before = at(inner, JointBlock::kBefore);
    const double limit = after.square <= dyad.least ? dyad.least : dyad.most, width = to - from;
    double u = zero_of_cubic(before.square - limit, before.rate * width, after.square - limit, after.rate * width);
    if (tries % 3 == 2 || !std::isfinite(u)) u = 0.5;
    // Times that come close to the zero from both sides.
    constexpr std::array<double, kTimes - 1> kOff = {-1e-2, -1e-5, -1e-8, -1e-11, 1e-11, 1e-8, 1e-5};
    for (std::size_t k = 0; k + 1 < kTimes; ++k) inner.times[k] = from + width * std::clamp(u + kOff[k], 0.0, 1.0);
    inner.times[kTimes - 1] = to;
    evaluate(inner, from);
    const unsigned closed = inner.figures.closed;
    const unsigned doubts = linkage_kernels().doubtful(linkage_->joints(), inner.steps.data(), inner.joints.data());
    for (unsigned k = 0; k < closed; ++k) {
      const bool doubtful = (doubts >> k & 1) != 0 && inner.steps[k] > kCloseToLimit * whole;
      if (doubtful && !pass_interval(level + 1, k)) return;
    }
    if (closed == kTimes) break;  // rounding at the end of the interval
    joint = inner.figures.joint;
    to = inner.times[closed];
    after = at(inner, kTimes + closed);
    if (closed == 0) continue;
    from = inner.times[closed - 1];
    set_before(inner, inner, static_cast<int>(closed) - 1);
  }
  // With a constant second derivative, the squared distance would turn around after this excess. False for NaN.
  const double rate = at(inner, JointBlock::kBefore).rate;
  const double curvature = std::abs(at(outer, kTimes + i).rate - at(outer, JointBlock::kBefore + i).rate) / whole;
  const double excess = rate * rate / (2 * curvature);
  const bool touches = excess <= kTouches * linkage_->joints()[static_cast<std::size_t>(joint)].most;
  end(touches ? Code::branch_unknown : Code::fold, from, to, joint);
}

// Where two postures of a triad meet and end, its rates grow beyond all bounds; where two motions cross, they do not.
// Returns the first joint of a triad that is so fast before time i; -1: there is none.
std::int32_t LinkageRun::folded_triad(const Block& block, unsigned i) const {
  const std::span<const PreparedJoint> joints = linkage_->joints();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].kind != LinkageJoint::Kind::triad || joints[j].place != 0) continue;
    double squares = 0, of_parents = 0;
    for (std::size_t k = 0; k < kJointsOfTriad; ++k) {
      const double rate = block.joints[j + k].rate[JointBlock::kBefore + i];
      const JointBlock& parent = block.joints[joints[j + k].first];
      squares += rate * rate;
      of_parents += std::abs(parent.vx[i]) + std::abs(parent.vy[i]);
    }
    if (squares > kFolded * kFolded * of_parents * of_parents) return static_cast<std::int32_t>(j);
  }
  return -1;
}

// Solves the triads at the first time, eight times over, for the rates from which all times begin.
void LinkageRun::begin_triads(Block& block) {
  const std::array<double, kTimes> times = block.times;
  block.times.fill(times[0]);
  begin_at_guess(linkage_->joints(), block.joints.data());
  evaluate(block, times[0]);
  set_before(block, block, 0);
  block.times = times;
}

void LinkageRun::cannot_begin(const Block& block) {
  const auto joint = static_cast<std::size_t>(block.figures.joint);
  if (linkage_->joints()[joint].kind == LinkageJoint::Kind::triad) {
    end(Code::not_assembled, kNan, block.times[0], block.figures.joint);
    return;
  }
  const PreparedJoint& dyad = linkage_->joints()[joint];
  const double square = block.joints[joint].square[kTimes];
  const double beyond = std::max(dyad.least - square, square - dyad.most);
  end(beyond <= kTouches * dyad.most ? Code::singular : Code::not_assembled, kNan, block.times[0], block.figures.joint);
}

// Takes a row, unless all are taken.
void LinkageRun::write_row(const Block& block, unsigned i) {
  if (path_.size() == rows_) return;
  const JointBlock& traced = block.joints[linkage_->traced()];
  path_.push_back({traced.x[i], traced.y[i]});
  largest_ = std::max({largest_, std::abs(traced.x[i]), std::abs(traced.y[i])});
  const double error = std::max(std::abs(traced.error_x[i]), std::abs(traced.error_y[i]));
  if (!(error <= error_)) error_ = error;  // NaN, too
}

void LinkageRun::check_error(double accuracy) {
  motion_.path = path_;
  motion_.error = path_.empty() ? kNan : error_ / std::max(largest_, linkage_->mean_length());
  if (!motion_.status.ok()) return;
  if (!std::isfinite(motion_.error)) {
    motion_.status = {Code::not_finite, {}, 0};
    return;
  }
  // Far from the origin, lengths lose digits that positions have.
  const double worst = std::max(motion_.residual, motion_.error);
  if (worst > accuracy) motion_.status = {Code::inaccurate, {}, worst};
}

const LinkageMotion& LinkageRun::run(const PreparedLinkage& linkage, std::span<const double> times,
                                     const FleetOptions& options) {
  linkage_ = &linkage;
  motion_ = {};
  motion_.not_beyond = kNan;
  path_.clear();
  error_ = largest_ = 0;
  const std::size_t rows = rows_ = times.size();
  for (std::size_t begin = 0; begin < rows; begin += kTimes) {
    Block& now = block(0);
    const std::size_t count = std::min(kTimes, rows - begin);
    for (std::size_t i = 0; i < kTimes; ++i) now.times[i] = times[begin + std::min(i, count - 1)];
    const double start = begin > 0 ? times[begin - 1] : times[0];
    tolerance_ = kTimeTolerance * (now.times[kTimes - 1] - start) / static_cast<double>(count);
    if (begin > 0) set_before(now, now, static_cast<int>(kTimes) - 1);
    if (begin == 0 && linkage.has_triads()) begin_triads(now);
    if (begin > 0 || !linkage.has_triads() || now.figures.closed > 0) evaluate(now, start);
    if (begin == 0) set_before(now, now, 0);
    if (begin == 0 && now.figures.closed == 0) {
      cannot_begin(now);
      break;
    }
    if (!pass(0)) break;
    motion_.reached = times[begin + count - 1];
  }
  check_error(options.accuracy);
  return motion_;
}

}  // namespace assur
