// Rows of a database as values, each verified by its checksum.
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

enum class Care : std::uint8_t {
  trusting,   // the first thing that cannot be read is thrown
  salvaging,  // whatever can be read of a damaged file
};

// Whether samples have their uids: only those need them who hand samples on.
enum class Uids : std::uint8_t { read, left_out };

// A row together with the checksum of what it says.
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
  std::int64_t samples = 0;  // as they were counted; 0 in files of an older schema
};

// Of the sample times are as the clock had them, and the slowness is in s of the fixed work; NaN: it is not known.
struct SampleRow {
  Sample sample;
  std::int64_t id = 0, run = 0, library = 0;
};

// The small tables, which samples refer to.
struct Tables {
  std::map<std::int64_t, Host> machines;
  std::map<std::int64_t, Checked<RunRow>> runs;  // without those whose machine is missing
  std::unordered_map<std::int64_t, Checked<Library>> libraries;
  std::unordered_map<std::int64_t, Checked<Shape>> shapes;
  std::unordered_map<std::int64_t, Checked<std::optional<Strategy>>> strategies;  // empty: of a grammar to come
};

struct Samples {
  std::vector<SampleRow> rows;
  std::int64_t damaged = 0;  // their checksum differs, or what they refer to is missing
  std::int64_t unknown = 0;  // whole, but of a kernel or a strategy that this version does not know
  std::int64_t lost = 0;     // that were counted when they were stored, and are not there
};

// All tables but that of samples; or first where samples come from (machines, runs, libraries), and what they are of
// (shapes, strategies) only once they are read. Throw SQLite::Exception.
[[nodiscard]] Tables read_tables(SQLite::Database& database, Care care = Care::trusting);
[[nodiscard]] Tables read_origins(SQLite::Database& database, Care care = Care::trusting);
void read_subjects(SQLite::Database& database, Tables& tables, Care care = Care::trusting);

// Of these runs, or of all if there are none. Throws SQLite::Exception.
[[nodiscard]] Samples read_samples(SQLite::Database& database, const Tables& tables, Care care, Uids uids,
                                   std::span<const std::int64_t> runs = {});

struct Contents {
  Tables tables;
  Samples samples;
};

// All of it, as of one moment whatever others write. Throws SQLite::Exception.
[[nodiscard]] Contents read_all(SQLite::Database& database, Care care = Care::trusting);

// As everybody else has samples: their times at the machine's usual pace, and their slowness relative to it, 1 where it
// is not known. All samples of a machine, version and build together tell what is usual: a wrong one scales no other.
void at_usual_pace(Samples& samples, const Tables& tables);
// s of the fixed work; nullopt: no sample of this machine (its id), version of assur and build tells it.
[[nodiscard]] std::optional<double> usual_pace(const Contents& contents, std::int64_t machine, std::string_view assur,
                                               std::string_view build);

// What the column sample.checksum holds.
[[nodiscard]] std::int64_t checksum(const Sample& sample, const Library& library, const std::string& run,
                                    const std::string& machine);

// The column machine.caches.
[[nodiscard]] std::string to_text(const std::vector<Cache>& caches);

}  // namespace assur::db
