// Input: changes to a small tuning database, one after another.
//   v TABLE ROW COLUMN TYPE ...  sets a value: one byte each, counted from 0; TYPE 0: null, 1: 8 bytes of an integer,
//                                2: 8 bytes of a double, 3: a text, length first. Checksums are then corrected.
//   b AT AT AT LENGTH ...        overwrites bytes of the file; AT: little-endian
//   t AT AT AT                   cuts the file off
// Values are changed before bytes, in whatever order the input lists them. Incomplete or impossible changes are
// skipped.
#include <SQLiteCpp/SQLiteCpp.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <vector>

#include "db/machine_model.hpp"
#include "db/reader.hpp"
#include "db/samples.hpp"
#include "fuzz/targets.hpp"
#include "parallel/file_tree.hpp"

namespace assur::fuzz {
namespace {

namespace fs = std::filesystem;
using db::Access;
using db::Store;

constexpr std::array kTables = {"machine", "library", "tuning_run", "shape", "strategy", "sample", "model"};
const db::Host kHost = test::host_with(4);

class Input {
 public:
  explicit Input(std::string_view bytes) : left_(bytes) {}

  [[nodiscard]] bool empty() const { return left_.empty(); }
  std::string_view take(std::size_t size) {
    const std::string_view taken = left_.substr(0, size);
    left_.remove_prefix(taken.size());
    return taken;
  }
  // A number of `size` bytes, little-endian; missing bytes are 0.
  std::uint64_t number(std::size_t size) {
    std::uint64_t value = 0;
    const std::string_view bytes = take(size);
    for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    return value;
  }

 private:
  std::string_view left_;
};

// A database with one sample of each kernel, by two backends, in small pages.
std::string make_seed(const fs::path& file) {
  {
    Store store(file, Access::write);
    const std::int64_t run = store.begin_run(kHost, "quick");
    std::vector<Sample> samples;
    for (std::int32_t kernel = 0; kernel <= static_cast<std::int32_t>(Kernel::around); ++kernel) {
      samples.push_back(test::sample_of(kernel, kernel % 2 == 0 ? "eigen" : "lanes", static_cast<Kernel>(kernel)));
    }
    store.add(run, samples, 1e-6);
    store.finish_run(run, {});
    store.put_model(kHost, "fit", "{}");
  }
  SQLite::Database database(file.string(), SQLite::OPEN_READWRITE);
  database.exec("PRAGMA journal_mode = DELETE; PRAGMA page_size = 512; VACUUM");
  return test::bytes(file);
}

void set_value(SQLite::Database& database, Input& input) {
  const std::string table = kTables[input.number(1) % kTables.size()];
  const auto row = static_cast<std::int64_t>(input.number(1)) + 1;
  std::vector<std::string> columns;
  SQLite::Statement list(database, "SELECT name FROM pragma_table_info(?1)");
  for (list.bind(1, table); list.executeStep();) columns.push_back(list.getColumn(0).getString());
  const std::string column = columns[input.number(1) % columns.size()];
  SQLite::Statement set(database, "UPDATE OR IGNORE " + table + " SET " + column + " = ?1 WHERE rowid = ?2");
  set.bind(2, row);
  switch (input.number(1) % 4) {
    case 1:
      set.bind(1, static_cast<std::int64_t>(input.number(8)));
      break;
    case 2: {
      const std::uint64_t bits = input.number(8);
      double number = 0;
      std::memcpy(&number, &bits, sizeof number);
      set.bind(1, number);
      break;
    }
    case 3:
      set.bind(1, std::string(input.take(input.number(1))));
      break;
    default:
      break;
  }
  try {
    set.exec();
  } catch (const SQLite::Exception&) {  // the table takes no such value
  }
}

// Gives the changed samples valid checksums, as if they had been measured.
void fit_checksums(SQLite::Database& database) {
  const db::Tables tables = db::read_tables(database);
  SQLite::Statement rows(database,
                         "SELECT id, uid, run, library, kernel, shape, strategy, seconds, spread, repetitions, "
                         "backward_error, forward_error, slowness FROM sample");
  SQLite::Statement fit(database, "UPDATE sample SET checksum = ?1 WHERE id = ?2");
  const auto real = [&](int column) {
    return rows.getColumn(column).isNull() ? std::nan("") : rows.getColumn(column).getDouble();
  };
  while (rows.executeStep()) {
    try {
      Sample s;
      s.uid = rows.getColumn(1).getString();
      const db::RunRow& run = tables.runs.at(rows.getColumn(2).getInt64()).value;
      s.kernel = parse_kernel(rows.getColumn(4).getText());
      s.shape = tables.shapes.at(rows.getColumn(5).getInt64()).value;
      s.strategy = tables.strategies.at(rows.getColumn(6).getInt64()).value.value();
      s.seconds = real(7);
      s.spread = real(8);
      s.repetitions = rows.getColumn(9).getInt64();
      s.backward_error = real(10);
      s.forward_error = real(11);
      s.slowness = real(12);
      fit.reset();
      fit.bind(1, db::checksum(s, tables.libraries.at(rows.getColumn(3).getInt64()).value, run.run.uid,
                               tables.machines.at(run.machine).fingerprint()));
      fit.bind(2, rows.getColumn(0).getInt64());
      fit.exec();
    } catch (const std::exception&) {  // the row is missing or of a later version: the reader reports this
    }
  }
}

void change_values(const fs::path& file, std::string_view changes) {
  SQLite::Database database(file.string(), SQLite::OPEN_READWRITE);
  database.exec("PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY; BEGIN");
  bool changed = false;
  for (Input input(changes); !input.empty();) {
    const char what = input.take(1).front();
    if (what == 'v') set_value(database, input);
    if (what == 'b') {
      input.take(3);
      input.take(input.number(1));
    }
    if (what == 't') input.take(3);
    changed = changed || what == 'v';
  }
  try {
    if (changed) fit_checksums(database);
  } catch (const SQLite::Exception&) {  // the tables cannot be read
  }
  database.exec("COMMIT");
}

std::string change_bytes(std::string text, std::string_view changes) {
  for (Input input(changes); !input.empty();) {
    const char what = input.take(1).front();
    if (what == 'v') {
      input.take(3);
      const std::uint64_t type = input.number(1) % 4;
      if (type == 1 || type == 2) input.take(8);
      if (type == 3) input.take(input.number(1));
    }
    if (what == 'b' && !text.empty()) {
      const std::size_t at = input.number(3) % text.size();
      const std::string_view bytes = input.take(input.number(1)).substr(0, text.size() - at);
      text.replace(at, bytes.size(), bytes);
    }
    if (what == 't') text.resize(input.number(3) % (text.size() + 1));
  }
  return text;
}

void ask(const Store& store) {
  (void)store.samples();
  (void)store.runs();
  (void)store.usual_pace(kHost);
  (void)store.model(kHost, "fit");
  (void)store.sample_rows();
  (void)store.best();
  (void)store.crossovers();
  (void)store.models();
  (void)store.counts();
}

// Predictions are finite times with finite factors, whatever samples were accepted.
void predict(const PerformanceModel& model) {
  const auto is_time = [](const Prediction& p) {
    return p.seconds >= 0 && std::isfinite(p.seconds) && p.factor >= 1 && std::isfinite(p.factor);
  };
  for (const std::int32_t n : {1, 6, 200}) {
    const Shape shape{.n = n, .nnz = 3 * n, .groups = 1, .fill = 5 * n, .operations = 9 * n, .depth = 2 * n};
    for (const char* text : {"groups/eigen", "irreducible/lanes:8"}) {
      const Strategy strategy = parse_strategy(text);
      require(is_time(model.pack(shape, strategy)), "the time of a pack must be finite and not negative");
      for (const Kernel kernel : {Kernel::evaluate, Kernel::factor, Kernel::solve, Kernel::pack, Kernel::step}) {
        require(is_time(model.kernel(kernel, shape, strategy)), "the time of a kernel must be finite and not negative");
      }
      require(!std::isnan(model.backward_error(shape, strategy)), "an error must be a number");
    }
    require(is_time(model.around(n)), "the time around packs must be finite and not negative");
  }
  require(is_time(model.meeting(2)), "the time of a meeting must be finite and not negative");
  require(model.contention(2, 6) >= 1, "the factor of contention must be at least 1");
}

}  // namespace

bool database(std::string_view bytes) {
  static test::FileTree folder;
  static const std::string seed = make_seed(folder.root() / "seed.db");
  for (const auto& entry : fs::directory_iterator(folder.root())) fs::remove(entry.path());
  const fs::path file = folder.root() / "tuning.db", other = folder.root() / "other.db";
  test::write_bytes(file, seed);
  change_values(file, bytes);
  const std::string changed = change_bytes(test::bytes(file), bytes);
  fs::remove(file.string() + "-journal");
  test::write_bytes(file, changed);
  test::write_bytes(other, seed);

  const bool read = accepts([&] { ask(Store(file, Access::read)); });
  const std::vector<db::DatabaseFile> files = {{file, db::DatabaseFile::Role::named}};
  const MachineModel model = db::read_machine_model(files, kHost, db::library_at_hand);
  predict(*model.model);
  (void)accepts([&] { (void)Store(other, Access::write).import_from(file); });
  require(test::bytes(file) == changed, "reading must not change the file");
  (void)accepts([&] { ask(Store(file, Access::write)); });  // puts it aside if it is damaged
  return read;
}

}  // namespace assur::fuzz
