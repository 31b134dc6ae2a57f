#include <asmjit/x86.h>
#include <hwy/targets.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <span>
#include <utility>
#include <vector>

#include "executors/executor.hpp"
#include "executors/uses.hpp"

namespace assur {
namespace {

namespace x86 = asmjit::x86;
namespace Inst = asmjit::x86::Inst;

using Function = void (*)(double* const*);  // memory

// Memory for code: written first, then executable, and never both.
class Code {
 public:
  Code() = default;
  Code(const Code&) = delete;
  Code& operator=(const Code&) = delete;
  ~Code() {
    if (at_ != nullptr) ::munmap(at_, size_);
  }

  // False if the system refuses.
  [[nodiscard]] bool take(asmjit::CodeHolder& code, ProtectCode protect) {
    if (code.flatten() != asmjit::kErrorOk || code.resolveUnresolvedLinks() != asmjit::kErrorOk) return false;
    size_ = code.codeSize();
    void* const at = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) return false;
    at_ = at;
    return code.relocateToBase(reinterpret_cast<std::uintptr_t>(at)) == asmjit::kErrorOk &&
           code.copyFlattenedData(at, size_) == asmjit::kErrorOk && protect(at, size_);
  }
  [[nodiscard]] Function function() const { return reinterpret_cast<Function>(at_); }

 private:
  void* at_ = nullptr;
  std::size_t size_ = 0;
};

// Writes one function for all phases, each for one vector of its lanes after the other, or in a loop. A value that is
// loaded or constant is read where it is used. If registers run out, the value with the farthest next use leaves its
// register (Belady, IBM Systems Journal 5, 1966), and is written to the stack unless it can be read again elsewhere.
class MachineCodeWriter {
 public:
  // lanes: of phases that do not say it
  MachineCodeWriter(int lanes, bool avx512, asmjit::CodeHolder& code)
      : usual_lanes_(lanes), avx512_(avx512), a_(&code), value_in_(avx512 ? 32 : 16, kFree) {}

  // False if an operation is unknown.
  [[nodiscard]] bool write(const StepProgram& program) {
    constants_at_ = a_.newLabel();
    a_.push(x86::rbp);
    a_.mov(x86::rbp, x86::rsp);
    for (const x86::Gp& r : kSaved) a_.push(r);
    const std::size_t takes_stack = a_.offset();
    take_stack();
    a_.and_(x86::rsp, -kVector);
    addresses_ = program.addresses.data();
    phases_ = program.phases.data();
    for (const Phase& phase : program.phases) memories_.push_back(memories_of(phase));
    based_.fill(kNoMemory);
    for (const Phase& phase : program.phases) {
      const auto number = static_cast<std::size_t>(&phase - program.phases.data());
      lanes_ = phase.lanes > 0 ? phase.lanes : usual_lanes_;
      width_ = std::min(lanes_, avx512_ ? 8 : 4);
      loops_ = lanes_ > kMostInLine * width_;
      if (loops_) {
        if (!write_loop(phase)) return false;
        continue;
      }
      if (!load_bases(number, phase.repeat_while.has_value())) return false;
      const bool once = !phase.repeat_while && std::all_of(phase.stores.begin(), phase.stores.end(),
                                                           [](const auto& s) { return s.to.reach == Reach::one; });
      for (first_ = 0; first_ < (once ? width_ : lanes_); first_ += width_) {
        if (!write_repeated(phase)) return false;
      }
    }
    a_.lea(x86::rsp, x86::ptr(x86::rbp, -8 * static_cast<std::int32_t>(std::size(kSaved))));
    for (std::size_t k = std::size(kSaved); k > 0; --k) a_.pop(kSaved[k - 1]);
    a_.pop(x86::rbp);
    a_.vzeroupper();
    a_.ret();
    a_.align(asmjit::AlignMode::kData, kVector);
    a_.bind(constants_at_);
    for (const std::uint64_t bits : constants_) {
      for (int l = 0; l < kVector / 8; ++l) a_.embed(&bits, sizeof bits);
    }
    a_.setOffset(takes_stack);
    take_stack();  // now it is known how much
    return true;
  }

 private:
  using Point = Uses::Point;
  static constexpr Point kNever = Uses::kNever;
  static constexpr std::uint32_t kFree = UINT32_MAX;  // no value, no register, no place on the stack
  static constexpr std::size_t kNoMemory = SIZE_MAX;
  static constexpr std::int32_t kVector = 64;
  static constexpr int kMostInLine = 4;  // vectors of a phase without a loop
  static constexpr x86::Gp kSaved[] = {x86::rbx, x86::r12, x86::r13, x86::r14, x86::r15};
  static constexpr x86::Gp kBases[] = {x86::rax, x86::rcx, x86::rdx, x86::rsi, x86::r8,  x86::r9, x86::r10,
                                       x86::r11, x86::rbx, x86::r12, x86::r13, x86::r14, x86::r15};
  static constexpr x86::Gp kPlace = x86::r15;  // of a loop: of the vector, in bytes from the first

  // Always the same number of bytes.
  void take_stack() { a_.long_().sub(x86::rsp, static_cast<std::int32_t>((slots_ + 1) * kVector)); }

  // ---- memory

  static std::vector<std::size_t> memories_of(const Phase& phase) {
    std::vector<std::size_t> out;
    const auto add = [&](const Slot& s) {
      if (std::find(out.begin(), out.end(), memory_of(s)) == out.end()) out.push_back(memory_of(s));
    };
    for (const Instruction& n : phase.code) {
      if (n.op == Op::load || n.op == Op::pick) add(n.slot);
    }
    for (const Phase::Store& s : phase.stores) add(s.to);
    if (phase.repeat_while) add(*phase.repeat_while);
    return out;
  }
  // Before a phase, and before the label of a loop, loads the addresses of its memories, and those of the next phase
  // into registers that are left: behind a branch that was not foreseen they would be late. False if a loop needs more
  // than the registers.
  [[nodiscard]] bool load_bases(std::size_t phase, bool is_loop) {
    const std::vector<std::size_t>& needed = memories_[phase];
    if (needed.size() > bases()) return !is_loop;  // each is loaded where it is needed
    for (const std::size_t memory : needed) (void)base(memory);
    if (!is_loop || phase + 1 == memories_.size()) return true;
    std::size_t left = bases() - needed.size();
    for (const std::size_t memory : memories_[phase + 1]) {
      if (contains(needed, memory)) continue;
      if (left-- == 0) break;
      (void)base(memory);
    }
    for (const std::size_t memory : needed) (void)base(memory);  // the last to leave
    return true;
  }
  // The number of registers that may hold an address.
  [[nodiscard]] std::size_t bases() const { return std::size(kBases) - (loops_ ? 1 : 0); }
  // The register with the address of a memory. The one that was not needed for the longest time gives way.
  [[nodiscard]] const x86::Gp& base(std::size_t memory) {
    auto at = std::find(based_.begin(), based_.end(), memory);
    if (at == based_.end()) {
      const auto end = needed_at_.begin() + static_cast<std::ptrdiff_t>(bases());
      at = based_.begin() + (std::min_element(needed_at_.begin(), end) - needed_at_.begin());
      *at = memory;
      a_.mov(kBases[at - based_.begin()], pointer_to(memory));
    }
    needed_at_[static_cast<std::size_t>(at - based_.begin())] = ++time_;
    return kBases[at - based_.begin()];
  }
  static bool contains(std::span<const std::size_t> all, std::size_t one) {
    return std::find(all.begin(), all.end(), one) != all.end();
  }
  static x86::Mem pointer_to(std::size_t memory) { return x86::ptr(x86::rdi, static_cast<std::int32_t>(memory) * 8); }
  // A place relative to a memory. moves: with the vectors of a loop
  [[nodiscard]] x86::Mem place(std::size_t memory, std::int32_t offset, bool moves, std::uint32_t size) {
    if (loops_ && moves) return x86::ptr(base(memory), kPlace, 0, offset, size);
    return x86::ptr(base(memory), offset, size);
  }
  // Numbers that are no neighbours are moved one by one.
  [[nodiscard]] bool are_neighbours(const Slot& s) const {
    return s.reach == Reach::row || s.reach == Reach::from || (s.reach == Reach::one && width_ == 1);
  }
  // The first number of the vector, relative to the memory; of a scattered slot that of lane k of the vector.
  [[nodiscard]] std::int32_t offset(const Slot& s, int k = 0) const {
    const auto index = static_cast<std::int32_t>(s.index);
    if (s.reach == Reach::one) return index * 8;
    if (s.reach == Reach::scattered) return addresses_[s.index + static_cast<std::uint32_t>(first_ + k)] * 8;
    return ((s.reach == Reach::row ? index * lanes_ : index) + first_) * 8;
  }
  [[nodiscard]] x86::Mem slot(const Slot& s) { return place(memory_of(s), offset(s), true, bytes()); }
  [[nodiscard]] x86::Mem number(const Slot& s, int k) { return place(memory_of(s), offset(s, k), false, 8); }
  x86::Mem constant(std::uint64_t bits) {
    const auto found = std::find(constants_.begin(), constants_.end(), bits);
    const auto at = static_cast<std::int32_t>(found - constants_.begin());
    if (found == constants_.end()) constants_.push_back(bits);
    return x86::ptr(constants_at_, at * kVector, bytes());
  }
  [[nodiscard]] std::uint32_t bytes() const { return static_cast<std::uint32_t>(width_) * 8; }
  // Where a value without register is.
  x86::Mem place_of(std::uint32_t value) {
    const Instruction& n = phase_->code[value];
    if (stored_at_[value] != nullptr) return slot(*stored_at_[value]);
    if (is_simple_load(n) && slot_of_[value] == kFree) return slot(n.slot);
    if (n.op == Op::constant) return constant(std::bit_cast<std::uint64_t>(phase_->constants[n.operand[0]]));
    return x86::ptr(x86::rsp, static_cast<std::int32_t>(slot_of_[value]) * kVector, bytes());
  }

  // ---- registers

  [[nodiscard]] x86::Vec vector(std::uint32_t r) const {
    if (width_ == 8) return x86::zmm(r);
    if (width_ == 4) return x86::ymm(r);
    return x86::xmm(r);
  }
  [[nodiscard]] bool is_in_register(std::uint32_t value) const { return register_of_[value] != kFree; }
  void hold(std::uint32_t r) { held_[r] = true; }  // for the instruction at hand
  void put(std::uint32_t value, std::uint32_t r) {
    value_in_[r] = value;
    register_of_[value] = r;
  }
  void leave(std::uint32_t r) {
    if (value_in_[r] != kFree) register_of_[value_in_[r]] = kFree;
    value_in_[r] = kFree;
  }
  [[nodiscard]] bool any_free() const {
    for (std::uint32_t r = 0; r < value_in_.size(); ++r) {
      if (value_in_[r] == kFree && !held_[r]) return true;
    }
    return false;
  }
  // A register for another value; it is held.
  std::uint32_t take() {
    std::uint32_t best = 0;
    Point farthest = 0;
    bool found = false;
    for (std::uint32_t r = 0; r < value_in_.size(); ++r) {
      if (held_[r]) continue;
      const Point next = value_in_[r] == kFree ? kNever : uses_->next(value_in_[r], at_);
      if (found && next <= farthest) continue;
      found = true;
      farthest = next;
      best = r;
    }
    if (value_in_[best] != kFree) evict(best);
    hold(best);
    return best;
  }
  // A value that a store moves from slot to slot is read once, because stores may replace it before.
  [[nodiscard]] bool can_read_again(std::uint32_t value) const {
    const Op op = phase_->code[value].op;
    return op == Op::constant || (is_simple_load(phase_->code[value]) && !is_moved_[value]);
  }
  [[nodiscard]] bool is_simple_load(const Instruction& n) const { return n.op == Op::load && are_neighbours(n.slot); }
  void evict(std::uint32_t r) {
    const std::uint32_t value = value_in_[r];
    leave(r);
    if (can_read_again(value) || stored_at_[value] != nullptr || slot_of_[value] != kFree) return;
    if (free_slots_.empty()) free_slots_.push_back(slots_++);
    slot_of_[value] = free_slots_.back();
    free_slots_.pop_back();
    move(place_of(value), vector(r));
  }
  [[nodiscard]] bool is_last_use(std::uint32_t value) { return uses_->next(value, at_ + 1) == kNever; }
  // A value that is used no more leaves its register and the stack.
  void release(std::uint32_t value) {
    if (!is_last_use(value)) return;
    if (is_in_register(value)) leave(register_of_[value]);
    if (slot_of_[value] != kFree) free_slots_.push_back(std::exchange(slot_of_[value], kFree));
  }
  // The register of a value, which is held.
  x86::Vec in_register(std::uint32_t value) {
    if (!is_in_register(value)) {
      const x86::Mem from = place_of(value);
      const std::uint32_t r = take();
      move(vector(r), from);
      put(value, r);
    }
    hold(register_of_[value]);
    return vector(register_of_[value]);
  }
  // True if an operand is better read from memory.
  [[nodiscard]] bool stays_in_memory(std::uint32_t value) {
    return !is_in_register(value) && (is_last_use(value) || !any_free());
  }

  // ---- instructions

  void move(const x86::Vec& to, const x86::Mem& from) {
    if (width_ == 1) {
      a_.vmovsd(to.xmm(), from);
    } else {
      a_.vmovupd(to, from);
    }
  }
  void move(const x86::Mem& to, const x86::Vec& from) {
    if (width_ == 1) {
      a_.vmovsd(to, from.xmm());
    } else {
      a_.vmovupd(to, from);
    }
  }
  // Jumps if the row is positive in no lane.
  void jump_unless_positive(Slot s, const asmjit::Label& to) {
    const asmjit::Imm greater(0x1e);  // false for NaN, quiet
    const x86::Vec value = vector(0), zero = vector(1);
    move(value, slot(s));
    a_.vxorpd(x86::xmm1, x86::xmm1, x86::xmm1);
    if (width_ == 8) {
      a_.vcmppd(x86::k1, value, zero, greater);
      a_.kortestb(x86::k1, x86::k1);
    } else if (width_ == 1) {
      a_.vucomisd(value.xmm(), x86::xmm1);  // unordered: below
      a_.jbe(to);
      return;
    } else {
      a_.vcmppd(value, value, zero, greater);
      a_.vtestpd(value, value);
    }
    a_.jz(to);
  }

  // The phase once for each vector. A loop has neighbours only, and numbers that all lanes read.
  [[nodiscard]] bool write_loop(const Phase& phase) {
    const auto is_scattered = [](const Slot& s) { return s.reach == Reach::scattered; };
    const bool known =
        std::none_of(phase.code.begin(), phase.code.end(),
                     [&](const Instruction& n) { return n.op == Op::load && is_scattered(n.slot); }) &&
        std::none_of(phase.stores.begin(), phase.stores.end(), [](const auto& s) { return s.to.reach == Reach::one; });
    const auto number = static_cast<std::size_t>(&phase - phases_);
    based_.back() = kNoMemory;  // the register is kPlace
    if (!known || phase.repeat_while || lanes_ % width_ != 0 || !load_bases(number, true)) return false;
    const asmjit::Label again = a_.newLabel();
    a_.xor_(kPlace.r32(), kPlace.r32());
    a_.bind(again);
    first_ = 0;
    if (!write(phase)) return false;
    a_.add(kPlace, width_ * 8);
    a_.cmp(kPlace, lanes_ * 8);
    a_.jb(again);
    loops_ = false;
    return true;
  }
  [[nodiscard]] bool write_repeated(const Phase& phase) {
    if (!phase.repeat_while) return write(phase);
    const asmjit::Label again = a_.newLabel(), end = a_.newLabel();
    jump_unless_positive(*phase.repeat_while, end);
    a_.bind(again);
    if (!write(phase)) return false;
    jump_unless_positive(*phase.repeat_while, end);
    a_.jmp(again);
    a_.bind(end);
    return true;
  }
  [[nodiscard]] bool write(const Phase& phase) {
    Uses uses(phase);
    phase_ = &phase;
    uses_ = &uses;
    register_of_.assign(phase.code.size(), kFree);
    slot_of_.assign(phase.code.size(), kFree);
    std::fill(value_in_.begin(), value_in_.end(), kFree);
    stored_at_.assign(phase.code.size(), nullptr);
    compared_.fill({kFree, kFree});
    is_moved_.assign(phase.code.size(), false);
    for (const Phase::Store& s : phase.stores) is_moved_[s.value] = true;
    for (std::uint32_t i = 0; i < phase.code.size(); ++i) {
      const Instruction& n = phase.code[i];
      at_ = 2 * i;
      held_ = {};
      if (is_simple_load(n) && is_moved_[i]) {
        (void)in_register(i);
      } else if (!can_read_again(i) && !write(n, i)) {
        return false;
      }
      for (int k = 0; k < operands_of(n.op); ++k) release(n.operand[static_cast<std::size_t>(k)]);
      at_ = 2 * i + 1;
      for (const std::size_t s : uses.stores_behind(i)) {
        held_ = {};
        const Phase::Store& stored = phase.stores[s];
        store(stored.to, in_register(stored.value));
        if (are_neighbours(stored.to) && !uses.is_replaced(s)) stored_at_[stored.value] = &stored.to;
      }
      for (const std::size_t s : uses.stores_behind(i)) release(phase.stores[s].value);
    }
    return true;
  }

  // ---- numbers that are no neighbours

  void store(const Slot& to, const x86::Vec& from) {
    if (are_neighbours(to)) {
      move(slot(to), from);
    } else if (first_ == 0) {  // of the first lane
      a_.vmovsd(number(to, 0), from.xmm());
    }
  }
  void load(const Slot& from, std::uint32_t value) {
    const std::uint32_t r = take();
    const x86::Vec to = vector(r);
    if (from.reach == Reach::one) {
      if (width_ == 2) {
        a_.vmovddup(to, number(from, 0));
      } else {
        a_.vbroadcastsd(to, number(from, 0));
      }
    } else {
      const x86::Vec part = width_ > 2 ? vector(take()) : to;
      for (int k = 0; k < width_; k += 2) {
        const auto half = k == 0 ? to.xmm() : part.xmm();
        a_.vmovsd(half, number(from, k));
        if (k + 1 < width_) a_.vmovhpd(half, half, number(from, k + 1));
        if (k == 0) continue;
        if (avx512_) {
          a_.vinsertf64x2(to, to, half, k / 2);
        } else {
          a_.vinsertf128(to, to, half, k / 2);
        }
      }
    }
    put(value, r);
  }

  // Chooses what the second operand is, a register or memory, and calls with(it).
  template <class With>
  void with_second(std::uint32_t value, const With& with) {
    if (stays_in_memory(value)) {
      with(place_of(value));
    } else {
      with(in_register(value));
    }
  }
  // The register for the result; operands that are used no more leave theirs. Their places on the stack stay.
  x86::Vec result(const Instruction& n) {
    for (int k = 0; k < operands_of(n.op); ++k) {
      const std::uint32_t value = n.operand[static_cast<std::size_t>(k)];
      if (!is_in_register(value) || !is_last_use(value)) continue;
      held_[register_of_[value]] = false;
      leave(register_of_[value]);
    }
    const std::uint32_t r = take();
    put(here_, r);
    return vector(r);
  }

  [[nodiscard]] bool write(const Instruction& n, std::uint32_t index) {
    here_ = index;
    if (n.op == Op::load) {
      load(n.slot, index);
      return true;
    }
    for (int k = 0; k < operands_of(n.op); ++k) {
      if (const std::uint32_t r = register_of_[n.operand[static_cast<std::size_t>(k)]]; r != kFree) hold(r);
    }
    switch (n.op) {
      case Op::add:
        return binary(n, Inst::kIdVaddsd, Inst::kIdVaddpd);
      case Op::subtract:
        return binary(n, Inst::kIdVsubsd, Inst::kIdVsubpd);
      case Op::multiply:
        return binary(n, Inst::kIdVmulsd, Inst::kIdVmulpd);
      case Op::divide:
        return binary(n, Inst::kIdVdivsd, Inst::kIdVdivpd);
      case Op::larger:
        return binary(n, Inst::kIdVmaxsd, Inst::kIdVmaxpd);
      case Op::fma:
        return fused(n, Inst::kIdVfmadd231sd, Inst::kIdVfmadd231pd);
      case Op::fnma:
        return fused(n, Inst::kIdVfnmadd231sd, Inst::kIdVfnmadd231pd);
      case Op::pick:
        pick(n);
        return true;
      case Op::square_root: {
        const x86::Vec a = in_register(n.operand[0]);
        a_.vsqrtpd(result(n), a);
        return true;
      }
      case Op::absolute: {
        const x86::Vec a = in_register(n.operand[0]);
        const x86::Vec to = result(n);
        if (width_ == 1) {
          a_.vpsllq(to, a, 1);
          a_.vpsrlq(to, to, 1);
        } else if (avx512_) {
          a_.vpandq(to, a, constant(kAllButSign));
        } else {
          a_.vpand(to, a, constant(kAllButSign));
        }
        return true;
      }
      case Op::copy_sign: {
        const x86::Vec a = in_register(n.operand[0]), b = in_register(n.operand[1]);
        const x86::Vec sign = vector(take()), to = vector(take());
        a_.vpsrlq(sign, b, 63);
        a_.vpsllq(sign, sign, 63);
        a_.vpsllq(to, a, 1);
        a_.vpsrlq(to, to, 1);
        const x86::Vec into = result(n);
        if (avx512_) {
          a_.vporq(into, to, sign);
        } else {
          a_.vpor(into, to, sign);
        }
        return true;
      }
      case Op::round: {
        constexpr int kNearest = 0x08;  // quiet
        const x86::Vec a = in_register(n.operand[0]);
        if (avx512_) {
          a_.vrndscalepd(result(n), a, kNearest);
        } else {
          a_.vroundpd(result(n), a, kNearest);
        }
        return true;
      }
      case Op::select:
        choose(n);
        return true;
      default:
        return false;
    }
  }

  // one: the instruction for a single lane.
  bool binary(const Instruction& n, Inst::Id one, Inst::Id many) {
    const bool commutes = n.op == Op::add || n.op == Op::multiply;
    const bool swaps = commutes && stays_in_memory(n.operand[0]) && !stays_in_memory(n.operand[1]);
    const x86::Vec a = in_register(n.operand[swaps ? 1 : 0]);
    with_second(n.operand[swaps ? 0 : 1], [&](const auto& b) { a_.emit(width_ == 1 ? one : many, result(n), a, b); });
    return true;
  }
  // The sum replaces its last operand.
  bool fused(const Instruction& n, Inst::Id one, Inst::Id many) {
    const std::uint32_t c = n.operand[2];
    const bool swaps = stays_in_memory(n.operand[0]) && !stays_in_memory(n.operand[1]);
    const x86::Vec a = in_register(n.operand[swaps ? 1 : 0]);
    const auto finish = [&](const auto& b) {
      const bool is_last = is_last_use(c) && c != n.operand[0] && c != n.operand[1];
      std::uint32_t r = kFree;
      if (is_last && is_in_register(c)) {
        r = register_of_[c];
        leave(r);
      } else {
        r = take();
        if (is_in_register(c)) {
          a_.vmovapd(vector(r), vector(register_of_[c]));
        } else {
          move(vector(r), place_of(c));
        }
      }
      a_.emit(width_ == 1 ? one : many, vector(r), a, b);
      put(here_, r);
    };
    with_second(n.operand[swaps ? 0 : 1], finish);
    return true;
  }
  void pick(const Instruction& n) {
    const x86::Vec index = in_register(n.operand[0]);
    const std::uint32_t place = take();
    const bool is_half = width_ == 8;  // an index has half the bytes of a number
    const x86::Vec where = is_half ? x86::Vec(x86::ymm(place)) : x86::Vec(x86::xmm(place));
    a_.vcvttpd2dq(where, width_ < 4 ? x86::Vec(index.xmm()) : index);
    const x86::Vec mask = avx512_ ? where : vector(take());
    const x86::Vec to = result(n);
    const x86::Mem from = x86::ptr(base(memory_of(n.slot)), where, 3, static_cast<std::int32_t>(n.slot.index) * 8);
    if (avx512_) {
      const x86::KReg lanes = mask_in(mask_for({kFree, kFree}));
      a_.kxnorb(lanes, lanes, lanes);
      if (width_ == 1) a_.kshiftrb(lanes, lanes, 7);
      a_.k(lanes).vgatherdpd(to, from);
    } else {
      a_.vpcmpeqd(mask, mask, mask);
      if (width_ == 1) a_.vmovq(mask.xmm(), mask.xmm());
      a_.vgatherdpd(to, from, mask);
    }
  }
  // a <= b ? yes : no
  void choose(const Instruction& n) {
    const asmjit::Imm less_or_equal(0x12);  // false for NaN, quiet
    const Inst::Id compare = width_ == 1 ? Inst::kIdVcmpsd : Inst::kIdVcmppd;
    if (avx512_) {
      const std::pair compared(n.operand[0], n.operand[1]);
      auto mask = std::find(compared_.begin(), compared_.end(), compared);
      if (mask == compared_.end()) {
        mask = mask_for(compared);
        const x86::Vec a = in_register(n.operand[0]);
        with_second(n.operand[1], [&](const auto& b) { a_.emit(compare, mask_in(mask), a, b, less_or_equal); });
      }
      const x86::Vec no = in_register(n.operand[3]), yes = in_register(n.operand[2]);
      const x86::Vec to = result(n);
      a_.k(mask_in(mask)).vblendmpd(to, no, yes);
    } else {
      const x86::Vec a = in_register(n.operand[0]);
      const x86::Vec mask = vector(take());
      with_second(n.operand[1], [&](const auto& b) { a_.emit(compare, mask, a, b, less_or_equal); });
      const x86::Vec no = in_register(n.operand[3]), yes = in_register(n.operand[2]);
      a_.vblendvpd(result(n), no, yes, mask);
    }
  }

  using Masks = std::array<std::pair<std::uint32_t, std::uint32_t>, 7>;
  // The next one, which now compares these values.
  Masks::iterator mask_for(const std::pair<std::uint32_t, std::uint32_t>& compared) {
    const auto mask = compared_.begin() + static_cast<std::ptrdiff_t>(next_mask_);
    next_mask_ = (next_mask_ + 1) % compared_.size();
    *mask = compared;
    return mask;
  }
  [[nodiscard]] x86::KReg mask_in(Masks::const_iterator at) const {
    return x86::k(static_cast<std::uint32_t>(at - compared_.begin()) + 1);
  }

  static constexpr std::uint64_t kAllButSign = ~std::uint64_t{0} >> 1;

  int usual_lanes_;
  int lanes_ = 1, width_ = 1;  // of the phase
  bool avx512_;
  x86::Assembler a_;
  asmjit::Label constants_at_;
  std::vector<std::uint64_t> constants_;
  const std::int32_t* addresses_ = nullptr;                   // StepProgram::addresses
  const Phase* phases_ = nullptr;                             // of the program
  int first_ = 0;                                             // lane of the vector
  bool loops_ = false;                                        // over the vectors of the phase
  std::vector<std::vector<std::size_t>> memories_;            // of the phases
  std::array<std::size_t, std::size(kBases)> based_{};        // memory whose address is in each register
  std::array<std::uint64_t, std::size(kBases)> needed_at_{};  // when it was needed last
  std::uint64_t time_ = 0;
  const Phase* phase_ = nullptr;
  Uses* uses_ = nullptr;
  Point at_ = 0;
  std::uint32_t here_ = 0;                            // the instruction
  std::vector<std::uint32_t> value_in_;               // registers: value, or kFree
  std::array<bool, 32> held_{};                       // registers: needed by the instruction at hand
  std::vector<std::uint32_t> register_of_, slot_of_;  // values; kFree: none
  std::vector<bool> is_moved_;                        // values that stores take
  std::vector<const Slot*> stored_at_;                // values: where a store has left them; null: nowhere
  std::vector<std::uint32_t> free_slots_;             // of the stack
  Masks compared_{};                                  // what each mask compares, values; k1, k2, ...
  std::size_t next_mask_ = 0;                         // the one to replace
  std::uint32_t slots_ = 0;
};

struct Trouble : asmjit::ErrorHandler {
  void handleError(asmjit::Error, const char*, asmjit::BaseEmitter*) override { any = true; }
  bool any = false;
};

class MachineCode final : public Executor {
 public:
  [[nodiscard]] bool compile(const StepProgram& program, int lanes, bool avx512, ProtectCode protect) {
    asmjit::CodeHolder code;
    Trouble trouble;
    if (code.init(asmjit::Environment::host()) != asmjit::kErrorOk) return false;
    code.setErrorHandler(&trouble);
    MachineCodeWriter writer(lanes, avx512, code);
    if (!writer.write(program) || trouble.any || !code_.take(code, protect)) return false;
    function_ = code_.function();
    return true;
  }

  void run(std::span<double* const> memory) const override { function_(memory.data()); }

 private:
  Code code_;
  Function function_ = nullptr;
};

}  // namespace

bool protect_code(void* at, std::size_t size) { return ::mprotect(at, size, PROT_READ | PROT_EXEC) == 0; }

std::unique_ptr<Executor> make_machine_code(const StepProgram& program, int lanes, VectorCode vectors,
                                            ProtectCode protect) {
  const bool wide = vectors == VectorCode::avx512;
  if ((static_cast<std::int64_t>(hwy::SupportedTargets()) & (wide ? HWY_AVX3 : HWY_AVX2)) == 0) return nullptr;
  auto code = std::make_unique<MachineCode>();
  if (!code->compile(program, lanes, wide, protect)) return nullptr;
  return code;
}

}  // namespace assur

// What code in a shared object means by stderr, where the linker is asked to wrap it: see lib/CMakeLists.txt. AsmJit
// writes there only what its assertions say, and Debian builds it without them.
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier): the linker's names
extern FILE* __real_stderr __attribute__((weak));  // stderr; null where nothing is wrapped
__attribute__((visibility("hidden"))) FILE* __wrap_stderr = nullptr;
__attribute__((constructor)) static void take_stderr() {
  if (&__real_stderr != nullptr) __wrap_stderr = __real_stderr;
}
// NOLINTEND(bugprone-reserved-identifier)
}
