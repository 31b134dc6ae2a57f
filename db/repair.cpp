#include "db/repair.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <optional>

#include "db/places.hpp"
#include "db/time.hpp"
#include "db/writer.hpp"

namespace assur::db {
namespace {

namespace fs = std::filesystem;

// Held while a damaged file is renamed, so that a second process does not rename the repaired file.
class RepairLock {
 public:
  explicit RepairLock(const fs::path& file) : name_(file.string() + ".lock") {
    descriptor_ = ::open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (descriptor_ < 0 || flock(descriptor_, LOCK_EX) != 0) {
      throw Unusable(Trouble::blocked, file, "is damaged, and its folder cannot be written to repair it");
    }
  }
  ~RepairLock() { ::close(descriptor_); }  // the lock file stays, because waiting processes hold it open
  RepairLock(const RepairLock&) = delete;
  RepairLock& operator=(const RepairLock&) = delete;

 private:
  std::string name_;
  int descriptor_ = -1;
};

// Opens the file if it is undamaged. If empty, `why` says what is damaged.
std::optional<SQLite::Database> open_if_whole(const fs::path& file, std::string& why) {
  try {
    return guarded(file, [&]() -> std::optional<SQLite::Database> {
      SQLite::Database database = open_to_write(file, is_on_network(file));
      const auto findings = structural_damage(database);
      if (!findings.empty()) {
        why = file.string() + ": " + findings.front();
        return std::nullopt;
      }
      const Samples samples = read_all(database).samples;
      if (samples.damaged == 0 && samples.lost == 0) return database;
      why = file.string() + ": " + std::to_string(samples.damaged + samples.lost) + " samples are " +
            (samples.lost == 0      ? "damaged"
             : samples.damaged == 0 ? "lost"
                                    : "damaged or lost");
      return std::nullopt;
    });
  } catch (const Unusable& unusable) {
    if (unusable.trouble() != Trouble::damaged) throw;
    why = unusable.what();
    return std::nullopt;
  }
}

// The log holds content that is not yet in the file, so it is renamed as well.
fs::path put_aside(const fs::path& file) {
  fs::path aside = file.string() + ".corrupt-" + utc_now("%Y%m%dT%H%M%SZ");
  for (int number = 2; fs::exists(aside); ++number) {
    aside = file.string() + ".corrupt-" + utc_now("%Y%m%dT%H%M%SZ") + "-" + std::to_string(number);
  }
  for (const char* suffix : {"-wal", "-shm", "-journal"}) {
    std::error_code none;
    fs::rename(file.string() + suffix, aside.string() + suffix, none);
  }
  std::error_code error;
  fs::rename(file, aside, error);
  if (error) throw Unusable(Trouble::blocked, file, "is damaged and cannot be put aside: " + error.message());
  return aside;
}

// Empty if the file cannot be opened at all.
Copied salvage(const fs::path& aside, SQLite::Database& target) {
  Contents contents;
  try {
    SQLite::Database damaged = open_to_salvage(aside);
    contents = read_all(damaged, Care::salvaging);
  } catch (const SQLite::Exception&) {
  } catch (const Unusable&) {
  }
  for (const char* suffix : {"-wal", "-shm"}) {  // made by reading; a log with content belongs to the file
    std::error_code none;
    const fs::path part = aside.string() + suffix;
    if (std::string_view(suffix) == "-shm" || fs::file_size(part, none) == 0) fs::remove(part, none);
  }
  return copy(contents, target);
}

}  // namespace

std::vector<std::string> structural_damage(SQLite::Database& database) {
  std::vector<std::string> findings;
  SQLite::Statement check(database, "PRAGMA integrity_check(10)");
  while (check.executeStep()) {
    const std::string finding = check.getColumn(0).getString();
    if (finding != "ok") findings.push_back(finding);
  }
  SQLite::Statement references(database, "PRAGMA foreign_key_check");
  if (references.executeStep()) {
    findings.push_back("rows of " + references.getColumn(0).getString() + " refer to missing rows");
  }
  return findings;
}

SQLite::Database open_whole(const fs::path& file, std::vector<std::string>& messages) {
  std::string why;
  if (auto database = open_if_whole(file, why)) return std::move(*database);
  const RepairLock lock(file);
  if (auto database = open_if_whole(file, why)) return std::move(*database);  // another process was faster
  const fs::path aside = put_aside(file);
  return guarded(file, [&] {
    SQLite::Database database = open_to_write(file, is_on_network(file));
    const Copied saved = salvage(aside, database);
    messages.push_back(why + ". It was renamed to " + aside.string() + "; " + std::to_string(saved.samples) +
                       " good samples were copied to a new file");
    return database;
  });
}

Copied copy(const Contents& contents, SQLite::Database& target) {
  const auto& [tables, samples] = contents;
  Copied copied;
  SQLite::Transaction transaction(target, SQLite::TransactionBehavior::IMMEDIATE);
  Writer writer(target);
  std::map<std::int64_t, std::int64_t> runs;  // id in `contents` -> id in `target`
  for (const auto& [id, run] : tables.runs) {
    runs[id] = writer.run(run.value, writer.machine(tables.machines.at(run.value.machine)));
  }
  for (const SampleRow& row : samples.rows) {
    const Run& run = tables.runs.at(row.run).value.run;
    const Library& library = tables.libraries.at(row.library).value;
    const bool is_new = writer.sample(row.sample, library, runs.at(row.run), run.uid, run.machine);
    ++(is_new ? copied.samples : copied.known);
  }
  transaction.commit();
  return copied;
}

}  // namespace assur::db
