// Data about this machine that exist before the report measures anything.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assur/machine.hpp"
#include "assur/performance.hpp"
#include "db/database_files.hpp"
#include "db/store.hpp"

namespace assur::report {

// The last finished tuning run that was not restricted to scenes.
struct TuningRecord {
  std::string file;  // database
  db::Run run;
  std::vector<Sample> samples;  // in the order in which they were stored
  db::Answer crossovers;        // crossovers of all samples of this machine in the database
};

struct Knowledge {
  Machine machine;
  db::Host host;
  MachineModel known;                  // the model of `auto`
  std::optional<TuningRecord> tuning;  // empty: this machine was not tuned
};

// Collects the data. Throws Error (environment) if a named database exists but cannot be read.
[[nodiscard]] Knowledge knowledge(MachineModel known, std::span<const db::DatabaseFile> databases);

// Facts for the head of the page: machine, versions, date; name and text.
using Facts = std::vector<std::pair<std::string, std::string>>;
[[nodiscard]] Facts facts(const Knowledge& knowledge, int threads, const std::string& date);

// A notice with advice if the machine was not tuned; else "".
[[nodiscard]] std::string how_to_tune(const Knowledge& knowledge);

}  // namespace assur::report
