// Executors of step programs. All of them give the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "program/step_program.hpp"

namespace assur {

// A step program for a number of lanes.
class Executor {
 public:
  virtual ~Executor() = default;

  // memory: by memory_of(); those that the program does not use may be missing. The processor must round to nearest and
  // keep subnormal numbers. Several threads may run machine code at once, but not an interpreter.
  virtual void run(std::span<double* const> memory) const = 0;
};

// Lists of operations, read over vectors of lanes: for every processor. Null if it does not know an operation of the
// program. lanes: 1, 2, 4, or a multiple of 8
[[nodiscard]] std::unique_ptr<Executor> make_interpreter(const StepProgram& program, int lanes);

// Vectors of machine code. Fewer than 8 lanes need no more than AVX2.
enum class VectorCode : std::uint8_t { avx2, avx512 };

// Makes memory executable, and read-only: true if the system allows it.
using ProtectCode = bool (*)(void* at, std::size_t size);
[[nodiscard]] bool protect_code(void* at, std::size_t size);

// Machine code, for x86-64 with FMA. Null where AsmJit is absent, the processor lacks these vectors, it does not know
// an operation of the program, or the system refuses memory for code. lanes: as above
[[nodiscard]] std::unique_ptr<Executor> make_machine_code(const StepProgram& program, int lanes, VectorCode vectors,
                                                          ProtectCode protect = protect_code);

}  // namespace assur
