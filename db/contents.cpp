#include "db/contents.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <locale>
#include <optional>
#include <sstream>
#include <tuple>

#include "db/checksum.hpp"
#include "numbers.hpp"
#include "planning/pace.hpp"

namespace assur::db {
namespace {

// A statement and the row that it is at. The library reads thousands of rows before its first step; SQLiteCpp shares
// the ownership of the statement with an object for each value.
class Row {
 public:
  Row(SQLite::Database& database, const std::string& select) {
    check(
        sqlite3_prepare_v2(database.getHandle(), select.data(), static_cast<int>(select.size()), &statement_, nullptr),
        database.getHandle());
  }
  Row(const Row&) = delete;
  Row& operator=(const Row&) = delete;
  ~Row() { sqlite3_finalize(statement_); }

  // False: there is no further row.
  bool next() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) check(code, sqlite3_db_handle(statement_));
    return code == SQLITE_ROW;
  }
  // From the first row again.
  void reset(std::int64_t parameter) {
    sqlite3_reset(statement_);
    check(sqlite3_bind_int64(statement_, 1, parameter), sqlite3_db_handle(statement_));
  }

  [[nodiscard]] std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  [[nodiscard]] std::int32_t small(int column) const { return sqlite3_column_int(statement_, column); }
  [[nodiscard]] double real(int column) const { return sqlite3_column_double(statement_, column); }
  [[nodiscard]] double real_or_nan(int column) const { return is_null(column) ? kNan : real(column); }
  [[nodiscard]] bool is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  // Until the next row.
  [[nodiscard]] std::string_view text(int column) const {
    const unsigned char* const bytes = sqlite3_column_text(statement_, column);
    if (bytes == nullptr) return {};
    return {reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
  }
  [[nodiscard]] std::string string(int column) const { return std::string(text(column)); }

 private:
  static void check(int code, sqlite3* database) {
    if (code != SQLITE_OK) throw SQLite::Exception(database, code);
  }

  sqlite3_stmt* statement_ = nullptr;
};
using TakeRow = std::function<void(const Row&)>;

constexpr std::int64_t kMostReserved = 10'000;    // samples, whatever a damaged count says
constexpr std::int64_t kFurthestLookup = 10'000;  // ids beyond the last one seen, where the end of a table is damaged

// Rows in the order of their ids; where they are in none the tree of the table is damaged. Returns the last id.
std::int64_t scan(SQLite::Database& database, const std::string& select, const TakeRow& take, bool ascending = true) {
  Row row(database, select);
  for (std::int64_t last = 0;;) {
    if (!row.next()) return last;
    const std::int64_t id = row.integer(0);
    if (ascending && id <= last) throw SQLite::Exception("rows are out of order", SQLITE_CORRUPT);
    last = id;
    take(row);
  }
}

// From the front up to the first damage, from the back down to the last, and between them one by one.
void salvage(SQLite::Database& database, const std::string& select, const TakeRow& take) {
  std::int64_t front = 0;
  std::optional<std::int64_t> back;
  const auto attempt = [](auto&& work) {
    try {
      work();
    } catch (const SQLite::Exception&) {
    }
  };
  bool whole = false;
  attempt([&] {
    scan(database, select + " ORDER BY id", [&](const Row& row) {
      take(row);
      front = row.integer(0);
    });
    whole = true;
  });
  if (whole) return;
  attempt([&] {
    Row row(database, select + " ORDER BY id DESC");
    while (row.next()) {
      const std::int64_t id = row.integer(0);
      if (id <= front || (back && id >= *back)) break;
      take(row);
      back = id;
    }
  });
  const std::int64_t end = back ? std::min(*back, front + 100 * kFurthestLookup) : front + kFurthestLookup;
  attempt([&] {
    Row row(database, select + " WHERE id = ?1");
    for (std::int64_t id = front + 1; id < end; ++id) {
      attempt([&] {
        row.reset(id);
        if (row.next() && row.integer(0) == id) take(row);
      });
    }
  });
}

// index: one that holds all that is selected, so that a table is known where its own pages are lost.
void each(SQLite::Database& database, Care care, const std::string& select, const TakeRow& take,
          const char* index = nullptr) {
  if (care == Care::salvaging) {
    try {
      if (index != nullptr) scan(database, select + " INDEXED BY " + index, take, false);
    } catch (const SQLite::Exception&) {
    }
    salvage(database, select, take);
  } else {
    scan(database, select + " ORDER BY id", take);
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

// Which cores they were is not kept, only how many.
std::vector<std::int32_t> numbered(std::int64_t cores) {
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(std::clamp<std::int64_t>(cores, 0, 8192)));
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<std::int32_t>(i);
  return numbers;
}

Host host_of(const Row& row) {
  Host host;
  host.vendor = row.string(1);
  host.family = row.small(2);
  host.model = row.small(3);
  host.stepping = row.small(4);
  host.machine.model = row.string(5);
  host.machine.instructions = row.string(6);
  host.machine.cores = numbered(row.integer(7));
  host.machine.processors = row.small(8);
  host.machine.quota = row.real(9);
  host.machine.caches = caches_of(row.string(10));
  host.machine.numa_nodes = row.small(11);
  host.memory = row.integer(12);
  return host;
}

RunRow run_of(const Row& row) {
  RunRow r;
  r.run.id = row.integer(0);
  r.run.uid = row.string(1);
  r.machine = row.integer(2);
  r.run.profile = row.string(3);
  r.run.assur = row.string(4);
  r.run.started = row.string(5);
  r.run.threads = row.small(6);
  r.run.load = row.real(7);
  r.microcode = row.string(8);
  r.process = row.integer(9);
  r.samples = row.integer(15);
  r.run.finished = !row.is_null(10);
  if (!r.run.finished) return r;
  r.finished = row.string(10);
  r.run.grade = row.string(11);
  r.run.seconds = row.real(12);
  r.run.coverage = row.real(13);
  r.run.note = row.string(14);
  return r;
}

Shape shape_of(const Row& row) {
  Shape s;
  s.n = row.small(1);
  s.nnz = row.small(2);
  s.groups = row.small(3);
  s.rhs = row.small(4);
  s.fill = row.integer(5);
  s.operations = row.integer(6);
  s.depth = row.integer(7);
  s.terms = row.integer(8);
  if (!parse_hexadecimal(row.text(9), s.pattern)) s.pattern = ~s.pattern;  // damaged: so is its sum
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

// Everything that is stored with a sample; what it refers to by the sum of that.
std::int64_t sum_of(const Sample& s, std::string_view uid, std::string_view kernel, std::uint64_t shape,
                    std::uint64_t strategy, std::uint64_t library, std::uint64_t run) {
  Checksum sum;
  sum << uid << kernel << s.seconds << s.spread << s.repetitions << s.backward_error << s.forward_error;
  if (!std::isnan(s.slowness)) sum << s.slowness;  // older schemas had no such column
  for (const std::uint64_t part : {shape, strategy, library, run}) sum << static_cast<std::int64_t>(part);
  return static_cast<std::int64_t>(sum.value());
}

// Samples mostly refer to the same as the one before.
template <class Table>
class Lookup {
 public:
  explicit Lookup(const Table& table) : table_(table) {}

  // Null: there is none of this id.
  const typename Table::mapped_type* operator()(std::int64_t id) {
    if (id != last_ || found_ == nullptr) {
      const auto at = table_.find(id);
      found_ = at == table_.end() ? nullptr : &at->second;
      last_ = id;
    }
    return found_;
  }

 private:
  const Table& table_;
  std::int64_t last_ = 0;
  const typename Table::mapped_type* found_ = nullptr;
};

class TakeSample {
 public:
  TakeSample(const Tables& tables, Uids uids, Samples& samples)
      : shape_of_(tables.shapes),
        strategy_of_(tables.strategies),
        library_of_(tables.libraries),
        run_of_(tables.runs),
        uids_(uids),
        samples_(samples) {}

  void operator()(const Row& row) {
    const std::string_view uid = row.text(1), kernel = row.text(4);
    SampleRow& r = samples_.rows.emplace_back();  // in its place at once, but for a few
    Sample& s = r.sample;
    r.id = row.integer(0);
    r.run = row.integer(2);
    r.library = row.integer(3);
    s.seconds = row.real(7);
    s.spread = row.real(8);
    s.repetitions = row.integer(9);
    s.backward_error = row.real_or_nan(10);
    s.forward_error = row.real_or_nan(11);
    s.slowness = row.real_or_nan(13);
    const auto* const shape = shape_of_(row.integer(5));
    const auto* const strategy = strategy_of_(row.integer(6));
    const auto* const library = library_of_(r.library);
    const auto* const run = run_of_(r.run);
    const bool whole = shape && strategy && library && run &&
                       sum_of(s, uid, kernel, shape->sum, strategy->sum, library->sum, run->sum) == row.integer(12);
    const auto kind = whole ? kernel_of(kernel) : std::nullopt;
    if (!kind || !strategy->value) {
      ++(whole ? samples_.unknown : samples_.damaged);
      samples_.rows.pop_back();
      return;
    }
    if (uids_ == Uids::read) s.uid = uid;
    s.kernel = *kind;
    s.shape = shape->value;
    s.strategy = *strategy->value;
  }

 private:
  Lookup<decltype(Tables::shapes)> shape_of_;
  Lookup<decltype(Tables::strategies)> strategy_of_;
  Lookup<decltype(Tables::libraries)> library_of_;
  Lookup<decltype(Tables::runs)> run_of_;
  Uids uids_;
  Samples& samples_;
};

// The fixed work is of one version and build of assur.
using PaceOrigin = std::tuple<std::int64_t, std::string_view, std::string_view>;  // machine, assur, build

PaceOrigin origin_of(const SampleRow& row, const Tables& tables) {
  const RunRow& run = tables.runs.at(row.run).value;
  return {run.machine, run.run.assur, tables.libraries.at(row.library).value.build};
}

// Others only slow a machine down, so its lower quartile is what is usual.
std::map<PaceOrigin, double> usual_paces(const Samples& samples, const Tables& tables) {
  std::map<PaceOrigin, std::vector<double>> seen;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<double>*> of;  // run, library
  for (const SampleRow& row : samples.rows) {
    if (std::isnan(row.sample.slowness)) continue;
    const auto [at, is_new] = of.try_emplace({row.run, row.library});
    if (is_new) at->second = &seen[origin_of(row, tables)];
    at->second->push_back(row.sample.slowness);
  }
  std::map<PaceOrigin, double> usual;
  for (auto& [origin, all] : seen) {
    const auto quarter = all.begin() + static_cast<std::ptrdiff_t>((all.size() - 1) / 4);
    std::nth_element(all.begin(), quarter, all.end());
    usual[origin] = *quarter;
  }
  return usual;
}

// Files of an older schema are read, too: `otherwise` stands for a column that they do not have.
std::string column_or(SQLite::Database& database, const std::string& table, const std::string& column,
                      const std::string& otherwise) {
  SQLite::Statement find(database, "SELECT 1 FROM pragma_table_info(?1) WHERE name = ?2");
  find.bind(1, table);
  find.bind(2, column);
  return find.executeStep() ? column : otherwise;
}

}  // namespace

Tables read_origins(SQLite::Database& database, Care care) {
  Tables tables;
  each(database, care,
       "SELECT id, vendor, family, model, stepping, name, instructions, cores, processors, quota, caches, numa_nodes, "
       "memory FROM machine",
       [&](const Row& row) { tables.machines[row.integer(0)] = host_of(row); });
  each(database, care,
       "SELECT id, uid, machine, profile, assur, started, threads, load, microcode, process, finished, grade, seconds, "
       "coverage, note, " +
           column_or(database, "tuning_run", "samples", "0") + " FROM tuning_run",
       [&](const Row& row) {
         RunRow r = run_of(row);
         const auto machine = tables.machines.find(r.machine);
         if (machine == tables.machines.end()) return;
         r.run.machine = machine->second.fingerprint();
         const std::uint64_t sum = sum_of(r.run.uid, r.run.machine);
         tables.runs.insert_or_assign(r.run.id, Checked<RunRow>{std::move(r), sum});
       });
  each(
      database, care, "SELECT id, name, version, build FROM library",
      [&](const Row& row) {
        Library library{row.string(1), row.string(2), row.string(3)};
        const std::uint64_t sum = sum_of(library);
        tables.libraries.insert_or_assign(row.integer(0), Checked<Library>{std::move(library), sum});
      },
      "sqlite_autoindex_library_1");
  return tables;
}

void read_subjects(SQLite::Database& database, Tables& tables, Care care) {
  each(
      database, care, "SELECT id, n, nnz, groups, rhs, fill, operations, depth, terms, pattern FROM shape",
      [&](const Row& row) {
        const Shape shape = shape_of(row);
        tables.shapes.insert_or_assign(row.integer(0), Checked<Shape>{shape, checksum(shape)});
      },
      "sqlite_autoindex_shape_1");
  each(
      database, care, "SELECT id, text FROM strategy",
      [&](const Row& row) {
        const std::string text = row.string(1);
        tables.strategies.insert_or_assign(row.integer(0),
                                           Checked<std::optional<Strategy>>{strategy_of(text), sum_of(text)});
      },
      "sqlite_autoindex_strategy_1");
}

Tables read_tables(SQLite::Database& database, Care care) {
  Tables tables = read_origins(database, care);
  read_subjects(database, tables, care);
  return tables;
}

Samples read_samples(SQLite::Database& database, const Tables& tables, Care care, Uids uids,
                     std::span<const std::int64_t> runs) {
  Samples samples;
  const TakeRow take = TakeSample(tables, uids, samples);
  const std::string select =
      "SELECT id, uid, run, library, kernel, shape, strategy, seconds, spread, repetitions, backward_error, "
      "forward_error, checksum, " +
      column_or(database, "sample", "slowness", "NULL") + " FROM sample";
  std::int64_t counted = 0;
  for (const auto& [id, run] : tables.runs) {
    if (runs.empty() || std::find(runs.begin(), runs.end(), id) != runs.end()) counted += run.value.samples;
  }
  samples.rows.reserve(static_cast<std::size_t>(std::clamp<std::int64_t>(counted, 0, kMostReserved)));
  if (runs.empty()) each(database, care, select, take);
  for (const std::int64_t run : runs) scan(database, select + " WHERE run = " + std::to_string(run), take, false);
  const std::int64_t found = static_cast<std::int64_t>(samples.rows.size()) + samples.damaged + samples.unknown;
  samples.lost = std::max<std::int64_t>(counted - found, 0);
  return samples;
}

Contents read_all(SQLite::Database& database, Care care) {
  const SQLite::Transaction moment(database);
  Contents contents;
  contents.tables = read_tables(database, care);
  contents.samples = read_samples(database, contents.tables, care, Uids::read);
  return contents;
}

void at_usual_pace(Samples& samples, const Tables& tables) {
  const auto usual = usual_paces(samples, tables);
  std::map<std::pair<std::int64_t, std::int64_t>, double> of;  // run, library
  for (SampleRow& row : samples.rows) {
    Sample& s = row.sample;
    if (std::isnan(s.slowness)) {
      s.slowness = 1;
      continue;
    }
    const auto [at, is_new] = of.try_emplace({row.run, row.library});
    if (is_new) at->second = usual.at(origin_of(row, tables));
    const double slowness = s.slowness / at->second;
    s.seconds = slowed(s.kernel, s.seconds, 1 / slowness);
    s.spread *= 1 / slowness;
    s.slowness = slowness;
  }
}

std::optional<double> usual_pace(const Contents& contents, std::int64_t machine, std::string_view assur,
                                 std::string_view build) {
  const auto usual = usual_paces(contents.samples, contents.tables);
  const auto found = usual.find({machine, assur, build});
  return found == usual.end() ? std::nullopt : std::optional(found->second);
}

std::int64_t checksum(const Sample& sample, const Library& library, const std::string& run,
                      const std::string& machine) {
  return sum_of(sample, sample.uid, name(sample.kernel), checksum(sample.shape), sum_of(to_string(sample.strategy)),
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
