// A tuning database: what was measured, where, and with which libraries. All SQL of the library is in this folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "assur/performance.hpp"
#include "db/host.hpp"
#include "numbers.hpp"

namespace assur::db {

enum class Access : std::uint8_t {
  read,   // nothing is written, no lock is kept longer than a call
  write,  // made if it is not there, brought to the present schema if it is older, repaired if it is damaged
};

enum class Grade : std::uint8_t { good, fair, noisy };  // of a tuning run: how much its times scatter

[[nodiscard]] std::string_view name(Grade grade) noexcept;

// Row of the table tuning_run.
struct Run {
  std::int64_t id = 0;
  std::string uid;           // 32 hexadecimal digits
  std::string machine;       // its fingerprint
  std::string profile;       // "quick", ...: as the tuner calls it
  std::string assur;         // version that measured
  std::string started;       // UTC, "2026-11-21T18:04:05Z"
  std::int32_t threads = 1;  // budget
  double load = 0;           // average of the last minute, at its start
  bool finished = false;     // what follows is only then set
  std::string grade;
  double seconds = 0;   // that it took
  double coverage = 0;  // of what was planned, 0 to 1
  std::string note;
  std::int64_t samples = 0;
};

struct RunResult {
  Grade grade = Grade::good;
  double seconds = 0;
  double coverage = 1;
  std::string note = {};
};

// Empty: all.
struct Filter {
  std::optional<std::int64_t> run = {};  // Run::id
  std::string machine = {};              // fingerprint, or its beginning
  std::string library = {};              // name: of a backend, or "assur"
  std::optional<Kernel> kernel = {};
};

using Value = std::variant<std::monostate, std::int64_t, double, std::string>;  // monostate: not known

// What a question to the database gives.
struct Answer {
  std::vector<std::string> columns;
  std::vector<std::vector<Value>> rows;  // each as long as columns
};

struct Health {
  std::int64_t samples = 0;           // good ones
  std::int64_t damaged = 0;           // samples whose checksum differs
  std::int64_t lost = 0;              // samples that were stored, and are not there
  std::int64_t unknown = 0;           // of a kernel or strategy that this version does not know
  std::int64_t stale = 0;             // good ones of another version of their library than the one at hand
  std::vector<std::string> findings;  // of the file's structure
};

struct Forgotten {
  std::int64_t samples = 0, runs = 0;
};

struct Imported {
  std::int64_t samples = 0;  // new
  std::int64_t known = 0;    // already here
  std::int64_t damaged = 0;  // left there
};

// One connection to one file; one thread at a time. Everything throws Error (environment) that names the file if it
// cannot be read or written: no space, no permission, not a tuning database, newer than this library, locked by
// another process for a minute (to read: a second). A call that throws has changed nothing.
class Store {
 public:
  explicit Store(std::filesystem::path file, Access access);
  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;
  ~Store();

  [[nodiscard]] const std::filesystem::path& file() const;
  // What opening it has found and done, for people: damage, where the damaged file is now, what was saved of it.
  [[nodiscard]] const std::vector<std::string>& messages() const;

  // A new tuning run on this host; its load and the versions of the libraries are noted.
  std::int64_t begin_run(const Host& host, std::string_view profile);
  // The last run of this profile, by this version of assur and on this very host, that was never finished and that no
  // other process is working on, which now is this one's: go on with it, and skip what it has().
  [[nodiscard]] std::optional<std::int64_t> unfinished_run(const Host& host, std::string_view profile);
  // All of them or none, in one transaction that survives the process. A sample without uid gets one; one that is there
  // already, by its uid, stays. pace: s that the fixed work takes where their slowness is 1; NaN: not known, as their
  // slowness then is. Throws Error (input) for a time, spread, slowness or uid that is none, or an unknown run.
  void add(std::int64_t run, std::span<const Sample> samples, double pace = kNan);
  // s that the fixed work usually takes on this host, with this build of assur; nullopt: no sample tells it.
  [[nodiscard]] std::optional<double> usual_pace(const Host& host) const;
  void finish_run(std::int64_t run, const RunResult& result);
  // With the library that is at hand.
  [[nodiscard]] bool has(std::int64_t run, Kernel kernel, const Shape& shape, const Strategy& strategy) const;

  // In the order in which they were added; damaged ones are left out.
  [[nodiscard]] std::vector<Sample> samples(const Filter& filter = {}) const;
  [[nodiscard]] std::vector<Run> runs() const;

  // What was learned from the samples of a machine, as JSON: what was fitted, regret on samples held out, ... The
  // runtime does not read it. One for each name; the new one takes the place of the old.
  void put_model(const Host& host, std::string_view name, std::string_view json);
  [[nodiscard]] std::optional<std::string> model(const Host& host, std::string_view name) const;

  // For people; seconds in best and crossovers are those of one instance. Filter::run and library are for samples only.
  [[nodiscard]] Answer sample_rows(const Filter& filter = {}) const;
  [[nodiscard]] Answer best(const Filter& filter = {}) const;
  [[nodiscard]] Answer crossovers(const Filter& filter = {}) const;
  [[nodiscard]] Answer models() const;

  // Looks at every row; of damage that opening it to write would repair.
  [[nodiscard]] Health health() const;

  // What fits all of the filter, then runs and the like that nothing refers to any more. An empty filter is refused:
  // forget_all() is for that.
  Forgotten forget(const Filter& filter);
  Forgotten forget_all();

  // Good rows that fit the filter, into a new file that is ready to be read where nobody may write. Throws Error
  // (environment) if it exists.
  std::int64_t export_to(const std::filesystem::path& file, const Filter& filter = {}) const;
  // Good rows of another database, but those that are here by their uid.
  Imported import_from(const std::filesystem::path& file);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// 32 hexadecimal digits, drawn at random.
[[nodiscard]] std::string new_uid();

}  // namespace assur::db
