#include "executors/step_code.hpp"

#include <algorithm>
#include <mutex>
#include <optional>
#include <tuple>
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
  // key: parts of a Key. make(): none if there is no time for it
  template <class Make, class... Parts>
  Code of(int lanes, const Make& make, const Parts&... key) {
    const auto found = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const KeptCode& e) { return e.lanes == lanes && e.key == std::tie(key...); });
    if (found != entries_.end()) return found->code;
    std::optional<Code> code = make();
    if (!code) return {};
    KeptCode made{Key(key...), lanes, std::move(*code)};
    if (entries_.size() < kMostKept) return entries_.emplace_back(std::move(made)).code;
    oldest_ = (oldest_ + 1) % kMostKept;
    return (entries_[oldest_] = std::move(made)).code;
  }

 private:
  struct KeptCode {
    Key key;
    int lanes;
    Code code;
  };
  std::vector<KeptCode> entries_;
  std::size_t oldest_ = kMostKept - 1;
};

// All codes of a process.
struct Codes {
  explicit Codes(VectorCode its_vectors) : vectors(its_vectors) {}

  const VectorCode vectors;
  std::mutex mutex;
  Recent<std::tuple<GroupClass>, CodeOfStep> of_groups;
  Recent<std::tuple<GroupClass, lanes::Elimination>, CodeOfClass> of_classes;
  Recent<std::tuple<StepProgram>, std::shared_ptr<const Executor>> of_programs;
};

// Their user, which may make some more.
class SharedCode final : public StepCode {
 public:
  explicit SharedCode(Codes& all) : all_(all) {}

  [[nodiscard]] std::string vectors() const override { return all_.vectors == VectorCode::avx512 ? "AVX-512" : "AVX2"; }

  CodeOfStep of(const GroupClass& group_class, std::span<const std::int32_t> reads, int lanes) override {
    const std::lock_guard lock(all_.mutex);
    const auto write = [&]() -> std::optional<CodeOfStep> {
      if (left_ == 0) return std::nullopt;
      const GroupProgram step = group_step(group_class, reads);
      auto executor = make(step.program, lanes);
      if (!executor) return std::nullopt;
      return CodeOfStep{std::move(*executor), step.work};
    };
    return all_.of_groups.of(lanes, write, group_class);
  }
  CodeOfClass of(const GroupClass& group_class, const lanes::Elimination& elimination,
                 std::span<const std::int32_t> reads, int lanes, bool makes) override {
    const std::lock_guard lock(all_.mutex);
    const auto write = [&]() -> std::optional<CodeOfClass> {
      if (!makes || left_ == 0) return std::nullopt;
      if (!is_short(elimination, kMostInstructions)) return CodeOfClass{};
      auto step = make(class_step(group_class, elimination, reads), lanes);
      if (!step) return std::nullopt;
      if (!*step) return CodeOfClass{};
      std::optional<std::shared_ptr<const Executor>> anchor;
      if (group_class.quadratic()) anchor = make(class_anchor(group_class, elimination, reads), lanes);
      auto factors = make(class_factors(group_class, elimination), lanes);
      auto changes = make(class_changes(group_class, elimination), lanes);
      return CodeOfClass{std::move(*step), anchor.value_or(nullptr), factors.value_or(nullptr),
                         changes.value_or(nullptr)};
    };
    return all_.of_classes.of(lanes, write, group_class, elimination);
  }
  std::shared_ptr<const Executor> of(const StepProgram& program, int lanes) override {
    const std::lock_guard lock(all_.mutex);
    return all_.of_programs.of(
        lanes, [&] { return make(program, lanes); }, program);
  }

 private:
  // None if it does not fit into what is left; null if it can have no code.
  [[nodiscard]] std::optional<std::shared_ptr<const Executor>> make(const StepProgram& program, int lanes) {
    std::size_t instructions = 0;
    for (const Phase& phase : program.phases) instructions += phase.code.size();
    if (instructions > kMostInstructions) return nullptr;
    if (instructions > left_) {
      left_ = 0;
      return std::nullopt;
    }
    left_ -= instructions;
    return make_machine_code(program, lanes, all_.vectors);
  }

  Codes& all_;
  std::size_t left_ = kMostOfAll;  // instructions
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
  static const std::unique_ptr<Codes> all = [] {
    std::unique_ptr<Codes> out;
    for (const VectorCode vectors : {VectorCode::avx512, VectorCode::avx2}) {
      if (!out && can_run(vectors)) out = std::make_unique<Codes>(vectors);
    }
    return out;
  }();
  return all ? std::make_shared<SharedCode>(*all) : nullptr;
}

}  // namespace assur
