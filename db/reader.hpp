// Reads the rows of a database. Checksums verify each row; one bad row makes the whole file a damaged one.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "db/host.hpp"
#include "db/libraries.hpp"
#include "db/store.hpp"

namespace assur::db {

// A row with the checksum of its content.
template <class Value>
struct Checked {
  Value value;
  std::uint64_t sum = 0;
};

// A row of tuning_run, with all its columns.
struct RunRow {
  Run run;
  std::int64_t machine = 0, process = 0;
  std::string microcode, finished;
  std::int64_t samples = 0;  // number that triggers counted
};

// A row of the table sample. Times of the sample are by the clock; its slowness is the time of the fixed work in s, NaN
// if unknown.
struct SampleRow {
  Sample sample;
  std::int64_t id = 0, run = 0, library = 0;
};

// The small tables, which samples refer to.
struct Tables {
  std::map<std::int64_t, Host> machines;
  std::map<std::int64_t, Checked<RunRow>> runs;
  std::unordered_map<std::int64_t, Checked<Library>> libraries;
  std::unordered_map<std::int64_t, Checked<Shape>> shapes;
  std::unordered_map<std::int64_t, Checked<std::optional<Strategy>>>
      strategies;  // empty: of a later version of the grammar
};

struct Samples {
  std::vector<SampleRow> rows;
  std::int64_t unknown = 0;  // left out, because this version does not know their kernel or strategy
};

struct Contents {
  Tables tables;
  Samples samples;
};

// The following functions throw SQLite::Exception: SQLITE_CORRUPT for a row whose checksum differs, which refers to a
// missing row, or whose figures are impossible, and if a run has fewer samples than were stored.

// Reads all tables except samples.
[[nodiscard]] Tables read_tables(SQLite::Database& database);
// Reads the samples of these runs; of all runs if the list is empty.
[[nodiscard]] Samples read_samples(SQLite::Database& database, const Tables& tables,
                                   std::span<const std::int64_t> runs = {});
// Reads everything as it is at one moment, even if other processes write meanwhile.
[[nodiscard]] Contents read_all(SQLite::Database& database);
// Checks the structure of the file and all rows.
void check_all(SQLite::Database& database);
// Converts samples to the form of assur::Sample: times at the usual pace of the machine, slowness relative to it, 1 if
// unknown. The usual pace follows from all samples of a machine, version and build, so that one wrong sample hardly
// affects the others.
void at_usual_pace(Samples& samples, const Tables& tables);

// Content of the column sample.checksum.
[[nodiscard]] std::int64_t checksum(const Sample& sample, const Library& library, const std::string& run,
                                    const std::string& machine);

// Content of the column machine.caches.
[[nodiscard]] std::string to_text(const std::vector<Cache>& caches);

}  // namespace assur::db
