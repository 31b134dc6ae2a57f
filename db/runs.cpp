// Store: tuning runs, their samples, and models.
#include <SQLiteCpp/VariadicBind.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <utility>

#include "db/checksum.hpp"
#include "db/store_impl.hpp"
#include "db/time.hpp"
#include "db/writer.hpp"
#include "decimal.hpp"
#include "dispatch/impossible.hpp"
#include "dispatch/pace.hpp"

namespace assur::db {
namespace {

// Load of the last minute; -1: unknown.
double load_average() {
  double load = -1;
  return getloadavg(&load, 1) == 1 ? load : -1;
}

// True if another process works on the run. Its number may belong to a different process by now; a new run is then
// begun, which costs only time.
bool is_used_by_another(std::int64_t process) {
  return process != getpid() && (kill(static_cast<pid_t>(process), 0) == 0 || errno == EPERM);
}

// A sample as it is stored: times by the clock, slowness in s; NaN: unknown.
Sample by_the_clock(Sample sample, double pace) {
  if (!std::isnan(pace)) sample = slowed(std::move(sample), sample.slowness);
  sample.slowness *= pace;
  return sample;
}

void check_sample(const Sample& sample, double pace) {
  const auto refuse = [](const std::string& what) { throw Error(Error::Kind::input, "a sample to store: " + what); };
  if (const std::string_view why = why_impossible(sample); !why.empty()) refuse(std::string(why));
  if (!std::isfinite(sample.slowness) || sample.slowness <= 0) refuse("its slowness must be finite and positive");
  const Sample stored = by_the_clock(sample, pace);
  if (const std::string_view why = why_impossible(stored); !why.empty()) refuse("by the clock, " + std::string(why));
  if (!std::isnan(pace) && !is_possible_time(stored.slowness)) {
    refuse("its slowness times the pace must be 1e-15 to 1e9 s, not " + general(stored.slowness, 3) + " s");
  }
  std::uint64_t half = 0;
  const std::string_view uid = sample.uid;
  const bool is_uid =
      uid.size() == 32 && parse_hexadecimal(uid.substr(0, 16), half) && parse_hexadecimal(uid.substr(16), half);
  if (!uid.empty() && !is_uid) refuse("its uid must be 32 hexadecimal digits, not \"" + sample.uid + "\"");
}

void check_changed(int rows, std::int64_t run) {
  if (rows == 0) throw Error(Error::Kind::input, "there is no tuning run " + std::to_string(run));
}

}  // namespace

std::int64_t Store::begin_run(const Host& host, std::string_view profile) {
  return guarded(impl_->file, [&] {
    RunRow row;
    row.run.uid = new_uid();
    row.run.profile = profile;
    row.run.assur = assur_version();
    row.run.started = utc_now();
    row.run.threads = host.machine.budget().threads;
    row.run.load = load_average();
    row.microcode = host.microcode;
    row.process = getpid();
    SQLite::Transaction transaction(impl_->database, SQLite::TransactionBehavior::IMMEDIATE);
    Writer writer(impl_->database);
    const std::int64_t id = writer.run(row, writer.machine(host));
    transaction.commit();
    return id;
  });
}

std::optional<std::int64_t> Store::unfinished_run(const Host& host, std::string_view profile) {
  return guarded(impl_->file, [&]() -> std::optional<std::int64_t> {
    SQLite::Transaction transaction(impl_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement candidates(impl_->database,
                                 "SELECT r.id, r.process FROM tuning_run r JOIN machine m ON m.id = r.machine "
                                 "WHERE r.finished IS NULL AND m.fingerprint = ?1 AND r.profile = ?2 AND r.assur = ?3 "
                                 "ORDER BY r.id DESC");
    SQLite::bind(candidates, host.fingerprint(), std::string(profile), std::string(assur_version()));
    while (candidates.executeStep()) {
      if (is_used_by_another(candidates.getColumn(1).getInt64())) continue;
      const std::int64_t run = candidates.getColumn(0).getInt64();
      candidates.reset();
      SQLite::Statement take(impl_->database, "UPDATE tuning_run SET process = ?2 WHERE id = ?1");
      SQLite::bind(take, run, getpid());
      take.exec();
      transaction.commit();
      return run;
    }
    return std::nullopt;
  });
}

void Store::add(std::int64_t run, std::span<const Sample> samples, double pace) {
  for (const Sample& sample : samples) check_sample(sample, pace);
  guarded(impl_->file, [&] {
    SQLite::Transaction transaction(impl_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement find(impl_->database,
                           "SELECT r.uid, m.fingerprint FROM tuning_run r JOIN machine m ON m.id = r.machine "
                           "WHERE r.id = ?1");
    find.bind(1, run);
    check_changed(find.executeStep() ? 1 : 0, run);
    const std::string uid = find.getColumn(0).getString(), machine = find.getColumn(1).getString();
    find.reset();
    Writer writer(impl_->database);
    for (Sample sample : samples) {
      if (sample.uid.empty()) sample.uid = new_uid();
      writer.sample(by_the_clock(sample, pace), impl_->library(library_name(sample)), run, uid, machine);
    }
    transaction.commit();
  });
}

void Store::finish_run(std::int64_t run, const RunResult& result) {
  guarded(impl_->file, [&] {
    SQLite::Statement finish(impl_->database,
                             "UPDATE tuning_run SET finished = ?2, grade = ?3, seconds = ?4, coverage = ?5, note = ?6 "
                             "WHERE id = ?1");
    SQLite::bind(finish, run, utc_now(), std::string(name(result.grade)), result.seconds, result.coverage, result.note);
    check_changed(finish.exec(), run);
  });
}

std::vector<Run> Store::runs() const {
  return guarded(impl_->file, [&] {
    std::map<std::int64_t, std::int64_t> samples;
    SQLite::Statement count(impl_->database, "SELECT run, count(*) FROM sample GROUP BY run");
    while (count.executeStep()) samples[count.getColumn(0).getInt64()] = count.getColumn(1).getInt64();
    std::vector<Run> runs;
    for (auto& [id, row] : read_tables(impl_->database).runs) {
      runs.push_back(std::move(row.value.run));
      runs.back().samples = samples[id];
    }
    return runs;
  });
}

void Store::put_model(const Host& host, std::string_view name, std::string_view json) {
  guarded(impl_->file, [&] {
    SQLite::Transaction transaction(impl_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement put(impl_->database,
                          "INSERT INTO model (machine, name, made, assur, content) VALUES (?1, ?2, ?3, ?4, ?5) "
                          "ON CONFLICT (machine, name) DO UPDATE SET made = excluded.made, assur = excluded.assur, "
                          "content = excluded.content");
    SQLite::bind(put, Writer(impl_->database).machine(host), std::string(name), utc_now(), std::string(assur_version()),
                 std::string(json));
    put.exec();
    transaction.commit();
  });
}

std::optional<std::string> Store::model(const Host& host, std::string_view name) const {
  return guarded(impl_->file, [&]() -> std::optional<std::string> {
    SQLite::Statement find(impl_->database,
                           "SELECT content FROM model JOIN machine ON machine.id = model.machine "
                           "WHERE fingerprint = ?1 AND model.name = ?2");
    SQLite::bind(find, host.fingerprint(), std::string(name));
    if (!find.executeStep()) return std::nullopt;
    return find.getColumn(0).getString();
  });
}

}  // namespace assur::db
