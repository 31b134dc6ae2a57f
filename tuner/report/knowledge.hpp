// What is known of this machine before anything is measured for the report.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assur/machine.hpp"
#include "assur/performance.hpp"
#include "db/places.hpp"
#include "db/store.hpp"

namespace assur::report {

// The last finished run that looked at everything, not at one scene alone.
struct TuningRecord {
  std::string file;  // database
  db::Run run;
  std::vector<Sample> samples;  // in the order in which they were stored
  db::Answer crossovers;        // of all that the database knows of this machine
};

struct Knowledge {
  Machine machine;
  db::Host host;
  MachineModel known;                  // what `auto` goes by
  std::optional<TuningRecord> tuning;  // empty: this very machine was not tuned
};

// Throws Error (environment) as a Store does for one that was named, is there, and cannot be read.
[[nodiscard]] Knowledge knowledge(MachineModel known, std::span<const db::DatabaseFile> databases);

// The head of the page: what was measured on, with what, when; name and text.
using Facts = std::vector<std::pair<std::string, std::string>>;
[[nodiscard]] Facts facts(const Knowledge& knowledge, int threads, const std::string& date);

// Where nothing was measured: that, and what to do about it; else empty.
[[nodiscard]] std::string how_to_tune(const Knowledge& knowledge);

}  // namespace assur::report
