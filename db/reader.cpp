#include "db/reader.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <locale>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <tuple>

#include "db/checksum.hpp"
#include "db/schema.hpp"
#include "dispatch/impossible.hpp"
#include "dispatch/pace.hpp"
#include "numbers.hpp"

namespace assur::db {
namespace {

// The rows of a query, one after the other. SQLite::Statement makes an object for each column of each row, which takes
// as long as SQLite takes to read the row.
class QueryRows {
 public:
  QueryRows(SQLite::Database& database, const std::string& select) : database_(database.getHandle()) {
    sqlite3_stmt* statement = nullptr;
    check(sqlite3_prepare_v2(database_, select.c_str(), static_cast<int>(select.size()), &statement, nullptr));
    statement_.reset(statement);
  }
  // Moves to the next row; false after the last one.
  bool next() {
    const int result = sqlite3_step(statement_.get());
    if (result != SQLITE_DONE && result != SQLITE_ROW) check(result);
    return result == SQLITE_ROW;
  }
  [[nodiscard]] bool is_null(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }
  [[nodiscard]] std::int32_t int32(int column) const { return sqlite3_column_int(statement_.get(), column); }
  [[nodiscard]] std::int64_t int64(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  [[nodiscard]] double real(int column) const { return sqlite3_column_double(statement_.get(), column); }
  // Valid until the next row.
  [[nodiscard]] std::string_view text(int column) const {
    const unsigned char* const bytes = sqlite3_column_text(statement_.get(), column);
    if (bytes == nullptr) return {};
    return {reinterpret_cast<const char*>(bytes),
            static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
  }
  [[nodiscard]] std::string string(int column) const { return std::string(text(column)); }

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };

  void check(int result) const {
    if (result != SQLITE_OK) throw SQLite::Exception(database_, result);
  }

  sqlite3* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};
using TakeRow = std::function<void(const QueryRows&)>;

[[noreturn]] void throw_damaged(const std::string& what) { throw SQLite::Exception(what, SQLITE_CORRUPT); }

// Reads rows in the order of their ids. If they are out of order, the tree of the table is damaged.
void each(SQLite::Database& database, const std::string& select, const TakeRow& take) {
  QueryRows row(database, select + " ORDER BY id");
  for (std::int64_t last = 0; row.next();) {
    const std::int64_t id = row.int64(0);
    if (id <= last) throw_damaged("rows are out of order");
    last = id;
    take(row);
  }
}

std::vector<Cache> caches_of(const std::string& text) {
  std::vector<Cache> caches;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  Cache cache;
  for (char colon = 0; stream >> cache.level >> colon >> cache.bytes >> colon >> cache.cores;) caches.push_back(cache);
  return caches;
}

// Only the number of cores is stored, not which cores they are.
std::vector<std::int32_t> numbered(std::int64_t cores) {
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(std::clamp<std::int64_t>(cores, 0, 8192)));
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int32_t>(i);
  return numbers;
}

Host host_of(const QueryRows& row) {
  Host host;
  host.vendor = row.string(1);
  host.family = row.int32(2);
  host.model = row.int32(3);
  host.stepping = row.int32(4);
  host.machine.model = row.string(5);
  host.machine.instructions = row.string(6);
  host.machine.cores = numbered(row.int64(7));
  host.machine.processors = row.int32(8);
  host.machine.quota = row.real(9);
  host.machine.caches = caches_of(row.string(10));
  host.machine.numa_nodes = row.int32(11);
  host.memory = row.int64(12);
  return host;
}

RunRow run_of(const QueryRows& row) {
  RunRow r;
  r.run.id = row.int64(0);
  r.run.uid = row.string(1);
  r.machine = row.int64(2);
  r.run.profile = row.string(3);
  r.run.assur = row.string(4);
  r.run.started = row.string(5);
  r.run.threads = row.int32(6);
  r.run.load = row.real(7);
  r.microcode = row.string(8);
  r.process = row.int64(9);
  r.samples = row.int64(15);
  r.run.finished = !row.is_null(10);
  if (!r.run.finished) return r;
  r.finished = row.string(10);
  r.run.grade = row.string(11);
  r.run.seconds = row.real(12);
  r.run.coverage = row.real(13);
  r.run.note = row.string(14);
  return r;
}

Shape shape_of(const QueryRows& row) {
  Shape s;
  s.n = row.int32(1);
  s.nnz = row.int32(2);
  s.groups = row.int32(3);
  s.rhs = row.int32(4);
  s.fill = row.int64(5);
  s.operations = row.int64(6);
  s.depth = row.int64(7);
  s.terms = row.int64(8);
  // damaged, so its checksum must differ
  if (!parse_hexadecimal(row.text(9), s.pattern)) s.pattern = ~s.pattern;
  s.one_program = row.int64(10) != 0;
  return s;
}

std::uint64_t sum_of(std::string_view text) { return (Checksum() << text).value(); }
std::uint64_t sum_of(const Library& l) { return (Checksum() << l.name << l.version << l.build).value(); }
std::uint64_t sum_of(const std::string& run, const std::string& machine) {
  return (Checksum() << run << machine).value();
}

std::optional<Strategy> strategy_of(const std::string& text) {
  try {
    return parse_strategy(text);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<Kernel> kernel_of(std::string_view text) {
  try {
    return parse_kernel(text);
  } catch (const Error&) {
    return std::nullopt;
  }
}

// NaN if the column is NULL, for which SQLite returns 0.
double or_nan(const QueryRows& row, int column) {
  const double value = row.real(column);
  return value == 0 && row.is_null(column) ? kNan : value;
}

// Checksum of everything that is stored with a sample; rows that it refers to enter with their checksums.
std::int64_t sum_of(const Sample& s, std::string_view kernel, std::uint64_t shape, std::uint64_t strategy,
                    std::uint64_t library, std::uint64_t run) {
  Checksum sum;
  sum << s.uid << kernel << s.seconds << s.spread << s.repetitions << s.backward_error << s.forward_error;
  if (!std::isnan(s.slowness)) sum << s.slowness;
  for (const std::uint64_t part : {shape, strategy, library, run}) sum << static_cast<std::int64_t>(part);
  return static_cast<std::int64_t>(sum.value());
}

template <class Value>
const Checked<Value>* find(const std::unordered_map<std::int64_t, Checked<Value>>& table, std::int64_t id) {
  const auto found = table.find(id);
  return found == table.end() ? nullptr : &found->second;
}

[[noreturn]] void throw_damaged(const SampleRow& row, std::string_view what) {
  throw_damaged("sample " + std::to_string(row.id) + ": " + std::string(what));
}

void take_sample(const QueryRows& row, const Tables& tables, Samples& samples) {
  SampleRow r;
  Sample& s = r.sample;
  r.id = row.int64(0);
  s.uid = row.text(1);
  r.run = row.int64(2);
  r.library = row.int64(3);
  const std::string_view kernel = row.text(4);
  s.seconds = row.real(7);
  s.spread = row.real(8);
  s.repetitions = row.int64(9);
  s.backward_error = or_nan(row, 10);
  s.forward_error = or_nan(row, 11);
  s.slowness = or_nan(row, 13);
  const auto* const shape = find(tables.shapes, row.int64(5));
  const auto* const strategy = find(tables.strategies, row.int64(6));
  const auto* const library = find(tables.libraries, r.library);
  const auto run = tables.runs.find(r.run);
  const bool whole = shape && strategy && library && run != tables.runs.end() &&
                     sum_of(s, kernel, shape->sum, strategy->sum, library->sum, run->second.sum) == row.int64(12);
  if (!whole) throw_damaged(r, "it, or a row that it refers to, was changed or is missing");
  s.shape = shape->value;
  // Checksums do not tell whether a program stored what it had measured.
  if (const std::string_view why = why_impossible(s); !why.empty()) throw_damaged(r, why);
  if (!std::isnan(s.slowness) && !is_possible_time(s.slowness)) throw_damaged(r, "its slowness must be 1e-15 to 1e9 s");
  const auto kind = kernel_of(kernel);
  if (!kind || !strategy->value) {
    ++samples.unknown;
    return;
  }
  s.kernel = *kind;
  s.strategy = *strategy->value;
  samples.rows.push_back(std::move(r));
}

using Origin = std::pair<std::int64_t, std::int64_t>;  // run, library

// The usual slowness at each origin of samples. The work that measures the pace is fixed for one version and build of
// assur. Other programs only slow a machine down, so the lower quartile is the usual pace.
std::map<Origin, double> usual_paces(const Samples& samples, const Tables& tables) {
  std::map<std::tuple<std::int64_t, std::string, std::string>, std::vector<double>> seen;  // machine, assur, build
  std::map<Origin, std::vector<double>*> of;
  for (const SampleRow& row : samples.rows) {
    if (std::isnan(row.sample.slowness)) continue;
    const auto [at, is_new] = of.try_emplace({row.run, row.library});
    if (is_new) {
      const RunRow& run = tables.runs.at(row.run).value;
      at->second = &seen[{run.machine, run.run.assur, tables.libraries.at(row.library).value.build}];
    }
    at->second->push_back(row.sample.slowness);
  }
  for (auto& [origin, all] : seen) {
    const auto quarter = all.begin() + static_cast<std::ptrdiff_t>((all.size() - 1) / 4);
    std::nth_element(all.begin(), quarter, all.end());
    all = {*quarter};
  }
  std::map<Origin, double> usual;
  for (const auto& [origin, all] : of) usual[origin] = all->front();
  return usual;
}

// Columns and triggers of the tables. The texts that made tables differ, because they have comments.
std::set<std::string> outline(SQLite::Database& database) {
  std::set<std::string> parts;
  SQLite::Statement part(database,
                         "SELECT t.name || ' ' || coalesce(c.name || ' ' || c.type, t.sql) FROM sqlite_schema t "
                         "LEFT JOIN pragma_table_info(t.name) c WHERE t.type IN ('table', 'trigger')");
  while (part.executeStep()) parts.insert(part.getColumn(0).getString());
  return parts;
}

}  // namespace

Tables read_tables(SQLite::Database& database) {
  Tables tables;
  each(database,
       "SELECT id, vendor, family, model, stepping, name, instructions, cores, processors, quota, caches, numa_nodes, "
       "memory FROM machine",
       [&](const QueryRows& row) { tables.machines[row.int64(0)] = host_of(row); });
  each(database,
       "SELECT id, uid, machine, profile, assur, started, threads, load, microcode, process, finished, grade, seconds, "
       "coverage, note, samples FROM tuning_run",
       [&](const QueryRows& row) {
         RunRow r = run_of(row);
         const auto machine = tables.machines.find(r.machine);
         if (machine == tables.machines.end()) throw_damaged("the machine of a tuning run is missing");
         r.run.machine = machine->second.fingerprint();
         const std::uint64_t sum = sum_of(r.run.uid, r.run.machine);
         tables.runs.emplace(r.run.id, Checked<RunRow>{std::move(r), sum});
       });
  each(database, "SELECT id, name, version, build FROM library", [&](const QueryRows& row) {
    Library library{row.string(1), row.string(2), row.string(3)};
    const std::uint64_t sum = sum_of(library);
    tables.libraries.emplace(row.int64(0), Checked<Library>{std::move(library), sum});
  });
  each(database, "SELECT id, n, nnz, groups, rhs, fill, operations, depth, terms, pattern, one_program FROM shape",
       [&](const QueryRows& row) {
         const Shape shape = shape_of(row);
         tables.shapes.emplace(row.int64(0), Checked<Shape>{shape, checksum(shape)});
       });
  each(database, "SELECT id, text FROM strategy", [&](const QueryRows& row) {
    const std::string text = row.string(1);
    tables.strategies.emplace(row.int64(0), Checked<std::optional<Strategy>>{strategy_of(text), sum_of(text)});
  });
  return tables;
}

Samples read_samples(SQLite::Database& database, const Tables& tables, std::span<const std::int64_t> runs) {
  Samples samples;
  const TakeRow take = [&](const QueryRows& row) { take_sample(row, tables, samples); };
  const std::string select =
      "SELECT id, uid, run, library, kernel, shape, strategy, seconds, spread, repetitions, backward_error, "
      "forward_error, checksum, slowness FROM sample";
  if (runs.empty()) each(database, select, take);
  for (const std::int64_t run : runs) each(database, select + " WHERE run = " + std::to_string(run), take);
  std::int64_t counted = 0;
  for (const auto& [id, run] : tables.runs) {
    if (runs.empty() || std::find(runs.begin(), runs.end(), id) != runs.end()) counted += run.value.samples;
  }
  const std::int64_t found = static_cast<std::int64_t>(samples.rows.size()) + samples.unknown;
  if (found != counted) {
    throw_damaged(std::to_string(counted) + " samples were stored, but " + std::to_string(found) + " are there");
  }
  return samples;
}

Contents read_all(SQLite::Database& database) {
  const SQLite::Transaction moment(database);
  Contents contents;
  contents.tables = read_tables(database);
  contents.samples = read_samples(database, contents.tables);
  return contents;
}

void check_all(SQLite::Database& database) {
  (void)read_all(database);  // first, because readers do the same and give the same reason
  const std::string finding = database.execAndGet("PRAGMA integrity_check(1)").getString();
  if (finding != "ok") throw_damaged(finding);
  SQLite::Statement references(database, "PRAGMA foreign_key_check");
  if (references.executeStep()) {
    throw_damaged("rows of " + references.getColumn(0).getString() + " refer to missing rows");
  }
  SQLite::Database fresh(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  fresh.exec(std::string(kSchema));
  const std::set<std::string> wanted = outline(fresh), found = outline(database);
  if (!std::includes(found.begin(), found.end(), wanted.begin(), wanted.end())) {
    throw_damaged("its tables are not those of db/schema.sql");
  }
}

void at_usual_pace(Samples& samples, const Tables& tables) {
  const std::map<Origin, double> usual = usual_paces(samples, tables);
  for (SampleRow& row : samples.rows) {
    Sample& s = row.sample;
    if (std::isnan(s.slowness)) {
      s.slowness = 1;
      continue;
    }
    const double slowness = s.slowness / usual.at({row.run, row.library});
    s = slowed(std::move(s), 1 / slowness);
    s.slowness = slowness;
  }
}

std::int64_t checksum(const Sample& sample, const Library& library, const std::string& run,
                      const std::string& machine) {
  return sum_of(sample, name(sample.kernel), checksum(sample.shape), sum_of(to_string(sample.strategy)),
                sum_of(library), sum_of(run, machine));
}

std::string to_text(const std::vector<Cache>& caches) {
  std::string text;
  for (const Cache& cache : caches) {
    text += (text.empty() ? "" : " ") + std::to_string(cache.level) + ":" + std::to_string(cache.bytes) + ":" +
            std::to_string(cache.cores);
  }
  return text;
}

}  // namespace assur::db
