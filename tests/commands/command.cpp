#include "commands/command.hpp"

#include <fcntl.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace assur {
namespace {

using namespace std::chrono_literals;

void redirect(int descriptor, const std::string& file) {
  const int to = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (to < 0 || dup2(to, descriptor) < 0) _exit(99);
}

[[noreturn]] void become(const std::vector<std::string>& arguments, const Setting& setting, const std::string& out,
                         const std::string& err, int terminal) {
  redirect(STDOUT_FILENO, out);
  redirect(STDERR_FILENO, err);
  if (terminal >= 0 && dup2(terminal, setting.terminal) < 0) _exit(99);
  if (!setting.folder.empty() && chdir(setting.folder.c_str()) != 0) _exit(98);
  if (setting.before) setting.before();
  std::vector<char*> words = {const_cast<char*>(ASSUR_COMMAND)};
  for (const std::string& a : arguments) words.push_back(const_cast<char*>(a.c_str()));
  words.push_back(nullptr);
  execv(ASSUR_COMMAND, words.data());
  _exit(97);
}

}  // namespace

std::vector<std::string> Outcome::lines() const {
  std::vector<std::string> found;
  std::istringstream stream(out);
  for (std::string line; std::getline(stream, line);) found.push_back(line);
  return found;
}

Outcome run_command(const std::vector<std::string>& arguments, const Setting& setting) {
  const Scratch scratch;
  const std::string out = setting.out.empty() ? scratch.file("out") : setting.out.string();
  const std::string err = scratch.file("err", "");
  int ours = -1, theirs = -1;
  const winsize size{24, setting.columns, 0, 0};
  if (setting.columns > 0 && openpty(&ours, &theirs, nullptr, nullptr, &size) != 0) {
    throw std::runtime_error("no terminal");
  }
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child == 0) become(arguments, setting, out, err, theirs);
  std::string drawn;
  const bool interrupts = !setting.interrupt_when_err.empty();
  if (setting.columns > 0) {
    close(theirs);
    char some[512];
    bool waits = interrupts && setting.terminal == STDERR_FILENO;
    for (ssize_t count = 0; (count = read(ours, some, sizeof some)) > 0;) {
      drawn.append(some, count);
      if (!waits || drawn.find(setting.interrupt_when_err) == std::string::npos) continue;
      kill(child, setting.signal);
      waits = false;
    }
    close(ours);
  }

  int status = 0;
  rusage used{};
  if (interrupts && (setting.columns == 0 || setting.terminal != STDERR_FILENO)) {
    while (content(err).find(setting.interrupt_when_err) == std::string::npos) {
      if (waitpid(child, &status, WNOHANG) == child) throw std::runtime_error("ended too early: " + content(err));
      std::this_thread::sleep_for(10ms);
    }
    kill(child, setting.signal);
  }
  wait4(child, &status, 0, &used);
  const auto written = [&](int descriptor, const std::string& file) {
    return setting.columns > 0 && setting.terminal == descriptor ? drawn : content(file);
  };
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, setting.out.empty() ? written(STDOUT_FILENO, out) : "",
          written(STDERR_FILENO, err), std::int64_t{1024} * used.ru_maxrss};
}

Outcome run_tuning(int seconds, const std::vector<std::string>& more, const Setting& setting) {
  for (;; seconds *= 4) {
    std::vector<std::string> words = {"tune", "--budget", std::to_string(seconds)};
    words.insert(words.end(), more.begin(), more.end());
    Outcome outcome = run_command(words, setting);
    if (outcome.err.find("nothing was measured") == std::string::npos || seconds > 60) return outcome;
  }
}

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

Scratch::Scratch() {
  std::string pattern = (std::filesystem::temp_directory_path() / "assur-test-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder: " + pattern);
  folder_ = pattern;
}

Scratch::~Scratch() { std::filesystem::remove_all(folder_); }

std::string Scratch::file(const std::string& name, const std::string& text) const {
  std::ofstream(file(name)) << text;
  return file(name);
}

}  // namespace assur
