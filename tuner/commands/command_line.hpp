// The options of each command: names, values, and the members that they set.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "commands/commands.hpp"

namespace assur::options {

// The result of parsing for main(): options by command, and the chosen command.
struct Invocation {
  command::Common common;
  command::ImportOptions model;
  command::InspectOptions inspect;
  command::RunOptions run;
  command::SweepOptions sweep;
  command::CompareOptions compare;
  command::PlanOptions plan;
  command::DbOptions db;
  command::TuneOptions tune;
  command::CheckOptions check;
  command::ReportOptions report;
  std::function<int()> chosen;
};

// Adds all commands with their options. Parsing fills `call`, which must outlive `app`.
void add_commands(CLI::App& app, Invocation& call);

}  // namespace assur::options
