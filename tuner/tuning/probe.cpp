#include "tuning/probe.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "measure/linear.hpp"

namespace assur::tuning {
namespace {

constexpr auto kBetweenLooks = std::chrono::milliseconds(2);
constexpr std::int32_t kUnknowns = 120;    // enough for the threads of every backend to be used
constexpr int kEntries = 6;                // in a row, as in mechanisms
constexpr int kMatrices = 2, kCalls = 20;  // a choice: a crash shows at once or in a few calls
constexpr int kCannotStart = 127;          // the status that shells give to this

// Replaces this process by the program, without output and core file.
[[noreturn]] void become(std::vector<char*> words) {
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int d : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, d);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  execv(words[0], words.data());
  _exit(kCannotStart);
}

std::string told(int status) {
  if (WIFSIGNALED(status)) return "crashes (signal " + std::to_string(WTERMSIG(status)) + ")";
  if (WEXITSTATUS(status) == 0) return "";
  if (WEXITSTATUS(status) == kCannotStart) return "its trial cannot be started";
  return "fails on a well-conditioned matrix (status " + std::to_string(WEXITSTATUS(status)) + ")";
}

std::string key(const Strategy& strategy) {
  return strategy.solver.backend + (strategy.solver.threads > 1 ? " 1x" + std::to_string(strategy.solver.threads) : "");
}

}  // namespace

std::string try_in_child(const std::vector<std::string>& command, double seconds) {
  std::vector<char*> words;
  for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  const pid_t child = fork();
  if (child < 0) return std::string("cannot start a process for its trial: ") + std::strerror(errno);
  if (child == 0) become(std::move(words));

  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  int status = 0;
  for (;;) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) return told(status);
    if (ended < 0 && errno != EINTR) return std::string("cannot wait for its trial: ") + std::strerror(errno);
    if (std::chrono::steady_clock::now() > end) break;
    std::this_thread::sleep_for(kBetweenLooks);
  }
  kill(child, SIGKILL);
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return "does not end";
}

void probe(const Strategy& strategy, std::span<const Backend> table) {
  const measure::Matrices matrices = measure::random_matrices(kUnknowns, kEntries, kMatrices);
  measure::Linear linear(matrices, strategy, find_backend(table, strategy.solver.backend));
  if (!linear.refused().empty()) throw Error(Error::Kind::numerical, linear.refused());
  if (!linear.factor().run(kCalls) || !linear.solve().run(kCalls)) {
    throw Error(Error::Kind::numerical, "it fails on a later matrix");
  }
}

Probes::Probes(std::span<const Backend> table, ThreadBudget budget,
               const std::function<std::vector<std::string>(const Strategy&)>& command, double seconds) {
  const auto in_core = [](const Backend& b) {
    const auto core = core_backends();
    return std::any_of(core.begin(), core.end(), [&](const Backend& c) { return c.id == b.id; });
  };
  Shape shape;
  shape.n = kUnknowns;
  shape.nnz = kUnknowns * kEntries;
  for (const Backend& backend : table) {
    Strategy s;
    s.solver.backend = backend.id;
    for (s.solver.threads = 1; s.solver.threads <= std::max(budget.threads, 1); s.solver.threads *= 2) {
      if ((s.solver.threads == 1 && in_core(backend)) ||
          !backend.why_not(shape, ThreadBudget{s.solver.threads}).empty())
        continue;
      if (const std::string why = try_in_child(command(s), seconds); !why.empty()) failed_[key(s)] = why;
    }
  }
}

std::string Probes::why_not(const Strategy& strategy) const {
  Strategy one_thread = strategy;
  one_thread.solver.threads = 1;
  for (const std::string& k : {key(strategy), key(one_thread)}) {
    if (const auto found = failed_.find(k); found != failed_.end()) return found->second;
  }
  return "";
}

}  // namespace assur::tuning
