// In place of machine_code.cpp, without AsmJit.
#include "executors/executor.hpp"

namespace assur {

bool protect_code(void*, std::size_t) { return false; }

std::unique_ptr<Executor> make_machine_code(const StepProgram&, int, VectorCode, ProtectCode) { return nullptr; }

}  // namespace assur
