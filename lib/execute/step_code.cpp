#include "execute/step_code.hpp"

#include <mutex>
#include <utility>
#include <vector>

#include "program/group_step.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostKept = 64;             // steps; each has about 8 kB of code
constexpr std::size_t kMostInstructions = 4'000;  // of a step; each takes about 0.5 us to write

class SharedCode final : public StepCode {
 public:
  explicit SharedCode(VectorCode vectors) : vectors_(vectors) {}

  [[nodiscard]] std::string vectors() const override { return vectors_ == VectorCode::avx512 ? "AVX-512" : "AVX2"; }

  CodeOfStep of(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads,
                int lanes) override {
    const std::lock_guard lock(mutex_);
    for (const Entry& e : entries_) {
      if (e.lanes == lanes && e.group_class == group_class) return e.code;
    }
    const GroupProgram step = group_step(group_class, equations, reads);
    std::size_t instructions = 0;
    for (const Phase& phase : step.program.phases) instructions += phase.code.size();
    Entry made{group_class, lanes, {nullptr, step.work}};
    if (instructions <= kMostInstructions) made.code.executor = make_machine_code(step.program, lanes, vectors_);
    if (entries_.size() < kMostKept) {
      return entries_.emplace_back(std::move(made)).code;
    }
    oldest_ = (oldest_ + 1) % kMostKept;
    return (entries_[oldest_] = std::move(made)).code;
  }

 private:
  struct Entry {
    GroupClass group_class;
    int lanes;
    CodeOfStep code;
  };
  VectorCode vectors_;
  std::mutex mutex_;
  std::vector<Entry> entries_;
  std::size_t oldest_ = kMostKept - 1;
};

// Tries a program with one instruction.
bool can_run(VectorCode vectors) {
  Phase phase;
  phase.code = {{Op::load, {}, {Memory::work, 0}}};
  phase.stores = {{{Memory::work, 1}, 0}};
  return make_machine_code({{phase}}, 1, vectors) != nullptr;
}

}  // namespace

std::shared_ptr<StepCode> step_code() {
  static const std::shared_ptr<StepCode> shared = [] {
    std::shared_ptr<StepCode> out;
    for (const VectorCode vectors : {VectorCode::avx512, VectorCode::avx2}) {
      if (!out && can_run(vectors)) out = std::make_shared<SharedCode>(vectors);
    }
    return out;
  }();
  return shared;
}

}  // namespace assur
