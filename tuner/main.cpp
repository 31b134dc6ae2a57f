// The command `assur`: parses the arguments, runs the command, turns exceptions into exit statuses.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "commands/command_line.hpp"
#include "commands/commands.hpp"
#include "output/json.hpp"

namespace {

using namespace assur;
using namespace assur::command;

// CLI11's help without the types that it prints in capitals.
class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { column_width(25); }
  std::string make_option_opts(const CLI::Option* option) const override {
    return option->get_positional() || option->get_type_size() == 0 ? "" : " " + option->get_type_name();
  }
};

Exit exit_of(Error::Kind kind) {
  switch (kind) {
    case Error::Kind::input:
      return kBadInput;
    case Error::Kind::numerical:
      return kNumerical;
    case Error::Kind::environment:
      return kEnvironment;
  }
  return kEnvironment;
}

// Prints "error: " in front of each line, or the JSON object.
Exit report(const Error& error, bool json) {
  if (json) {
    output::print(std::cout, output::to_json(error));
  } else {
    std::istringstream lines(error.what());
    for (std::string line; std::getline(lines, line);) std::cerr << "error: " << line << '\n';
  }
  return exit_of(error.kind());
}

// The chosen command, followed by its subcommand if it has one.
std::vector<const CLI::App*> chosen_commands(const CLI::App& app) {
  std::vector<const CLI::App*> commands;
  for (const CLI::App* command = &app; !command->get_subcommands().empty();) {
    command = command->get_subcommands().front();
    commands.push_back(command);
  }
  return commands;
}

// The message for wrong arguments: that of CLI11, except for unknown options and commands.
std::string explained(const CLI::App& app, const CLI::ParseError& error) {
  const bool unknown = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  const std::vector<const CLI::App*> commands = chosen_commands(app);
  const bool has_commands = commands.empty() || !commands.back()->get_subcommands({}).empty();
  if (!unknown && !has_commands) return error.what();
  const std::vector<std::string> words = app.remaining(true);
  const auto option = std::find_if(words.begin(), words.end(), [](const auto& word) { return word.starts_with("-"); });
  if (option != words.end()) return "there is no option " + *option;
  const std::string within = commands.empty() ? "" : commands.back()->get_name() + " ";
  if (words.empty()) return dynamic_cast<const CLI::RequiredError*>(&error) ? "a command is missing" : error.what();
  return has_commands ? "there is no command " + within + words.front() : "unexpected argument: " + words.front();
}

// Reports bad usage and points to the help.
Exit refuse(const CLI::App& app, const CLI::ParseError& error, bool json) {
  std::string command = "assur";
  for (const CLI::App* chosen : chosen_commands(app)) command += " " + chosen->get_name();
  const Exit status = report(Error(Error::Kind::input, explained(app, error)), json);
  if (!json) std::cerr << "See " << command << " --help.\n";
  return status;
}

int perform(const options::Invocation& call) {
  try {
    check_threads(call.common);
    return call.chosen();
  } catch (const Error& error) {
    return report(error, call.common.json);
  } catch (const std::bad_alloc&) {
    return report(Error(Error::Kind::environment, "out of memory"), call.common.json);
  } catch (const std::system_error& error) {  // no thread, no file
    return report(Error(Error::Kind::environment, error.what()), call.common.json);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::ios::sync_with_stdio(false);
  CLI::App app("Kinematic analysis of multibody systems by group equations.", "assur");
  options::Invocation call;
  app.formatter(std::make_shared<HelpFormatter>());
  app.footer("Exit status: 0 done, 1 numerical failure, 2 bad usage or bad scene,\n3 environment, 130 interrupted.");
  options::add_commands(app, call);
  const bool json = std::any_of(argv, argv + argc, [](const char* word) { return std::strcmp(word, "--json") == 0; });

  int status = kDone;
  try {
    app.parse(argc, argv);
    status = perform(call);
  } catch (const CLI::Success& help_or_version) {
    status = app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    status = refuse(app, error, json);
  }
  std::cout.flush();
  if (!std::cout && status != kEnvironment) {
    std::cerr << "error: cannot write to standard output: " << std::strerror(errno) << '\n';
    return kEnvironment;
  }
  return status;
}
