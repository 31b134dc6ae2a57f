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
  }
}

// start: the time before the block, at which squares and rates are in their places.
void LinkageRun::evaluate(Block& block, double start) {
  for (std::size_t i = 0; i < kTimes; ++i) block.steps[i] = block.times[i] - (i > 0 ? block.times[i - 1] : start);
  block.figures = dyad_kernels().evaluate(linkage_->joints(), block.times.data(), block.joints.data());
  motion_.residual = std::max(motion_.residual, block.figures.residual);
}

void LinkageRun::end(Code code, double reached, double not_beyond, std::int32_t joint) {
  motion_.status = {code, {}, reached};
  motion_.reached = reached;
  motion_.not_beyond = not_beyond;
  motion_.joint = joint;
}

// Passes all intervals of a block; false if the motion ends within one.
bool LinkageRun::pass(std::size_t level) {
  Block& block = blocks_[level];
  block.doubtful = dyad_kernels().doubtful(linkage_->joints(), block.steps.data(), block.joints.data());
  for (unsigned i = 0; i < kTimes; ++i) {
    const bool ends = i == block.figures.closed;
    if (!ends && (block.doubtful >> i & 1) == 0) continue;
    if (!pass_interval(level, i)) return false;
    if (ends) {  // Rounding: closed at the end of the interval when it was divided.
      end(Code::branch_unknown, block.times[i], block.times[i], block.figures.joint);
      return false;
    }
  }
  return true;
}

// Divides the interval that ends at time i of a block by eight.
bool LinkageRun::pass_interval(std::size_t level, unsigned i) {
  ++divided_;
  Block& inner = this->block(level + 1);
  const Block& outer = blocks_[level];
  const double to = outer.times[i], from = to - outer.steps[i];
  const bool ends = i == outer.figures.closed;
  if (level + 1 > kDeepest || !(from < to)) {
    end(ends ? Code::limit_reached : Code::branch_unknown, from, to, ends ? outer.figures.joint : -1);
    return false;
  }
  if (ends && level >= kSmooth) {
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
    const unsigned doubts = dyad_kernels().doubtful(linkage_->joints(), inner.steps.data(), inner.joints.data());
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
  end(touches ? Code::branch_unknown : Code::limit_reached, from, to, joint);
}

void LinkageRun::cannot_begin(const Block& block) {
  const auto joint = static_cast<std::size_t>(block.figures.joint);
  const PreparedJoint& dyad = linkage_->joints()[joint];
  const double square = block.joints[joint].square[kTimes];
  const double beyond = std::max(dyad.least - square, square - dyad.most);
  end(beyond <= kTouches * dyad.most ? Code::singular : Code::not_converged, kNan, block.times[0], block.figures.joint);
}

void LinkageRun::take(const Block& block, std::size_t rows) {
  const JointBlock& traced = block.joints[linkage_->traced()];
  for (std::size_t i = 0; i < rows; ++i) {
    path_.push_back({traced.x[i], traced.y[i]});
    largest_ = std::max({largest_, std::abs(traced.x[i]), std::abs(traced.y[i])});
    const double error = std::max(std::abs(traced.error_x[i]), std::abs(traced.error_y[i]));
    if (!(error <= error_)) error_ = error;  // NaN, too
  }
}

void LinkageRun::judge(double accuracy) {
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
  const std::size_t rows = times.size();
  for (std::size_t begin = 0; begin < rows; begin += kTimes) {
    Block& now = block(0);
    const std::size_t count = std::min(kTimes, rows - begin);
    for (std::size_t i = 0; i < kTimes; ++i) now.times[i] = times[begin + std::min(i, count - 1)];
    const double start = begin > 0 ? times[begin - 1] : times[0];
    tolerance_ = kTimeTolerance * (now.times[kTimes - 1] - start) / static_cast<double>(count);
    if (begin > 0) set_before(now, now, static_cast<int>(kTimes) - 1);
    evaluate(now, start);
    if (begin == 0) set_before(now, now, 0);
    if (begin == 0 && now.figures.closed == 0) {
      cannot_begin(now);
      break;
    }
    const bool passed = pass(0);
    const Block& at = blocks_[0];
    std::size_t taken = count;
    if (!passed) {
      taken = 0;
      while (taken < count && at.times[taken] <= motion_.reached) ++taken;
    }
    take(at, taken);
    if (!passed) break;
    motion_.reached = times[begin + count - 1];
  }
  judge(options.accuracy);
  return motion_;
}

}  // namespace assur
