#include "db/writer.hpp"

#include <SQLiteCpp/VariadicBind.h>

#include "db/checksum.hpp"

namespace assur::db {
namespace {

template <class... Values>
SQLite::Statement& bound(SQLite::Statement& statement, const Values&... values) {
  statement.reset();
  SQLite::bind(statement, values...);  // stores NaN as NULL, and -0 as 0
  return statement;
}

// The statement returns the id of its row.
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

// A row that exists already is updated, so that RETURNING has it.
std::int64_t Writer::machine(const Host& host) {
  static constexpr const char* kInsert =
      "INSERT INTO machine (fingerprint, vendor, family, model, stepping, name, instructions, cores, processors, "
      "quota, caches, numa_nodes, memory) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13) "
      "ON CONFLICT DO UPDATE SET id = id RETURNING id";
  const Machine& m = host.machine;
  return the_id(bound(prepared(kInsert), host.fingerprint(), host.vendor, host.family, host.model, host.stepping,
                      m.model, m.instructions, static_cast<std::int64_t>(m.cores.size()), m.processors, m.quota,
                      to_text(m.caches), m.numa_nodes, host.memory));
}

std::int64_t Writer::library(const Library& library) {
  static constexpr const char* kInsert =
      "INSERT INTO library (name, version, build) VALUES (?1, ?2, ?3) "
      "ON CONFLICT DO UPDATE SET id = id RETURNING id";
  return the_id(bound(prepared(kInsert), library.name, library.version, library.build));
}

std::int64_t Writer::run(const RunRow& row, std::int64_t machine) {
  static constexpr const char* kInsert =
      "INSERT INTO tuning_run (uid, machine, profile, assur, started, threads, load, microcode, process) "
      "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9) ON CONFLICT DO UPDATE SET id = id RETURNING id";
  static constexpr const char* kFinish =
      "UPDATE tuning_run SET finished = ?2, grade = ?3, seconds = ?4, coverage = ?5, note = ?6 "
      "WHERE uid = ?1 AND finished IS NULL";
  const Run& r = row.run;
  const std::int64_t id = the_id(bound(prepared(kInsert), r.uid, machine, r.profile, r.assur, r.started, r.threads,
                                       r.load, row.microcode, row.process));
  if (r.finished) bound(prepared(kFinish), r.uid, row.finished, r.grade, r.seconds, r.coverage, r.note).exec();
  return id;
}

std::int64_t Writer::shape(const Shape& s) {
  static constexpr const char* kInsert =
      "INSERT INTO shape (n, nnz, groups, rhs, fill, operations, depth, terms, pattern, one_program) "
      "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10) ON CONFLICT DO UPDATE SET id = id RETURNING id";
  return the_id(bound(prepared(kInsert), s.n, s.nnz, s.groups, s.rhs, s.fill, s.operations, s.depth, s.terms,
                      hexadecimal(s.pattern), std::int64_t{s.one_program}));
}

std::int64_t Writer::strategy(const Strategy& strategy) {
  static constexpr const char* kInsert =
      "INSERT INTO strategy (text, backend, lanes, p, q) VALUES (?1, ?2, ?3, ?4, ?5) "
      "ON CONFLICT DO UPDATE SET id = id RETURNING id";
  return the_id(bound(prepared(kInsert), to_string(strategy), strategy.solver.backend, strategy.solver.lanes,
                      strategy.run.threads, strategy.solver.threads));
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
