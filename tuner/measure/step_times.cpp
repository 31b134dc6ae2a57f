#include "measure/step_times.hpp"

#include <algorithm>
#include <utility>

#include "median.hpp"

namespace assur::measure {
namespace {

constexpr double kShort = 1e-6;        // s; shorter steps are timed in blocks
constexpr double kBlockLength = 4e-6;  // s; reading the clock, about 30 ns, takes less than 1 % of it
constexpr int kTrial = 64;             // first steps, which determine the block; longest block
constexpr int kClockCalls = 101;       // readings of the clock; their median is the cost of one

// Steps in a block: the least power of two for which blocks of such steps are long enough, at most kTrial.
int block_for(double step) {
  int block = 1;
  while (block < kTrial && block * step < kBlockLength) block *= 2;
  return block;
}

std::vector<double> joined(const std::vector<double>& samples, int block) {
  std::vector<double> sums;
  const auto length = static_cast<std::size_t>(block);
  for (std::size_t i = 0; i + length <= samples.size(); i += length) {
    double sum = 0;
    for (std::size_t k = i; k < i + length; ++k) sum += samples[k];
    sums.push_back(sum);
  }
  return sums;
}

}  // namespace

double StepTimes::steady() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

StepTimes::StepTimes(std::int64_t steps, Clock clock) : clock_(std::move(clock)), steps_(steps) {
  std::vector<double> costs;
  for (int i = 0; i < kClockCalls; ++i) {
    const double before = clock_();
    costs.push_back(clock_() - before);
  }
  cost_ = quantile(costs, 0.5);
}

void StepTimes::read() {
  const double now = clock_();
  if (started_) {
    samples_.push_back(std::max(0.0, now - last_ - cost_));
    if (block_ == 1 && samples_.size() == kTrial) consider_blocks();
  } else {
    first_ = now;
    started_ = true;
    samples_.reserve(static_cast<std::size_t>(std::max<std::int64_t>(steps_, 0)));
  }
  until_read_ = block_;
  last_ = clock_();
}

void StepTimes::consider_blocks() {
  const double median = quantile(samples_, 0.5);
  if (median >= kShort) return;
  block_ = block_for(median);
  samples_ = joined(samples_, block_);
}

StepTimes::Blocks StepTimes::blocks() const {
  if (samples_.empty()) return {};
  Blocks out{samples_, block_};
  if (const double median = quantile(samples_, 0.5); block_ == 1 && median < kShort) {
    out.steps = std::min(block_for(median), static_cast<int>(samples_.size()));
    out.seconds = joined(samples_, out.steps);
  }
  for (double& s : out.seconds) s /= out.steps;
  return out;
}

StepTimes::Figures StepTimes::figures() const {
  const Blocks all = blocks();
  if (all.seconds.empty()) return {0, 0, 0, 1};
  const double most = *std::max_element(all.seconds.begin(), all.seconds.end());
  return {quantile(all.seconds, 0.5), quantile(all.seconds, 0.99), most, all.steps};
}

}  // namespace assur::measure
