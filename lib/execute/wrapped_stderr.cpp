// What code in a shared object means by stderr, where the linker is asked to wrap it: see lib/CMakeLists.txt. Nothing
// is linked from here without that. AsmJit writes there only what its assertions say, and Debian builds it without
// them.
#include <cstdio>

extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier): the linker's names
extern FILE* __real_stderr;
__attribute__((visibility("hidden"))) FILE* __wrap_stderr = nullptr;
__attribute__((constructor)) static void take_stderr() { __wrap_stderr = __real_stderr; }
// NOLINTEND(bugprone-reserved-identifier)
}
