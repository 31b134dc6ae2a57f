#include "db/writer.hpp"

#include <cmath>

#include "db/checksum.hpp"

namespace assur::db {
namespace {

// Binds parameters ?1, ?2, ... in the order of the arguments; NaN becomes NULL.
void bind_one(SQLite::Statement& statement, int place, double value) {
  if (std::isnan(value)) {
    statement.bind(place);
  } else {
    statement.bind(place, value == 0 ? 0.0 : value);
  }
}
void bind_one(SQLite::Statement& statement, int place, std::int64_t value) { statement.bind(place, value); }
void bind_one(SQLite::Statement& statement, int place, std::int32_t value) { statement.bind(place, value); }
void bind_one(SQLite::Statement& statement, int place, const std::string& value) { statement.bind(place, value); }

template <class... Values>
SQLite::Statement& bound(SQLite::Statement& statement, const Values&... values) {
  statement.reset();
  statement.clearBindings();
  int place = 0;
  (bind_one(statement, ++place, values), ...);
  return statement;
}

std::int64_t the_id(SQLite::Statement& statement) {
  if (!statement.executeStep()) throw SQLite::Exception("a row that was just written is missing");
  const std::int64_t id = statement.getColumn(0).getInt64();
  statement.reset();
  return id;
}

}  // namespace

SQLite::Statement& Writer::prepared(const char* sql) {
  return statements_.try_emplace(sql, database_, sql).first->second;
}

std::int64_t Writer::machine(const Host& host) {
  static constexpr const char* kInsert =
      "INSERT INTO machine (fingerprint, vendor, family, model, stepping, name, instructions, cores, processors, "
      "quota, caches, numa_nodes, memory) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13) "
      "ON CONFLICT DO NOTHING";
  static constexpr const char* kFind = "SELECT id FROM machine WHERE fingerprint = ?1";
  const Machine& m = host.machine;
  const std::string fingerprint = host.fingerprint();
  bound(prepared(kInsert), fingerprint, host.vendor, host.family, host.model, host.stepping, m.model, m.instructions,
        static_cast<std::int64_t>(m.cores.size()), m.processors, m.quota, to_text(m.caches), m.numa_nodes, host.memory)
      .exec();
  return the_id(bound(prepared(kFind), fingerprint));
}

std::int64_t Writer::library(const Library& library) {
  static constexpr const char* kInsert =
      "INSERT INTO library (name, version, build) VALUES (?1, ?2, ?3) ON CONFLICT DO NOTHING";
  static constexpr const char* kFind = "SELECT id FROM library WHERE name = ?1 AND version = ?2 AND build = ?3";
  bound(prepared(kInsert), library.name, library.version, library.build).exec();
  return the_id(bound(prepared(kFind), library.name, library.version, library.build));
}

std::int64_t Writer::run(const RunRow& row, std::int64_t machine) {
  static constexpr const char* kInsert =
      "INSERT INTO tuning_run (uid, machine, profile, assur, started, threads, load, microcode, process) "
      "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9) ON CONFLICT DO NOTHING";
  static constexpr const char* kFinish =
      "UPDATE tuning_run SET finished = ?2, grade = ?3, seconds = ?4, coverage = ?5, note = ?6 "
      "WHERE uid = ?1 AND finished IS NULL";
  static constexpr const char* kFind = "SELECT id FROM tuning_run WHERE uid = ?1";
  const Run& r = row.run;
  bound(prepared(kInsert), r.uid, machine, r.profile, r.assur, r.started, r.threads, r.load, row.microcode, row.process)
      .exec();
  if (r.finished) bound(prepared(kFinish), r.uid, row.finished, r.grade, r.seconds, r.coverage, r.note).exec();
  return the_id(bound(prepared(kFind), r.uid));
}

std::int64_t Writer::shape(const Shape& s) {
  static constexpr const char* kInsert =
      "INSERT INTO shape (n, nnz, groups, rhs, fill, operations, depth, terms, pattern) "
      "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9) ON CONFLICT DO NOTHING";
  static constexpr const char* kFind =
      "SELECT id FROM shape WHERE n = ?1 AND nnz = ?2 AND groups = ?3 AND rhs = ?4 AND fill = ?5 AND operations = ?6 "
      "AND depth = ?7 AND terms = ?8 AND pattern = ?9";
  const std::string pattern = hexadecimal(s.pattern);
  bound(prepared(kInsert), s.n, s.nnz, s.groups, s.rhs, s.fill, s.operations, s.depth, s.terms, pattern).exec();
  return the_id(bound(prepared(kFind), s.n, s.nnz, s.groups, s.rhs, s.fill, s.operations, s.depth, s.terms, pattern));
}

std::int64_t Writer::strategy(const Strategy& strategy) {
  static constexpr const char* kInsert =
      "INSERT INTO strategy (text, backend, lanes, p, q) VALUES (?1, ?2, ?3, ?4, ?5) ON CONFLICT DO NOTHING";
  static constexpr const char* kFind = "SELECT id FROM strategy WHERE text = ?1";
  const std::string text = to_string(strategy);
  bound(prepared(kInsert), text, strategy.solver.backend, strategy.solver.lanes, strategy.run.threads,
        strategy.solver.threads)
      .exec();
  return the_id(bound(prepared(kFind), text));
}

bool Writer::sample(const Sample& sample, const Library& from, std::int64_t run, const std::string& uid,
                    const std::string& machine) {
  static constexpr const char* kInsert =
      "INSERT INTO sample (uid, run, library, kernel, shape, strategy, seconds, spread, repetitions, backward_error, "
      "forward_error, checksum, slowness) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13) "
      "ON CONFLICT (uid) DO NOTHING";
  return bound(prepared(kInsert), sample.uid, run, library(from), std::string(name(sample.kernel)), shape(sample.shape),
               strategy(sample.strategy), sample.seconds, sample.spread, sample.repetitions, sample.backward_error,
               sample.forward_error, checksum(sample, from, uid, machine), sample.slowness)
             .exec() > 0;
}

}  // namespace assur::db
