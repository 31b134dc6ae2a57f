// Adds rows to a database, or finds them. The caller must have begun a transaction.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <map>
#include <tuple>

#include "db/reader.hpp"

namespace assur::db {

class Writer {
 public:
  explicit Writer(SQLite::Database& database) : database_(database) {}

  // Each function returns the id of the row.
  std::int64_t machine(const Host& host);
  std::int64_t library(const Library& library);
  std::int64_t run(const RunRow& row, std::int64_t machine);  // a run with this uid is not changed
  std::int64_t shape(const Shape& shape);
  std::int64_t strategy(const Strategy& strategy);

  // Adds a sample in the form of SampleRow. False if its uid exists already. run: id of the run; uid, machine: uid and
  // fingerprint of the run.
  bool sample(const Sample& sample, const Library& library, std::int64_t run, const std::string& uid,
              const std::string& machine);

 private:
  SQLite::Statement& prepared(const char* sql);

  SQLite::Database& database_;
  std::map<const char*, SQLite::Statement> statements_;
};

}  // namespace assur::db
