// The options of each command: what they are called, what they accept, and where they go.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "commands/commands.hpp"

namespace assur::options {

// What main() needs to know after parsing: options by command, and the command chosen.
struct Invocation {
  command::Common common;
  command::InspectOptions inspect;
  command::RunOptions run;
  command::CompareOptions compare;
  command::PlanOptions plan;
  command::DbOptions db;
  command::TuneOptions tune;
  command::CheckOptions check;
  command::ReportOptions report;
  std::function<int()> chosen;
};

// All commands, with their options. Parsing fills `call`, which has to outlive `app`.
void add_commands(CLI::App& app, Invocation& call);

}  // namespace assur::options
