// Puts rows into a database, or finds them there. The caller has a transaction open.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <map>
#include <tuple>

#include "db/contents.hpp"

namespace assur::db {

class Writer {
 public:
  explicit Writer(SQLite::Database& database) : database_(database) {}

  // The id of the row.
  std::int64_t machine(const Host& host);
  std::int64_t library(const Library& library);
  std::int64_t run(const RunRow& row, std::int64_t machine);  // a run with this uid stays as it is
  std::int64_t shape(const Shape& shape);
  std::int64_t strategy(const Strategy& strategy);

  // False if a sample of this uid is there already. sample: as SampleRow has it. run: its id; uid and machine are those
  // of the run.
  bool sample(const Sample& sample, const Library& library, std::int64_t run, const std::string& uid,
              const std::string& machine);

 private:
  SQLite::Statement& prepared(const char* sql);

  SQLite::Database& database_;
  std::map<const char*, SQLite::Statement> statements_;
};

}  // namespace assur::db
