#include <asmjit/x86.h>
#include <hwy/targets.h>
#include <sys/mman.h>

#include <algorithm>
#include <vector>

#include "execute/executor.hpp"

namespace assur {
namespace {

namespace x86 = asmjit::x86;

using Function = void (*)(double* const*);  // memory, at the lanes of one vector

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
  [[nodiscard]] Function function(std::size_t offset) const {
    return reinterpret_cast<Function>(reinterpret_cast<std::uintptr_t>(at_) + offset);
  }

 private:
  void* at_ = nullptr;
  std::size_t size_ = 0;
};

// Writes the functions of all phases for vectors of `width` lanes, of `lanes` lanes in memory.
class Writer {
 public:
  Writer(int lanes, int width, asmjit::CodeHolder& code) : lanes_(lanes), width_(width), cc_(&code) {}

  // False if an operation is unknown.
  [[nodiscard]] bool function(const Phase& phase, asmjit::Label& label) {
    asmjit::FuncSignatureBuilder signature;
    signature.setRet(asmjit::TypeId::kVoid);
    signature.addArg(asmjit::TypeId::kUIntPtr);
    asmjit::FuncNode* const node = cc_.addFunc(signature);
    if (node == nullptr) return false;
    label = node->label();
    node->frame().setAvxEnabled();
    node->frame().setAvxCleanup();  // what follows may be SSE
    if (width_ == 8) node->frame().setAvx512Enabled();
    memory_ = cc_.newIntPtr();
    node->setArg(0, memory_);
    base_.assign(kMemories, x86::Gp());
    values_.clear();
    for (const Instruction& n : phase.code) {
      if (!write(phase, n)) return false;
    }
    for (const Phase::Store& s : phase.stores) store(values_[s.value], slot(s.to));
    cc_.ret();
    return cc_.endFunc() == asmjit::kErrorOk;
  }

  [[nodiscard]] bool finish() { return cc_.finalize() == asmjit::kErrorOk; }

 private:
  x86::Vec vector() {
    if (width_ == 8) return cc_.newZmm();
    if (width_ == 4) return cc_.newYmm();
    return cc_.newXmm();
  }
  x86::Mem slot(Slot s) {
    x86::Gp& base = base_[static_cast<std::size_t>(s.memory)];
    if (!base.isValid()) {
      base = cc_.newIntPtr();
      cc_.mov(base, x86::ptr(memory_, static_cast<std::int32_t>(s.memory) * 8));
    }
    return x86::ptr(base, static_cast<std::int32_t>(s.index) * lanes_ * 8, static_cast<std::uint32_t>(width_) * 8);
  }
  void load(const x86::Vec& to, const x86::Mem& from) {
    if (width_ == 1) {
      cc_.vmovsd(to.xmm(), from);
    } else {
      cc_.vmovupd(to, from);
    }
  }
  void store(const x86::Vec& from, const x86::Mem& to) {
    if (width_ == 1) {
      cc_.vmovsd(to, from.xmm());
    } else {
      cc_.vmovupd(to, from);
    }
  }
  void set(const x86::Vec& to, double number) {
    const x86::Mem from = cc_.newDoubleConst(asmjit::ConstPoolScope::kGlobal, number);
    if (width_ <= 2) {
      cc_.vmovddup(to, from);
    } else {
      cc_.vbroadcastsd(to, from);
    }
  }
  // to = a <= b ? yes : no
  void choose(const x86::Vec& to, const x86::Vec& a, const x86::Vec& b, const x86::Vec& yes, const x86::Vec& no) {
    const asmjit::Imm less_or_equal(0x12);  // false for NaN, quiet
    if (width_ == 8) {
      const x86::KReg mask = cc_.newKq();
      cc_.vcmppd(mask, a, b, less_or_equal);
      cc_.k(mask).vblendmpd(to, no, yes);
    } else {
      const x86::Vec mask = vector();
      cc_.vcmppd(mask, a, b, less_or_equal);
      cc_.vblendvpd(to, no, yes, mask);
    }
  }

  bool write(const Phase& phase, const Instruction& n) {
    constexpr int kNearest = 0x08;  // quiet
    const x86::Vec to = vector();
    const auto of = [&](std::size_t k) -> const x86::Vec& { return values_[n.operand[k]]; };
    switch (n.op) {
      case Op::load:
        load(to, slot(n.slot));
        break;
      case Op::constant:
        set(to, phase.constants[n.operand[0]]);
        break;
      case Op::add:
        cc_.vaddpd(to, of(0), of(1));
        break;
      case Op::subtract:
        cc_.vsubpd(to, of(0), of(1));
        break;
      case Op::multiply:
        cc_.vmulpd(to, of(0), of(1));
        break;
      case Op::divide:
        cc_.vdivpd(to, of(0), of(1));
        break;
      case Op::fma:
        cc_.vmovapd(to, of(2));
        cc_.vfmadd231pd(to, of(0), of(1));
        break;
      case Op::fnma:
        cc_.vmovapd(to, of(2));
        cc_.vfnmadd231pd(to, of(0), of(1));
        break;
      case Op::fms:
        cc_.vmovapd(to, of(2));
        cc_.vfmsub231pd(to, of(0), of(1));
        break;
      case Op::square_root:
        cc_.vsqrtpd(to, of(0));
        break;
      case Op::absolute:
        cc_.vpsllq(to, of(0), asmjit::imm(1));
        cc_.vpsrlq(to, to, asmjit::imm(1));
        break;
      case Op::copy_sign: {
        const x86::Vec sign = vector();
        cc_.vpsrlq(sign, of(1), asmjit::imm(63));
        cc_.vpsllq(sign, sign, asmjit::imm(63));
        cc_.vpsllq(to, of(0), asmjit::imm(1));
        cc_.vpsrlq(to, to, asmjit::imm(1));
        if (width_ == 8) {
          cc_.vporq(to, to, sign);
        } else {
          cc_.vpor(to, to, sign);
        }
        break;
      }
      case Op::round:
        if (width_ == 8) {
          cc_.vrndscalepd(to, of(0), asmjit::imm(kNearest));
        } else {
          cc_.vroundpd(to, of(0), asmjit::imm(kNearest));
        }
        break;
      case Op::larger:
        cc_.vmaxpd(to, of(0), of(1));
        break;
      case Op::select:
        choose(to, of(0), of(1), of(2), of(3));
        break;
      default:
        return false;
    }
    values_.push_back(to);
    return true;
  }

  int lanes_, width_;
  x86::Compiler cc_;
  x86::Gp memory_;
  std::vector<x86::Gp> base_;
  std::vector<x86::Vec> values_;
};

class MachineCode final : public Executor {
 public:
  MachineCode(int lanes, int width) : lanes_(lanes), width_(width) {}

  [[nodiscard]] bool compile(const StepProgram& program, ProtectCode protect) {
    asmjit::CodeHolder code;
    if (code.init(asmjit::Environment::host()) != asmjit::kErrorOk) return false;
    Writer writer(lanes_, width_, code);
    std::vector<asmjit::Label> labels(program.phases.size());
    for (std::size_t p = 0; p < labels.size(); ++p) {
      if (!writer.function(program.phases[p], labels[p])) return false;
    }
    if (!writer.finish() || !code_.take(code, protect)) return false;
    for (std::size_t p = 0; p < labels.size(); ++p) {
      phases_.push_back(
          {code_.function(static_cast<std::size_t>(code.labelOffset(labels[p]))), program.phases[p].repeat_while});
    }
    return true;
  }

  void run(const std::array<double*, kMemories>& memory) override {
    for (int first = 0; first < lanes_; first += width_) {
      double* here[kMemories];
      for (std::size_t m = 0; m < kMemories; ++m) here[m] = memory[m] + first;
      for (const auto& [function, repeat_while] : phases_) {
        if (!repeat_while) {
          function(here);
          continue;
        }
        const double* const slot = here[static_cast<std::size_t>(repeat_while->memory)] +
                                   static_cast<std::size_t>(lanes_) * repeat_while->index;
        while (is_positive(slot)) function(here);
      }
    }
  }

 private:
  struct Part {
    Function function;
    std::optional<Slot> repeat_while;
  };

  [[nodiscard]] bool is_positive(const double* slot) const {
    for (int l = 0; l < width_; ++l) {
      if (slot[l] > 0) return true;
    }
    return false;
  }

  int lanes_, width_;
  Code code_;
  std::vector<Part> phases_;
};

}  // namespace

bool protect_code(void* at, std::size_t size) { return ::mprotect(at, size, PROT_READ | PROT_EXEC) == 0; }

std::unique_ptr<Executor> make_machine_code(const StepProgram& program, int lanes, VectorCode vectors,
                                            ProtectCode protect) {
  const bool wide = vectors == VectorCode::avx512;
  if ((static_cast<std::int64_t>(hwy::SupportedTargets()) & (wide ? HWY_AVX3 : HWY_AVX2)) == 0) return nullptr;
  auto code = std::make_unique<MachineCode>(lanes, std::min(lanes, wide ? 8 : 4));
  if (!code->compile(program, protect)) return nullptr;
  return code;
}

}  // namespace assur
