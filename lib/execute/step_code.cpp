#include "execute/step_code.hpp"

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "program/class_step.hpp"
#include "program/group_step.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostKept = 64;  // steps of each kind; one has 8 kB of code or more

// The codes that were made last.
template <class Key, class Code>
class Recent {
 public:
  [[nodiscard]] bool has(const Key& key, int lanes) const { return find(key, lanes) != entries_.end(); }
  template <class Make>
  Code of(const Key& key, int lanes, const Make& make) {
    if (const auto found = find(key, lanes); found != entries_.end()) return found->code;
    Entry made{key, lanes, make()};
    if (entries_.size() < kMostKept) return entries_.emplace_back(std::move(made)).code;
    oldest_ = (oldest_ + 1) % kMostKept;
    return (entries_[oldest_] = std::move(made)).code;
  }

 private:
  struct Entry {
    Key key;
    int lanes;
    Code code;
  };
  [[nodiscard]] auto find(const Key& key, int lanes) const {
    return std::find_if(entries_.begin(), entries_.end(),
                        [&](const Entry& e) { return e.lanes == lanes && e.key == key; });
  }

  std::vector<Entry> entries_;
  std::size_t oldest_ = kMostKept - 1;
};

class SharedCode final : public StepCode {
 public:
  explicit SharedCode(VectorCode vectors) : vectors_(vectors) {}

  [[nodiscard]] std::string vectors() const override { return vectors_ == VectorCode::avx512 ? "AVX-512" : "AVX2"; }

  CodeOfStep of(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads,
                int lanes) override {
    const std::lock_guard lock(mutex_);
    return of_groups_.of(group_class, lanes, [&] {
      const GroupProgram step = group_step(group_class, equations, reads);
      return CodeOfStep{make(step.program, lanes), step.work};
    });
  }
  CodeOfClass of(const GroupClass& group_class, const Program& equations, const lanes::Elimination& elimination,
                 std::span<const std::int32_t> reads, int lanes, bool makes) override {
    const std::lock_guard lock(mutex_);
    const std::pair key(group_class, elimination);
    if (!makes && !of_classes_.has(key, lanes)) return {};
    return of_classes_.of(key, lanes, [&]() -> CodeOfClass {
      if (!is_short(elimination, kMostInstructions)) return {};
      return {make(class_step(group_class, equations, elimination, reads), lanes),
              make(class_factors(group_class, equations, elimination), lanes),
              make(class_changes(group_class, equations, elimination), lanes)};
    });
  }
  std::shared_ptr<const Executor> of(const StepProgram& program, int lanes) override {
    const std::lock_guard lock(mutex_);
    return of_programs_.of(program, lanes, [&] { return make(program, lanes); });
  }

 private:
  [[nodiscard]] std::shared_ptr<const Executor> make(const StepProgram& program, int lanes) const {
    std::size_t instructions = 0;
    for (const Phase& phase : program.phases) instructions += phase.code.size();
    return instructions <= kMostInstructions ? make_machine_code(program, lanes, vectors_) : nullptr;
  }

  VectorCode vectors_;
  std::mutex mutex_;
  Recent<GroupClass, CodeOfStep> of_groups_;
  Recent<std::pair<GroupClass, lanes::Elimination>, CodeOfClass> of_classes_;
  Recent<StepProgram, std::shared_ptr<const Executor>> of_programs_;
};

// Tries a program with one instruction.
bool can_run(VectorCode vectors) {
  Phase phase;
  phase.code = {{Op::load, {}, {Memory::work, 0}}};
  phase.stores = {{{Memory::work, 1}, 0}};
  return make_machine_code({{phase}, {}}, 1, vectors) != nullptr;
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
