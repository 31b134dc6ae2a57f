// Checks the memory limit before the libraries initialise themselves: OpenBLAS hangs if it cannot get its memory.
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <string_view>

#include "commands/commands.hpp"
#include "parallel/thread_state.hpp"

extern "C" {
char* openblas_get_config() __attribute__((weak));
int openblas_get_parallel() __attribute__((weak));  // fixed when OpenBLAS was built
}

namespace assur::command {
namespace {

constexpr std::size_t kOthers = std::size_t{32} << 20;  // bytes for main() and the other libraries

// The threads that OpenBLAS starts with. A build for OpenMP takes one for each processor of the machine, or
// OMP_NUM_THREADS if that is less; affinity and the variables of OpenBLAS only count for its other builds.
std::size_t openblas_threads(char** environment) {
  const bool openmp = openblas_get_parallel == nullptr || openblas_get_parallel() == 2;
  int threads = static_cast<int>(std::max(sysconf(_SC_NPROCESSORS_CONF), 1L));
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (!openmp && sched_getaffinity(0, sizeof allowed, &allowed) == 0) threads = std::max(CPU_COUNT(&allowed), 1);
  for (const std::string_view name : {"OPENBLAS_NUM_THREADS=", "GOTO_NUM_THREADS=", "OMP_NUM_THREADS="}) {
    if (openmp && name != "OMP_NUM_THREADS=") continue;
    for (char** entry = environment; *entry != nullptr; ++entry) {
      const std::string_view text = *entry;
      int said = 0;
      if (!text.starts_with(name)) continue;
      std::from_chars(text.data() + name.size(), text.data() + text.size(), said);
      if (said > 0) return static_cast<std::size_t>(std::min(threads, said));
    }
  }
  return static_cast<std::size_t>(threads);
}

void say(int descriptor, std::string_view text) {
  if (write(descriptor, text.data(), text.size()) < 0) _exit(kEnvironment);
}

// Uses nothing that a library has to initialise first.
void look(int argc, char** argv, char** environment) {
  if (openblas_get_config == nullptr) return;
  const std::size_t bytes = openblas_threads(environment) * kBlasBuffer + kOthers;
  void* const room = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room != MAP_FAILED) {
    munmap(room, bytes);
    return;
  }
  std::array<char, 24> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), bytes >> 20).ptr;
  const bool json = std::any_of(argv, argv + argc, [](const char* word) { return std::strcmp(word, "--json") == 0; });
  const int out = json ? STDOUT_FILENO : STDERR_FILENO;
  say(out, json ? "{\"error\": {\"kind\": \"environment\", \"message\": \"" : "error: ");
  say(out, "out of memory: OpenBLAS needs ");
  say(out, {digits.data(), static_cast<std::size_t>(end - digits.data())});
  say(out, " MiB of address space; raise `ulimit -v`, or set OMP_NUM_THREADS=1");
  say(out, json ? "\", \"diagnostics\": []}}\n" : "\n");
  _exit(kEnvironment);
}

}  // namespace

// These functions run before the constructors of shared libraries. Not with sanitizers: they must start first and need
// more memory.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
__attribute__((section(".preinit_array"), used)) void (*const before_all)(int, char**, char**) = look;
#else
[[maybe_unused]] constexpr auto kUnused = look;
#endif

}  // namespace assur::command
