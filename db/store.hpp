// The tuning database: measurements with their machines and libraries. All SQL of the library is in this folder.
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
  read,   // writes nothing, and keeps no lock longer than a call
  write,  // makes a missing file; puts a damaged file, or one of an older schema, aside and begins a new one
};

enum class Grade : std::uint8_t { good, fair, noisy };  // quality of a tuning run: scatter of its times

[[nodiscard]] std::string_view name(Grade grade) noexcept;

// A row of the table tuning_run.
struct Run {
  std::int64_t id = 0;
  std::string uid;           // 32 hexadecimal digits
  std::string machine;       // fingerprint
  std::string profile;       // name of the profile of the tuner: "quick", ...
  std::string assur;         // version of assur that measured
  std::string started;       // UTC, "2026-11-21T18:04:05Z"
  std::int32_t threads = 1;  // budget
  double load = 0;           // average load of the last minute, at the start
  bool finished = false;     // true: the following members are set
  std::string grade;
  double seconds = 0;   // duration
  double coverage = 0;  // measured part of the plan, 0 to 1
  std::string note;
  std::int64_t samples = 0;
};

struct RunResult {
  Grade grade = Grade::good;
  double seconds = 0;
  double coverage = 1;
  std::string note = {};
};

// Selection of samples; an empty member selects all.
struct Filter {
  std::optional<std::int64_t> run = {};  // Run::id
  std::string machine = {};              // fingerprint, or its beginning
  std::string library = {};              // name: of a backend, or "assur"
  std::optional<Kernel> kernel = {};
  std::string strategy = {};           // part of its text
  std::optional<std::int32_t> n = {};  // unknowns
};

using Value = std::variant<std::monostate, std::int64_t, double, std::string>;  // monostate: unknown

// The result of a query.
struct Answer {
  std::vector<std::string> columns;
  std::vector<std::vector<Value>> rows;  // each as long as columns
};

struct Counts {
  std::int64_t samples = 0;
  std::int64_t unknown = 0;  // samples of a kernel or strategy that this version does not know
  std::int64_t stale = 0;    // samples of this machine, but of another version of their library
};

struct Forgotten {
  std::int64_t samples = 0, runs = 0;
};

struct Imported {
  std::int64_t samples = 0;  // new
  std::int64_t known = 0;    // already in this database
};

// A connection to a file, for one thread at a time. The constructor checks all of the file. All functions throw Error
// (environment), which names the file, if it cannot be read or written: no space, no permission, no tuning database, of
// another version, damaged, or locked by another process for a minute (reading: a second). A call that throws changes
// nothing.
class Store {
 public:
  explicit Store(std::filesystem::path file, Access access);
  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;
  ~Store();

  [[nodiscard]] const std::filesystem::path& file() const;
  // Notes for people about opening the file: why a file was put aside, and its new name.
  [[nodiscard]] const std::vector<std::string>& messages() const;

  // Begins a tuning run on this host; stores its load and the versions of the libraries. Returns its id.
  std::int64_t begin_run(const Host& host, std::string_view profile);
  // Takes over the last unfinished run of this profile by this version of assur on this host, unless another process
  // works on it. Continue the run, and skip the cells whose samples it has.
  [[nodiscard]] std::optional<std::int64_t> unfinished_run(const Host& host, std::string_view profile);
  // Stores all samples, or none of them, in one transaction that survives the process. A sample without uid gets one; a
  // sample whose uid exists already is not changed. pace: time of the fixed work at slowness 1, s; NaN: it and the
  // slowness are unknown. Throws Error (input) for an impossible figure (why_impossible()), an invalid slowness
  // or uid, or an unknown run.
  void add(std::int64_t run, std::span<const Sample> samples, double pace = kNan);
  // Usual time of the fixed work on this host with this build of assur, s; empty if no sample has it.
  [[nodiscard]] std::optional<double> usual_pace(const Host& host) const;
  void finish_run(std::int64_t run, const RunResult& result);

  // In the order in which they were added.
  [[nodiscard]] std::vector<Sample> samples(const Filter& filter = {}) const;
  [[nodiscard]] std::vector<Run> runs() const;

  // Results that were derived from the samples of a machine, as JSON: fits, the regret on held-out samples, ... The
  // library does not read them. A new model replaces an old one with the same name.
  void put_model(const Host& host, std::string_view name, std::string_view json);
  [[nodiscard]] std::optional<std::string> model(const Host& host, std::string_view name) const;

  // Tables for people. Seconds of best() and crossovers() are those of one instance. Filter::run, library, strategy
  // and n select samples only.
  [[nodiscard]] Answer sample_rows(const Filter& filter = {}) const;
  [[nodiscard]] Answer best(const Filter& filter = {}) const;
  [[nodiscard]] Answer crossovers(const Filter& filter = {}) const;
  [[nodiscard]] Answer models() const;

  // machine: fingerprint of this machine; "": nothing is stale.
  [[nodiscard]] Counts counts(const std::string& machine = {}) const;

  // Deletes the selected samples, then runs and other rows that no sample refers to. Throws Error (input) for an empty
  // filter, use forget_all(), and for one with a strategy or n.
  Forgotten forget(const Filter& filter);
  Forgotten forget_all();

  // Copies selected samples to a new file, which can be read from read-only places. Throws Error (environment) if the
  // file exists.
  std::int64_t export_to(const std::filesystem::path& file, const Filter& filter = {}) const;
  // Copies the samples of another database whose uid does not exist here.
  Imported import_from(const std::filesystem::path& file);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Throws Unusable if the file cannot be opened for reading. Its rows are not checked.
void require_readable(const std::filesystem::path& file);

// 32 hexadecimal digits, drawn at random.
[[nodiscard]] std::string new_uid();

}  // namespace assur::db
