#include "db/machine_model.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "db/connection.hpp"
#include "db/reader.hpp"
#include "dispatch/impossible.hpp"

namespace assur::db {
namespace {

using Role = DatabaseFile::Role;

constexpr const char* kTune = "; run `assur tune`";

// A readable database, and how close its machines are to this one.
struct Source {
  std::filesystem::path file;
  SQLite::Database database;
  Tables tables;
  std::vector<std::pair<Likeness, std::int64_t>> machines;  // the closest first
};

class Reading {
 public:
  // fingerprint: its beginning; "": that of the host
  Reading(const Host& host, const LibraryAtHand& at_hand, std::string fingerprint = {})
      : host_(host), at_hand_(at_hand), elsewhere_(std::move(fingerprint)) {}

  void open(const DatabaseFile& file);
  MachineModel finish();

 private:
  bool take_level(Likeness level);
  std::vector<Sample> samples_of(Source& source, std::int64_t machine);
  void add(std::vector<Sample> found);
  [[nodiscard]] Likeness likeness_of(const Host& host) const;
  void say_source(const Source& source, std::int64_t machine, Likeness level);
  bool is_at_hand(const Library& library);  // if not, changes_ says why
  void say_counts();
  void say_nothing_fits();
  void say(std::string text) { messages_.push_back(std::move(text)); }

  const Host& host_;
  const LibraryAtHand& at_hand_;
  const std::string elsewhere_;  // fingerprint of the machine that is asked for; "": this one
  std::vector<Source> sources_;
  std::vector<Sample> samples_;
  std::unordered_set<std::string> uids_;  // of samples_, if there are several files
  std::string source_;
  std::int64_t seen_ = 0, stale_ = 0, impossible_ = 0;  // samples
  std::set<std::string> changes_;                       // "klu was 1.3.9, is 2.0.0"
  std::vector<std::string> messages_;
};

std::int64_t difference_in_cores(const Host& a, const Host& b) {
  return std::abs(static_cast<std::int64_t>(a.machine.cores.size()) -
                  static_cast<std::int64_t>(b.machine.cores.size()));
}

void Reading::open(const DatabaseFile& file) {
  try {
    guarded(file.file, [&] {
      SQLite::Database database = open_to_read(file.file);
      // One consistent state of the file. Each page is read once, so a small cache reuses the same memory.
      database.exec("PRAGMA cache_size = 16; BEGIN");
      Source source{file.file, std::move(database), {}, {}};
      source.tables = read_tables(source.database);
      for (const auto& [id, host] : source.tables.machines) source.machines.emplace_back(likeness_of(host), id);
      std::sort(source.machines.begin(), source.machines.end(), [&](const auto& a, const auto& b) {
        const auto rank = [&](const auto& m) {
          return std::tuple(m.first, difference_in_cores(host_, source.tables.machines.at(m.second)), -m.second);
        };
        return rank(a) < rank(b);
      });
      sources_.push_back(std::move(source));
    });
  } catch (const Unusable& unusable) {
    if (unusable.trouble() != Trouble::absent || file.role == Role::named) say(unusable.what());
  }
}

Likeness Reading::likeness_of(const Host& host) const {
  if (elsewhere_.empty()) return likeness(host_, host);
  return host.fingerprint().starts_with(elsewhere_) ? Likeness::same : Likeness::none;
}

bool Reading::is_at_hand(const Library& library) {
  if (!elsewhere_.empty()) return true;
  const Library now = at_hand_(library.name);
  if (library == now) return true;
  changes_.insert(now.version.empty() ? library.name + " is not available"
                  : library.version != now.version
                      ? library.name + " was " + library.version + ", is " + now.version
                      : library.name + " was built by " + library.build + ", is by " + now.build);
  return false;
}

// Samples of libraries that are installed here.
std::vector<Sample> Reading::samples_of(Source& source, std::int64_t machine) {
  std::vector<std::int64_t> runs;
  for (const auto& [id, run] : source.tables.runs) {
    if (run.value.machine == machine) runs.push_back(id);
  }
  if (runs.empty()) return {};
  if (runs.size() == source.tables.runs.size()) runs.clear();  // all runs: reading in the order of the table is faster
  Samples samples = read_samples(source.database, source.tables, runs);
  at_usual_pace(samples, source.tables);
  seen_ += static_cast<std::int64_t>(samples.rows.size());
  std::map<std::int64_t, bool> holds;
  std::vector<Sample> good;
  good.reserve(samples.rows.size());
  for (SampleRow& row : samples.rows) {
    const auto [at, is_new] = holds.try_emplace(row.library);
    if (is_new) at->second = is_at_hand(source.tables.libraries.at(row.library).value);
    if (!at->second) {
      ++stale_;
    } else if (!why_impossible(row.sample).empty()) {
      ++impossible_;
    } else {
      good.push_back(std::move(row.sample));
    }
  }
  return good;
}

// Takes this machine from all files, but a similar one only from the first file that has one, so that all samples are
// of one machine.
bool Reading::take_level(Likeness level) {
  for (Source& source : sources_) {
    for (const auto& [likeness, machine] : source.machines) {
      if (likeness != level || (level != Likeness::same && !samples_.empty())) continue;
      try {
        std::vector<Sample> found = guarded(source.file, [&, id = machine] { return samples_of(source, id); });
        if (found.empty()) continue;
        add(std::move(found));
        say_source(source, machine, level);
      } catch (const Unusable& unusable) {
        say(unusable.what());
        source.machines.clear();  // nothing else in this file is used
        break;
      }
    }
  }
  return !samples_.empty();
}

// Omits copies: one file may have imported the other.
void Reading::add(std::vector<Sample> found) {
  if (sources_.size() == 1) {
    samples_ = std::move(found);
    return;
  }
  for (Sample& sample : found) {
    if (uids_.insert(sample.uid).second) samples_.push_back(std::move(sample));
  }
}

void Reading::say_source(const Source& source, std::int64_t machine, Likeness level) {
  if (!source_.empty()) {
    source_ += " and " + source.file.string();
  } else if (!elsewhere_.empty()) {
    source_ = "measured on " + to_string(source.tables.machines.at(machine)) + ": " + source.file.string();
  } else if (level == Likeness::same) {
    source_ = "measured on this machine: " + source.file.string();
  } else {
    source_ = "measured on " + to_string(source.tables.machines.at(machine)) +
              (level == Likeness::processor ? ", the same processor with other cores, quota, caches or nodes: "
                                            : ", the same microarchitecture, another processor: ") +
              source.file.string();
    say("there are no samples of this machine, " + to_string(host_) + "; the samples used were " + source_ + kTune);
  }
}

void Reading::say_counts() {
  const auto left_out = [&](std::int64_t count, const std::string& because) {
    if (count == 0) return;
    say(std::to_string(count) + " of " + std::to_string(seen_) + " samples are left out, because " + because + kTune);
  };
  std::string changes;
  for (const std::string& change : changes_) changes += (changes.empty() ? "" : "; ") + change;
  left_out(stale_, "their libraries changed (" + changes + ")");
  left_out(impossible_, "their times at the usual pace are not 1e-15 to 1e9 s");
}

void Reading::say_nothing_fits() {
  for (const Source& source : sources_) {
    const bool strange = std::all_of(source.machines.begin(), source.machines.end(),
                                     [](const auto& machine) { return machine.first == Likeness::none; });
    if (source.machines.empty() || !strange) continue;
    say(source.file.string() + ": was tuned for " +
        to_string(source.tables.machines.at(source.machines.front().second)) + ", not for this machine, " +
        to_string(host_) + "; its samples are not used" + kTune);
  }
}

MachineModel Reading::finish() {
  const bool found =
      take_level(Likeness::same) || take_level(Likeness::processor) || take_level(Likeness::microarchitecture);
  if (!found && elsewhere_.empty()) say_nothing_fits();
  say_counts();
  return {std::make_shared<const PerformanceModel>(std::move(samples_), std::move(source_)), std::move(messages_)};
}

}  // namespace

MachineModel read_machine_model(std::span<const DatabaseFile> files, const Host& host,
                                const LibraryAtHand& library_at_hand) {
  Reading reading(host, library_at_hand);
  for (const DatabaseFile& file : files) reading.open(file);
  return reading.finish();
}

MachineModel read_model_of(std::span<const DatabaseFile> files, const std::string& fingerprint) {
  const Host any;
  const LibraryAtHand none;
  Reading reading(any, none, fingerprint);
  for (const DatabaseFile& file : files) reading.open(file);
  return reading.finish();
}

}  // namespace assur::db

namespace assur {
namespace {

MachineModel read() {
  const auto files = db::database_files();
  if (files.empty()) return {std::make_shared<const PerformanceModel>(), {}};
  return db::read_machine_model(files, db::this_host(), db::library_at_hand);
}

}  // namespace

const MachineModel& machine_model() {
  static const MachineModel kModel = read();
  return kModel;
}

}  // namespace assur
