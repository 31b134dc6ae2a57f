// Runs the command in a child process.
#pragma once

#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace assur {

struct Outcome {
  int status = -1;  // exit status; -1: ended by a signal
  std::string out, err;
  std::int64_t memory = 0;  // bytes, largest memory of the process

  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(out); }
  [[nodiscard]] std::vector<std::string> lines() const;  // lines of `out`
};

struct Setting {
  std::filesystem::path folder = {};    // working folder; empty: the current one
  std::filesystem::path out = {};       // file for standard output; empty: Outcome::out
  std::string interrupt_when_err = {};  // a signal is sent once standard error contains this; empty: never
  int signal = SIGINT;
  std::function<void()> before = {};  // runs in the child: limits, environment
  unsigned short columns = 0;         // width of the terminal; 0: no terminal
  int terminal = STDERR_FILENO;       // connected to the terminal: this or STDOUT_FILENO
};

[[nodiscard]] Outcome run_command(const std::vector<std::string>& arguments, const Setting& setting = {});
// `assur tune --budget SECONDS` with more arguments; repeated with four times the budget if the machine was too busy.
[[nodiscard]] Outcome run_tuning(int seconds, const std::vector<std::string>& more, const Setting& setting = {});

[[nodiscard]] std::string content(const std::filesystem::path& file);

// A temporary folder for a test.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] std::string file(const std::string& name, const std::string& text) const;  // writes it

 private:
  std::filesystem::path folder_;
};

}  // namespace assur
