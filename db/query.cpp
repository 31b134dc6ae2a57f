// Store: tables for people.
#include <cmath>

#include "db/store_impl.hpp"
#include "numbers.hpp"

namespace assur::db {
namespace {

Value value_of(const SQLite::Column& column) {
  if (column.isNull()) return {};
  if (column.isInteger()) return column.getInt64();
  if (column.isFloat()) return column.getDouble();
  return column.getString();
}

// ?1: the beginning of a machine's fingerprint; ?2: a kernel, or ''.
Answer ask(SQLite::Database& database, const std::string& sql, const Filter& filter) {
  SQLite::Statement statement(database, sql);
  statement.bind(1, filter.machine);
  statement.bind(2, filter.kernel ? std::string(name(*filter.kernel)) : "");
  Answer answer;
  const int columns = statement.getColumnCount();
  for (int c = 0; c < columns; ++c) answer.columns.emplace_back(statement.getColumnName(c));
  while (statement.executeStep()) {
    std::vector<Value>& row = answer.rows.emplace_back();
    for (int c = 0; c < columns; ++c) row.push_back(value_of(statement.getColumn(c)));
  }
  return answer;
}

Answer ask_view(SQLite::Database& database, const std::string& view, const Filter& filter) {
  return ask(database,
             "SELECT * FROM " + view + " WHERE substr(machine, 1, length(?1)) = ?1 AND (?2 = '' OR kernel = ?2)",
             filter);
}

Value known(double value) { return value == value ? Value(value) : Value(); }

}  // namespace

Answer Store::sample_rows(const Filter& filter) const {
  return guarded(impl_->file, [&] {
    Answer answer;
    answer.columns = {"uid",           "machine", "started",  "kernel",  "n",           "nnz",         "groups",
                      "rhs",           "fill",    "strategy", "seconds", "spread",      "repetitions", "backward_error",
                      "forward_error", "library", "version",  "build",   "raw_seconds", "slowness"};
    const auto [tables, raw] = read_all(impl_->database);
    Samples samples = raw;
    at_usual_pace(samples, tables);
    for (std::size_t i = 0; i < samples.rows.size(); ++i) {
      const SampleRow& row = samples.rows[i];
      if (!fits(filter, row, tables)) continue;
      const Sample& s = row.sample;
      const bool paced = !std::isnan(raw.rows[i].sample.slowness);
      const Run& run = tables.runs.at(row.run).value.run;
      const Library& library = tables.libraries.at(row.library).value;
      answer.rows.push_back({s.uid,
                             run.machine,
                             run.started,
                             std::string(name(s.kernel)),
                             std::int64_t{s.shape.n},
                             std::int64_t{s.shape.nnz},
                             std::int64_t{s.shape.groups},
                             std::int64_t{s.shape.rhs},
                             s.shape.fill,
                             to_string(s.strategy),
                             s.seconds,
                             s.spread,
                             s.repetitions,
                             known(s.backward_error),
                             known(s.forward_error),
                             library.name,
                             library.version,
                             library.build,
                             known(paced ? raw.rows[i].sample.seconds : kNan),
                             known(paced ? s.slowness : kNan)});
    }
    return answer;
  });
}

Answer Store::best(const Filter& filter) const {
  return guarded(impl_->file, [&] { return ask_view(impl_->database, "best_strategy", filter); });
}

Answer Store::crossovers(const Filter& filter) const {
  return guarded(impl_->file, [&] { return ask_view(impl_->database, "crossovers", filter); });
}

Answer Store::models() const {
  return guarded(impl_->file, [&] {
    return ask(impl_->database,
               "SELECT fingerprint AS machine, model.name, made, assur, content FROM model "
               "JOIN machine ON machine.id = model.machine WHERE ?1 = '' AND ?2 = '' ORDER BY made",
               {});
  });
}

}  // namespace assur::db
