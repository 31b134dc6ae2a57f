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

using Row = SQLite::Statement;
using TakeRow = std::function<void(Row&)>;

constexpr std::int64_t kMostReserved = 10'000;    // samples; limits a damaged count
constexpr std::int64_t kFurthestLookup = 10'000;  // ids beyond the last one seen, if the end of a table is damaged

// Reads rows in the order of their ids. If they are out of order, the tree of the table is damaged. Returns the last
// id.
std::int64_t scan(SQLite::Database& database, const std::string& select, const TakeRow& take, bool ascending = true) {
  Row row(database, select);
  for (std::int64_t last = 0;;) {
    if (!row.executeStep()) return last;
    const std::int64_t id = row.getColumn(0).getInt64();
    if (ascending && id <= last) throw SQLite::Exception("rows are out of order", SQLITE_CORRUPT);
    last = id;
    take(row);
  }
}

// Reads from the front to the first damage, from the back to the last damage, and the rows between them one by one.
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
    scan(database, select + " ORDER BY id", [&](Row& row) {
      take(row);
      front = row.getColumn(0).getInt64();
    });
    whole = true;
  });
  if (whole) return;
  attempt([&] {
    Row row(database, select + " ORDER BY id DESC");
    while (row.executeStep()) {
      const std::int64_t id = row.getColumn(0).getInt64();
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
        row.tryReset();
        row.bind(1, id);
        if (row.executeStep() && row.getColumn(0).getInt64() == id) take(row);
      });
    }
  });
}

// index: an index that holds all selected columns; it replaces lost pages of the table.
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

std::int32_t integer(Row& row, int column) { return row.getColumn(column).getInt(); }

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

Host host_of(Row& row) {
  Host host;
  host.vendor = row.getColumn(1).getString();
  host.family = integer(row, 2);
  host.model = integer(row, 3);
  host.stepping = integer(row, 4);
  host.machine.model = row.getColumn(5).getString();
  host.machine.instructions = row.getColumn(6).getString();
  host.machine.cores = numbered(row.getColumn(7).getInt64());
  host.machine.processors = integer(row, 8);
  host.machine.quota = row.getColumn(9).getDouble();
  host.machine.caches = caches_of(row.getColumn(10).getString());
  host.machine.numa_nodes = integer(row, 11);
  host.memory = row.getColumn(12).getInt64();
  return host;
}

RunRow run_of(Row& row) {
  RunRow r;
  r.run.id = row.getColumn(0).getInt64();
  r.run.uid = row.getColumn(1).getString();
  r.machine = row.getColumn(2).getInt64();
  r.run.profile = row.getColumn(3).getString();
  r.run.assur = row.getColumn(4).getString();
  r.run.started = row.getColumn(5).getString();
  r.run.threads = integer(row, 6);
  r.run.load = row.getColumn(7).getDouble();
  r.microcode = row.getColumn(8).getString();
  r.process = row.getColumn(9).getInt64();
  r.samples = row.getColumn(15).getInt64();
  r.run.finished = !row.getColumn(10).isNull();
  if (!r.run.finished) return r;
  r.finished = row.getColumn(10).getString();
  r.run.grade = row.getColumn(11).getString();
  r.run.seconds = row.getColumn(12).getDouble();
  r.run.coverage = row.getColumn(13).getDouble();
  r.run.note = row.getColumn(14).getString();
  return r;
}

Shape shape_of(Row& row) {
  Shape s;
  s.n = integer(row, 1);
  s.nnz = integer(row, 2);
  s.groups = integer(row, 3);
  s.rhs = integer(row, 4);
  s.fill = row.getColumn(5).getInt64();
  s.operations = row.getColumn(6).getInt64();
  s.depth = row.getColumn(7).getInt64();
  s.terms = row.getColumn(8).getInt64();
  // damaged, so its checksum must differ
  if (!parse_hexadecimal(row.getColumn(9).getText(), s.pattern)) s.pattern = ~s.pattern;
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

double or_nan(const SQLite::Column& column) { return column.isNull() ? kNan : column.getDouble(); }

// Checksum of everything that is stored with a sample; rows that it refers to enter with their checksums.
std::int64_t sum_of(const Sample& s, std::string_view kernel, std::uint64_t shape, std::uint64_t strategy,
                    std::uint64_t library, std::uint64_t run) {
  Checksum sum;
  sum << s.uid << kernel << s.seconds << s.spread << s.repetitions << s.backward_error << s.forward_error;
  if (!std::isnan(s.slowness)) sum << s.slowness;  // older schemas had no such column
  for (const std::uint64_t part : {shape, strategy, library, run}) sum << static_cast<std::int64_t>(part);
  return static_cast<std::int64_t>(sum.value());
}

template <class Value>
const Checked<Value>* find(const std::unordered_map<std::int64_t, Checked<Value>>& table, std::int64_t id) {
  const auto found = table.find(id);
  return found == table.end() ? nullptr : &found->second;
}

void take_sample(Row& row, const Tables& tables, Samples& samples) {
  SampleRow r;
  Sample& s = r.sample;
  r.id = row.getColumn(0).getInt64();
  s.uid = row.getColumn(1).getText();
  r.run = row.getColumn(2).getInt64();
  r.library = row.getColumn(3).getInt64();
  const SQLite::Column kernel = row.getColumn(4);
  s.seconds = row.getColumn(7).getDouble();
  s.spread = row.getColumn(8).getDouble();
  s.repetitions = row.getColumn(9).getInt64();
  s.backward_error = or_nan(row.getColumn(10));
  s.forward_error = or_nan(row.getColumn(11));
  s.slowness = or_nan(row.getColumn(13));
  const auto* const shape = find(tables.shapes, row.getColumn(5).getInt64());
  const auto* const strategy = find(tables.strategies, row.getColumn(6).getInt64());
  const auto* const library = find(tables.libraries, r.library);
  const auto run = tables.runs.find(r.run);
  const bool whole = shape && strategy && library && run != tables.runs.end() &&
                     sum_of(s, kernel.getText(), shape->sum, strategy->sum, library->sum, run->second.sum) ==
                         row.getColumn(12).getInt64();
  if (!whole) {
    ++samples.damaged;
    return;
  }
  const auto kind = kernel_of(kernel.getText());
  if (!kind || !strategy->value) {
    ++samples.unknown;
    return;
  }
  s.kernel = *kind;
  s.shape = shape->value;
  s.strategy = *strategy->value;
  samples.rows.push_back(std::move(r));
}

// The work that measures the pace is fixed for one version and build of assur.
using PaceOrigin = std::tuple<std::int64_t, std::string_view, std::string_view>;  // machine, assur, build

PaceOrigin origin_of(const SampleRow& row, const Tables& tables) {
  const RunRow& run = tables.runs.at(row.run).value;
  return {run.machine, run.run.assur, tables.libraries.at(row.library).value.build};
}

// Other programs only slow a machine down, so the lower quartile is the usual pace.
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

// Files of an older schema are read as well: `otherwise` replaces a column that they lack.
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
       [&](Row& row) { tables.machines[row.getColumn(0).getInt64()] = host_of(row); });
  each(database, care,
       "SELECT id, uid, machine, profile, assur, started, threads, load, microcode, process, finished, grade, seconds, "
       "coverage, note, " +
           column_or(database, "tuning_run", "samples", "0") + " FROM tuning_run",
       [&](Row& row) {
         RunRow r = run_of(row);
         const auto machine = tables.machines.find(r.machine);
         if (machine == tables.machines.end()) return;
         r.run.machine = machine->second.fingerprint();
         const std::uint64_t sum = sum_of(r.run.uid, r.run.machine);
         const std::int64_t id = r.run.id;
         tables.runs.insert_or_assign(id, Checked<RunRow>{std::move(r), sum});
       });
  each(
      database, care, "SELECT id, name, version, build FROM library",
      [&](Row& row) {
        Library library{row.getColumn(1).getString(), row.getColumn(2).getString(), row.getColumn(3).getString()};
        const std::uint64_t sum = sum_of(library);
        tables.libraries.insert_or_assign(row.getColumn(0).getInt64(), Checked<Library>{std::move(library), sum});
      },
      "sqlite_autoindex_library_1");
  return tables;
}

void read_subjects(SQLite::Database& database, Tables& tables, Care care) {
  each(
      database, care, "SELECT id, n, nnz, groups, rhs, fill, operations, depth, terms, pattern FROM shape",
      [&](Row& row) {
        const Shape shape = shape_of(row);
        tables.shapes.insert_or_assign(row.getColumn(0).getInt64(), Checked<Shape>{shape, checksum(shape)});
      },
      "sqlite_autoindex_shape_1");
  each(
      database, care, "SELECT id, text FROM strategy",
      [&](Row& row) {
        const std::string text = row.getColumn(1).getString();
        tables.strategies.insert_or_assign(row.getColumn(0).getInt64(),
                                           Checked<std::optional<Strategy>>{strategy_of(text), sum_of(text)});
      },
      "sqlite_autoindex_strategy_1");
}

Tables read_tables(SQLite::Database& database, Care care) {
  Tables tables = read_origins(database, care);
  read_subjects(database, tables, care);
  return tables;
}

Samples read_samples(SQLite::Database& database, const Tables& tables, Care care, std::span<const std::int64_t> runs) {
  Samples samples;
  const TakeRow take = [&](Row& row) { take_sample(row, tables, samples); };
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
  contents.samples = read_samples(database, contents.tables, care);
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
