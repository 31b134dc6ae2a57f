#include "outputs/output_steps.hpp"

#include <algorithm>
#include <utility>

#include "index.hpp"
#include "numbers.hpp"
#include "outputs/angle_kernels.hpp"

namespace assur {
namespace {

// Measurements, after which machine code for changes has been worth its 0.5 ms: it saves 3 us each time.
constexpr int kWorthCode = 200;

}  // namespace

template <class Make>
void OutputSteps::make(Numbers numbers, const Make& executor) {
  const OutputProgram& first = outputs_[0];
  const std::size_t w = outputs_.size(), angles = first.angles().size();
  has_others_ = first.has_others();
  if (first.operations() == 0 || first.operations() > kMostInstructions) return;
  values_ = executor(first.output_step(numbers));
  if (angles > 0) arms_ = executor(first.arm_step(numbers, padded(angles * w) / w));
}

std::unique_ptr<OutputSteps> OutputSteps::of_one(const OutputProgram& outputs, StepCode& code) {
  std::unique_ptr<OutputSteps> out(new OutputSteps(outputs));
  out->make(Numbers::constants, [&](const StepProgram& program) { return code.of(program, 1); });
  out->numbers_ = {0};
  return out->values_ ? std::move(out) : nullptr;
}

OutputSteps::OutputSteps(std::span<const OutputProgram> outputs, std::shared_ptr<StepCode> code)
    : outputs_(outputs), code_(std::move(code)) {
  row_.resize(outputs[0].columns());
  turns_.resize(outputs[0].angles().size());
  divisors_.resize(outputs[0].measures());
  make(Numbers::loads, [&](const StepProgram& program) -> std::shared_ptr<const Executor> {
    const auto w = static_cast<int>(outputs.size());
    std::shared_ptr<const Executor> by_code = code_ ? code_->of(program, w) : nullptr;
    return by_code ? by_code : make_interpreter(program, w);
  });
}

void OutputSteps::bind(std::size_t used, News news) {
  if (news == News::all || !is_alike_ || used > compared_) {
    is_alike_ = std::all_of(outputs_.begin(), outputs_.begin() + static_cast<std::ptrdiff_t>(used),
                            [this](const OutputProgram& p) { return p.same_shape(outputs_[0]); });
    compared_ = used;
  }
  const bool are_same = std::exchange(used_, used) == used && news == News::none;
  if (!is_alike_) return;
  if (changed_ >= kWorthCode && code_) {
    if (auto by_code = code_->of(outputs_[0].change_step(), static_cast<int>(outputs_.size()))) {
      changes_ = std::move(by_code);
    }
    code_ = nullptr;
  }
  if (are_same) return;
  const std::size_t w = outputs_.size();
  numbers_.resize(outputs_[0].numbers() * w);
  for (std::size_t lane = 0; lane < w; ++lane) {
    double* to = numbers_.data() + lane;
    outputs_[lane < used ? lane : 0].each_number([&](double number) { *to = number, to += w; });
  }
}

// The programs write to none of these.
std::array<double*, kMemories> OutputSteps::memory(const double* q) const {
  std::array<double*, kMemories> memory;
  memory[static_cast<std::size_t>(Memory::factors)] = const_cast<double*>(numbers_.data());
  memory[static_cast<std::size_t>(Memory::state)] = const_cast<double*>(q);
  return memory;
}

bool OutputSteps::arms(const double* q, double* vectors) const {
  if (!arms_ || !is_alike_) return false;
  auto all = memory(q);
  all[static_cast<std::size_t>(Memory::work)] = vectors;
  arms_->run(all);
  return true;
}

void OutputSteps::evaluate(const double* const (&state)[3], double* out, const double* turns, double* divisors) {
  if (!by_program()) return evaluate_one_by_one(state, out, turns, divisors);
  auto all = memory(state[0]);
  const auto give = [&](Memory m, const double* at) { all[static_cast<std::size_t>(m)] = const_cast<double*>(at); };
  give(Memory::state_rates, state[1]);
  give(Memory::state_accelerations, state[2]);
  give(Memory::settings, turns);
  give(Memory::figures, divisors);
  give(Memory::outputs, out);
  values_->run(all);
  for (std::size_t lane = 0; lane < used_ && has_others_; ++lane) {
    outputs_[lane].evaluate_others({state[0] + lane, state[1] + lane, state[2] + lane}, out + lane, divisors + lane,
                                   outputs_.size());
  }
}

void OutputSteps::differentiate(const double* const (&state)[3], const double* const (&change)[3], RandomSign* sign,
                                double* out) {
  const std::size_t w = outputs_.size();
  if (by_program()) {
    if (!changes_) {
      changes_ = make_interpreter(outputs_[0].change_step(), static_cast<int>(w));
      roundings_.resize(outputs_[0].roundings() * w);
    }
    ++changed_;
    for (double& rounding : roundings_) rounding = sign != nullptr ? (*sign)() * kEps : 0;
    auto all = memory(state[0]);
    const auto give = [&](Memory m, const double* at) { all[static_cast<std::size_t>(m)] = const_cast<double*>(at); };
    give(Memory::state_rates, state[1]);
    give(Memory::state_accelerations, state[2]);
    for (std::size_t d = 0; d < 3; ++d)
      all[static_cast<std::size_t>(Memory::past) + d] = const_cast<double*>(change[d]);
    give(Memory::work, roundings_.data());
    give(Memory::outputs, out);
    changes_->run(all);
  }
  for (std::size_t lane = 0; lane < used_; ++lane) {
    const OutputProgram& one = outputs_[lane];
    const double* const at[3] = {state[0] + lane, state[1] + lane, state[2] + lane};
    const double* const by[3] = {change[0] + lane, change[1] + lane, change[2] + lane};
    if (by_program()) {
      one.differentiate_others(at, by, sign, out + lane, w);
      for (std::size_t c = 0; c < row_.size(); ++c) row_[c] = out[c * w + lane];
      one.add_up_changes(row_.data());
    } else {
      one.differentiate(at, by, sign, row_.data());
    }
    for (std::size_t c = 0; c < row_.size(); ++c) out[c * w + lane] = row_[c];
  }
}

void OutputSteps::evaluate_one_by_one(const double* const (&state)[3], double* out, const double* turns,
                                      double* divisors) {
  const std::size_t w = outputs_.size();
  for (std::size_t lane = 0; lane < used_; ++lane) {
    for (std::size_t i = 0; i < turns_.size(); ++i) turns_[i] = turns[i * w + lane];
    outputs_[lane].evaluate({state[0] + lane, state[1] + lane, state[2] + lane}, row_.data(), turns_.data(),
                            divisors_.data());
    for (std::size_t c = 0; c < row_.size(); ++c) out[c * w + lane] = row_[c];
    for (std::size_t i = 0; i < divisors_.size(); ++i) divisors[i * w + lane] = divisors_[i];
  }
}

}  // namespace assur
