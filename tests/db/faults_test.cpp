// Faults of database files: no crash, no wrong samples.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>

#include "db/connection.hpp"
#include "db/contents.hpp"
#include "db/machine_model.hpp"
#include "db/samples.hpp"
#include "db/writer.hpp"
#include "parallel/file_tree.hpp"
#include "parallel/in_a_child.hpp"
#include "simulation/random_count.hpp"
#include "source_dir.hpp"

namespace assur::test {
namespace {

namespace fs = std::filesystem;
using db::Access;
using db::Store;
using db::Trouble;

MachineModel model_of(const fs::path& file) {
  const std::vector<db::DatabaseFile> files = {{file, db::DatabaseFile::Role::named}};
  return db::read_machine_model(files, host_with(4), db::library_at_hand);
}

// Why a file cannot be opened; nothing if it can.
std::optional<Trouble> trouble(const fs::path& file, Access access, std::string* what = nullptr) {
  try {
    const Store store(file, access);
    (void)store.samples();
  } catch (const db::Unusable& unusable) {
    if (what) *what = unusable.what();
    EXPECT_EQ(unusable.kind(), Error::Kind::environment);
    EXPECT_EQ(std::string(unusable.what()).rfind(file.string() + ": ", 0), 0u) << unusable.what();
    return unusable.trouble();
  }
  return std::nullopt;
}

std::vector<fs::path> files_put_aside(const fs::path& file) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(file.parent_path())) {
    const std::string name = entry.path().filename().string();
    const bool is_part = name.ends_with("-wal") || name.ends_with("-shm");
    if (name.starts_with(file.filename().string() + ".corrupt-") && !is_part) found.push_back(entry.path());
  }
  return found;
}

// A refused file is not changed; the runtime continues with a message.
void expect_left_alone(const fs::path& file, Trouble expected) {
  const std::string before = bytes(file);
  EXPECT_EQ(trouble(file, Access::write), expected);
  EXPECT_EQ(trouble(file, Access::read), expected);
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 0u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_NE(model.messages[0].find(file.string()), std::string::npos);
  EXPECT_EQ(bytes(file), before);
  EXPECT_TRUE(files_put_aside(file).empty());
}

TEST(Faults, ATextFileIsLeftAlone) {
  FileTree tree;
  tree.file("notes.txt", "buy milk\n").file("long.txt", std::string(5000, 'x'));
  expect_left_alone(tree.root() / "notes.txt", Trouble::foreign);
  expect_left_alone(tree.root() / "long.txt", Trouble::foreign);
}

TEST(Faults, TheDatabaseOfAnotherProgramIsLeftAlone) {
  FileTree tree;
  const auto file = tree.root() / "photos.db";
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec("PRAGMA application_id = 1; CREATE TABLE photo (id INTEGER PRIMARY KEY)");
  expect_left_alone(file, Trouble::foreign);
}

TEST(Faults, ANewerSchemaIsLeftAlone) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 20);
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec("PRAGMA user_version = 99");
  expect_left_alone(file, Trouble::newer);
}

// An artificial version 1 and its migrations to an artificial version 3.
TEST(Faults, UpdatesAnOlderSchemaInOneTransaction) {
  SQLite::Database database(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  database.exec(
      "CREATE TABLE thing (id INTEGER PRIMARY KEY, name TEXT); INSERT INTO thing VALUES (1, 'old');"
      "PRAGMA user_version = 1");
  const db::Migration good[] = {{1, "ALTER TABLE thing ADD COLUMN size INTEGER DEFAULT 7"},
                                {2, "UPDATE thing SET size = size + 1; CREATE TABLE other (id INTEGER PRIMARY KEY)"}};
  const db::Migration bad[] = {good[0], {2, "UPDATE thing SET size = 9; UPDATE nothing SET size = 1"}};
  const auto version = [&] { return database.execAndGet("PRAGMA user_version").getInt(); };
  EXPECT_THROW(db::bring_up_to_date(database, "", bad, 3), SQLite::Exception);
  EXPECT_EQ(version(), 1);
  EXPECT_THROW((void)database.execAndGet("SELECT size FROM thing"), SQLite::Exception);
  EXPECT_THROW(db::bring_up_to_date(database, "", std::span(good).first(1), 3), SQLite::Exception);
  EXPECT_EQ(version(), 1);

  db::bring_up_to_date(database, "CREATE TABLE thing (id INTEGER)", good, 3);
  EXPECT_EQ(version(), 3);
  EXPECT_EQ(database.execAndGet("SELECT name || size FROM thing").getString(), "old8");
  db::bring_up_to_date(database, "", good, 3);  // already up to date
  EXPECT_EQ(database.execAndGet("SELECT size FROM thing").getInt(), 8);
}

// A database of version 2, or of version 1, which only lacks the table of fits and its triggers.
std::int64_t make_old_database(const fs::path& file, std::int32_t version) {
  SQLite::Database old(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  old.exec(bytes(fs::path(ASSUR_SOURCE_DIR) / "tests/data/databases/version_2.sql"));
  if (version == 1) {
    old.exec("DROP TRIGGER sample_added; DROP TRIGGER sample_changed; DROP TRIGGER sample_removed; DROP TABLE fit");
  }
  old.exec("PRAGMA user_version = " + std::to_string(version));
  return old.execAndGet("SELECT count(*) FROM sample").getInt64();
}

// The schema of a database, without white space.
std::string schema_of(SQLite::Database& database) {
  std::string text;
  SQLite::Statement columns(database,
                            "SELECT t.name || ' ' || group_concat(c.name || ' ' || c.type || c.\"notnull\" || c.pk || "
                            "coalesce(c.dflt_value, '')) FROM pragma_table_list t, pragma_table_info(t.name) c "
                            "WHERE t.schema = 'main' AND t.type = 'table' GROUP BY t.name ORDER BY t.name");
  while (columns.executeStep()) text += columns.getColumn(0).getString() + '\n';
  SQLite::Statement rest(database, "SELECT sql FROM sqlite_schema WHERE type != 'table' AND sql != '' ORDER BY name");
  while (rest.executeStep()) text += rest.getColumn(0).getString() + '\n';
  return text;
}

class OlderSchema : public testing::TestWithParam<std::int32_t> {};

TEST_P(OlderSchema, IsReadUnchangedAndKeepsItsSamples) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const std::int64_t samples = make_old_database(file, GetParam());
  ASSERT_GT(samples, 20);
  const std::string before = bytes(file);
  const std::vector<Sample> read = Store(file, Access::read).samples();
  EXPECT_EQ(read.size(), static_cast<std::size_t>(samples));
  EXPECT_EQ(Store(file, Access::read).health().damaged, 0);
  EXPECT_EQ(Store(file, Access::read).runs().at(0).samples, samples);
  EXPECT_FALSE(Store(file, Access::read).best().rows.empty());
  EXPECT_EQ(Store(file, Access::read).export_to(tree.root() / "export.db"), samples);
  EXPECT_EQ(bytes(file), before);

  const Store store(file, Access::write);
  EXPECT_TRUE(store.messages().empty());
  const auto kept = store.samples(), exported = Store(tree.root() / "export.db", Access::read).samples();
  ASSERT_EQ(kept.size(), read.size());
  ASSERT_EQ(exported.size(), read.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_TRUE(same(kept[i], read[i]));
    EXPECT_TRUE(same(exported[i], read[i]));
  }
  EXPECT_EQ(store.health().lost, 0);
  SQLite::Database database(file.string());
  EXPECT_EQ(database.execAndGet("PRAGMA user_version").getInt(), db::kSchemaVersion);
  EXPECT_EQ(database.execAndGet("SELECT sum(samples) FROM tuning_run").getInt64(), samples);
  SQLite::Database fresh(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  fresh.exec(std::string(db::kSchema));
  EXPECT_EQ(schema_of(database), schema_of(fresh));
}

INSTANTIATE_TEST_SUITE_P(Faults, OlderSchema, testing::Values(1, 2), testing::PrintToStringParamName());

TEST(Faults, MigrationsLeadToThisVersion) {
  std::int32_t version = 1;
  for (const db::Migration& step : db::migrations()) EXPECT_EQ(step.from, version++);
  EXPECT_EQ(version, db::kSchemaVersion);
}

TEST(Faults, AFullDiskLosesOnlyTheCurrentCell) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const int status = in_a_child([&] {
    signal(SIGXFSZ, SIG_IGN);
    Store store(file, Access::write);
    const std::int64_t run = store.begin_run(host_with(4), "quick");
    const rlimit limit{400'000, 400'000};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return 1;
    for (int cell = 0; cell < 1000; ++cell) {
      try {
        store.add(run, cell_of(cell, 10));
      } catch (const Error& error) {
        const bool kept = store.samples().size() == static_cast<std::size_t>(10 * cell);
        return error.kind() == Error::Kind::environment && kept && cell > 0 ? 0 : 2;
      }
    }
    return 3;
  });
  ASSERT_EQ(status, 0);
  Store store(file, Access::write);
  EXPECT_TRUE(store.messages().empty());
  EXPECT_GT(store.samples().size(), 0u);
  EXPECT_EQ(store.samples().size() % 10, 0u);
  const auto run = store.unfinished_run(host_with(4), "quick");
  ASSERT_TRUE(run);
  store.add(*run, cell_of(1000, 10));
}

// A writer is killed in a transaction that is large enough to be partly on the disk, with and without a write-ahead
// log.
class Killed : public testing::TestWithParam<bool> {};

TEST_P(Killed, LosesOnlyTheCurrentCell) {
  const bool network = GetParam();
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const auto stored = make_database(file, host_with(4), 200);
  const int status = in_a_child([&]() -> int {
    SQLite::Database database = db::open_to_write(file, network);
    database.exec(
        "PRAGMA cache_size = 1; BEGIN IMMEDIATE; UPDATE sample SET seconds = 1, checksum = 0, kernel = "
        "'" +
        std::string(2000, 'x') + "'");
    return raise(SIGKILL);
  });
  ASSERT_EQ(status, 127);  // ended by a signal
  ASSERT_GT(fs::file_size(file.string() + (network ? "-journal" : "-wal")), 0u);
  // The runtime can read a write-ahead log, but it cannot apply a journal, which needs write access.
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), network ? 0u : 200u);
  ASSERT_EQ(model.messages.size(), network ? 1u : 0u);
  for (const std::string& message : model.messages) EXPECT_NE(message.find("cut off"), std::string::npos) << message;
  Store store(file, Access::write);
  EXPECT_TRUE(store.messages().empty());
  const auto found = store.samples();
  ASSERT_EQ(found.size(), stored.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_TRUE(same(found[i], stored[i]));
}

INSTANTIATE_TEST_SUITE_P(Faults, Killed, testing::Bool(),
                         [](const auto& how) { return how.param ? "WithAJournal" : "WithALog"; });

TEST(Faults, ABusyDatabaseCanBeRead) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 50);
  SQLite::Database writer = db::open_to_write(file, false);
  writer.exec("BEGIN IMMEDIATE; DELETE FROM sample");
  EXPECT_EQ(model_of(file).model->samples(), 50u);
  writer.exec("COMMIT");
  EXPECT_EQ(model_of(file).model->samples(), 0u);
}

// A tuner leaves a file at rest, or in the mode of a write-ahead log if there was a reader.
class ReadOnly : public testing::TestWithParam<bool> {};

TEST_P(ReadOnly, FolderIsReadButNotWritten) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 50);
  if (GetParam()) SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec("PRAGMA journal_mode = WAL");
  fs::permissions(file, fs::perms(0444));
  fs::permissions(tree.root(), fs::perms(0555));
  const int status = in_a_child([&] {
    if (getuid() == 0 && setuid(65534) != 0) return 1;  // root may write everywhere
    if (model_of(file).model->samples() != 50) return 2;
    if (trouble(file, Access::read) != std::nullopt) return 3;
    if (trouble(file, Access::write) != Trouble::blocked) return 4;
    return trouble(file.parent_path() / "new/tuning.db", Access::write) == Trouble::blocked ? 0 : 5;
  });
  fs::permissions(tree.root(), fs::perms(0755));
  EXPECT_EQ(status, 0);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(tree.root())) ++files;
  EXPECT_EQ(files, 1u);  // no other file was left
}

INSTANTIATE_TEST_SUITE_P(Faults, ReadOnly, testing::Bool(),
                         [](const auto& how) { return how.param ? "InALogsMode" : "AtRest"; });

TEST(Faults, ReportsAMissingDatabaseOnlyIfItWasNamed) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  EXPECT_EQ(trouble(file, Access::read), Trouble::absent);
  EXPECT_EQ(model_of(file).messages.size(), 1u);
  const std::vector<db::DatabaseFile> users = {{file, db::DatabaseFile::Role::user}};
  EXPECT_TRUE(db::read_machine_model(users, host_with(4), db::library_at_hand).messages.empty());
  EXPECT_FALSE(fs::exists(file));
  tree.file("tuning.db", "");
  EXPECT_EQ(trouble(file, Access::read), Trouble::absent);
  EXPECT_EQ(trouble(file, Access::write), std::nullopt);
}

TEST(Faults, SkipsADamagedSample) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const auto stored = make_database(file, host_with(4), 50);
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec("UPDATE sample SET seconds = seconds * 2 WHERE id = 7");
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 49u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_NE(model.messages[0].find("1 damaged"), std::string::npos) << model.messages[0];
  EXPECT_EQ(Store(file, Access::read).health().damaged, 1);
  const std::string before = bytes(file);
  const Store store(file, Access::write);
  ASSERT_EQ(store.messages().size(), 1u);
  ASSERT_EQ(files_put_aside(file).size(), 1u);
  EXPECT_NE(store.messages()[0].find(files_put_aside(file)[0].string()), std::string::npos) << store.messages()[0];
  EXPECT_EQ(store.samples().size(), 49u);
  std::size_t parts = 0;  // files that were put aside; a journal or log would be another one
  for (const auto& entry : fs::directory_iterator(tree.root())) {
    parts += entry.path().filename().string().find(".corrupt-") != std::string::npos ? 1 : 0;
  }
  EXPECT_EQ(parts, 1u);
  EXPECT_EQ(store.health().damaged, 0);
  EXPECT_EQ(store.runs().at(0).grade, "good");
  EXPECT_FALSE(by_uid(store.samples()).contains(stored[6].uid));
}

// The remaining samples are valid and kept.
TEST(Faults, ReportsLostSamplesAndRepairsTheFile) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 50);
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec("UPDATE sample SET seconds = seconds * 2 WHERE id = 7");
  MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 49u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_EQ(model.messages[0], "1 damaged sample is left out; `assur db check` repairs the database");

  SQLite::Database(file.string(), SQLite::OPEN_READWRITE)
      .exec("DROP TRIGGER sample_removed; DELETE FROM sample WHERE id = 7 OR id = 9");
  model = model_of(file);
  EXPECT_EQ(model.model->samples(), 48u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_EQ(model.messages[0], "2 of 50 samples are lost; `assur db check` repairs the database");
  EXPECT_EQ(Store(file, Access::read).health().lost, 2);

  const Store store(file, Access::write);
  ASSERT_EQ(store.messages().size(), 1u);
  EXPECT_EQ(store.messages()[0].rfind(file.string() + ": 2 samples are lost. It was renamed to ", 0), 0u)
      << store.messages()[0];
  EXPECT_EQ(store.samples().size(), 48u);
  EXPECT_EQ(store.health().lost, 0);
  EXPECT_TRUE(model_of(file).messages.empty());
}

// Rows that were removed with SQL.
TEST(Faults, DoesNotCountRemovedSamplesAsLost) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 50);
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec("DELETE FROM sample WHERE id > 40");
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 40u);
  EXPECT_TRUE(model.messages.empty());
  EXPECT_TRUE(Store(file, Access::write).messages().empty());
}

// Many bytes in the middle are damaged, as by a failing disk. The whole file is left out.
TEST(Faults, ReportsAHoleInTheFile) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 500);
  std::string damaged = bytes(file);
  std::mt19937_64 random(20261121);
  const std::size_t at = damaged.size() / 2;
  for (std::size_t i = 0; i < 3000; ++i) damaged[at + i] = static_cast<char>(random());
  write_bytes(file, damaged);
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 0u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_EQ(model.messages[0], file.string() + ": is damaged: database disk image is malformed");
}

// The table `strategy` lies at the end of the file, because its first page was split late. If the end is cut off, the
// index of this table still has the rows.
TEST(Faults, ATruncatedFileKeepsItsRemainingSamples) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  {
    Store store(file, Access::write);
    const std::int64_t run = store.begin_run(host_with(4), "quick");
    std::vector<Sample> samples;
    for (int i = 0; i < 1200; ++i) {
      samples.push_back(sample_of(i % 20));
      samples.back().strategy.run.threads = 1 + (i < 1100 ? i % 40 : i - 1000);
    }
    store.add(run, samples);
    store.finish_run(run, {});
  }
  const auto pages = static_cast<int>(fs::file_size(file) / 4096 / 2);
  std::size_t there = 0;
  {
    SQLite::Database database(file.string());
    const std::string leaves = " FROM dbstat WHERE pagetype = 'leaf' AND name = ";
    ASSERT_GT(database.execAndGet("SELECT min(pageno)" + leaves + "'strategy'").getInt(), pages);
    there = static_cast<std::size_t>(
        database.execAndGet("SELECT sum(ncell)" + leaves + "'sample' AND pageno <= " + std::to_string(pages)).getInt());
  }
  fs::resize_file(file, static_cast<std::uintmax_t>(pages) * 4096);
  const Store store(file, Access::write);
  ASSERT_EQ(store.messages().size(), 1u);
  EXPECT_GT(there, 300u);
  EXPECT_EQ(store.samples().size(), there);
  EXPECT_TRUE(store.messages()[0].ends_with("; " + std::to_string(store.samples().size()) +
                                            " good samples were copied to a new file"))
      << store.messages()[0];
}

// The checksum of a sample includes the rows that it refers to.
TEST(Faults, SkipsSamplesWithDamagedReferences) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db", copy = tree.root() / "copy.db";
  make_database(file, host_with(4), 10);
  const std::pair<const char*, std::int64_t> changes[] = {
      {"UPDATE shape SET n = n + 1 WHERE id = 3", 1},
      {"UPDATE shape SET pattern = '000000000000000g' WHERE id = 3", 1},
      {"UPDATE strategy SET text = 'groups/klu'", 10},
      {"UPDATE strategy SET text = 'nonsense'", 10},
      {"UPDATE library SET version = '9'", 10},
      {"UPDATE machine SET cores = 5", 10},
      {"UPDATE tuning_run SET uid = 'x'", 10},
      {"UPDATE sample SET kernel = 'solve' WHERE id = 3", 1},
      {"UPDATE sample SET kernel = 'dance' WHERE id = 3", 1},
      {"UPDATE sample SET backward_error = NULL WHERE id = 3", 1},
      {"UPDATE sample SET slowness = 1 WHERE id = 3", 1},
      {"PRAGMA foreign_keys = OFF; DELETE FROM shape WHERE id = 3", 1},
  };
  for (const auto& [sql, damaged] : changes) {
    fs::copy_file(file, copy, fs::copy_options::overwrite_existing);
    SQLite::Database(copy.string(), SQLite::OPEN_READWRITE).exec(sql);
    const db::Health health = Store(copy, Access::read).health();
    EXPECT_EQ(health.damaged, damaged) << sql;
    EXPECT_EQ(health.samples, 10 - damaged) << sql;
  }
}

// Puts a sample into a database as it is, with a checksum that fits. slowness: time of the fixed work, s; NaN: unknown.
void put_unchecked(const fs::path& file, const Sample& sample) {
  SQLite::Database database(file.string(), SQLite::OPEN_READWRITE);
  const db::Tables tables = db::read_tables(database);
  const auto& [id, run] = *tables.runs.begin();
  db::Writer(database).sample(sample, tables.libraries.begin()->second.value, id, run.value.run.uid,
                              run.value.run.machine);
}

// A checksum tells nothing if another program computed it, or one with a fault.
TEST(Faults, SkipsImpossibleSamplesOfAnyChecksum) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db", copy = tree.root() / "copy.db";
  make_database(file, host_with(4), 20);
  const std::vector<std::function<void(Sample&)>> changes = {
      [](Sample& s) { s.seconds = 0; },
      [](Sample& s) { s.seconds = -1e-6; },
      [](Sample& s) { s.seconds = HUGE_VAL; },
      [](Sample& s) { s.seconds = 9e-316; },
      [](Sample& s) { s.seconds = 1e300; },
      [](Sample& s) { s.spread = -1e-9; },
      [](Sample& s) { s.spread = HUGE_VAL; },
      [](Sample& s) { s.slowness = 0; },
      [](Sample& s) { s.slowness = -1; },
      [](Sample& s) { s.slowness = HUGE_VAL; },
      [](Sample& s) { s.slowness = 9.4e-315; },
      [](Sample& s) { s.repetitions = -1; },
      [](Sample& s) { s.backward_error = -1e-16; },
      [](Sample& s) { s.forward_error = -HUGE_VAL; },
      [](Sample& s) { s.shape.n = -3; },
      [](Sample& s) { s.shape.groups = -1; },
      [](Sample& s) { s.shape.fill = std::numeric_limits<std::int64_t>::max(); },
      [](Sample& s) { s.shape.terms = std::numeric_limits<std::int64_t>::min(); },
  };
  for (std::size_t i = 0; i < changes.size(); ++i) {
    SCOPED_TRACE(i);
    fs::copy_file(file, copy, fs::copy_options::overwrite_existing);
    Sample bad = sample_of(30);
    bad.slowness = 1e-6;
    changes[i](bad);
    put_unchecked(copy, bad);
    EXPECT_EQ(Store(copy, Access::read).health().damaged, 1);
    const MachineModel model = model_of(copy);
    EXPECT_EQ(model.model->samples(), 20u);
    ASSERT_EQ(model.messages.size(), 1u);
    EXPECT_EQ(model.messages[0], "1 damaged sample is left out; `assur db check` repairs the database");
    EXPECT_EQ(Store(copy, Access::write).health().damaged, 0);
    EXPECT_EQ(model_of(copy).messages, std::vector<std::string>{});
    for (const fs::path& aside : files_put_aside(copy)) fs::remove(aside);
  }
}

// Each figure is possible, but the time and the slowness do not belong to each other.
TEST(Faults, SkipsTimesThatAreImpossibleAtTheUsualPace) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 20);
  for (int i = 30; i < 34; ++i) {
    Sample sample = sample_of(i);
    sample.slowness = i == 33 ? 1e8 : 1e-6;
    sample.seconds = i == 33 ? 1e-6 : sample.seconds;
    put_unchecked(file, sample);
  }
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 23u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_EQ(model.messages[0],
            "1 of 24 samples are left out, because their times at the usual pace are not 1e-15 to 1e9 s; run `assur "
            "tune`");
}

// Random faults cause no crash and no wrong row, and no good row is lost that could be read before.
TEST(Faults, SurvivesRandomFaults) {
  FileTree tree;
  const auto good = tree.root() / "good.db";
  const auto originals = by_uid(make_database(good, host_with(4), 300));
  const std::string whole = bytes(good);
  std::mt19937_64 random(20261121);
  const auto below = [&](std::size_t bound) { return static_cast<std::size_t>(random() % bound); };
  const auto expect_right = [&](const std::vector<Sample>& samples, const std::string& fault) {
    for (const Sample& sample : samples) {
      const auto original = originals.find(sample.uid);
      ASSERT_NE(original, originals.end()) << fault;
      ASSERT_TRUE(same(sample, original->second)) << fault;
    }
  };
  const int rounds = test::random_count(100);
  int repaired = 0, refused = 0, unharmed = 0;
  std::size_t saved = 0;
  for (int round = 0; round < rounds; ++round) {
    std::string damaged = whole;
    std::string fault = "round " + std::to_string(round);
    if (round % 4 == 0) {
      damaged.resize(below(whole.size()));
      fault += ": truncated to " + std::to_string(damaged.size());
    } else {
      const std::size_t count = std::size_t{1} << (round % 7), at = below(whole.size() - count);
      for (std::size_t i = 0; i < count; ++i) damaged[at + i] = static_cast<char>(random());
      fault += ": " + std::to_string(count) + " bytes at " + std::to_string(at);
    }
    SCOPED_TRACE(fault);
    const auto folder = tree.root() / std::to_string(round);
    fs::create_directory(folder);
    const auto file = folder / "tuning.db";
    write_bytes(file, damaged);

    // The runtime reads and reports errors, but writes nothing.
    MachineModel model;
    ASSERT_NO_THROW(model = model_of(file));
    EXPECT_LE(model.model->samples(), originals.size());
    std::vector<Sample> readable;
    try {
      readable = Store(file, Access::read).samples();
    } catch (const Error&) {
    }
    expect_right(readable, fault);
    EXPECT_LE(model.model->samples(), readable.size());
    EXPECT_EQ(model.messages.empty(), readable.size() == originals.size());
    EXPECT_EQ(bytes(file), damaged);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);

    // The tuner continues with the good samples, and keeps the damaged ones.
    std::vector<std::string> messages;
    std::vector<Sample> kept;
    try {
      Store store(file, Access::write);
      messages = store.messages();
      kept = store.samples();
      store.add(store.begin_run(host_with(4), "quick"), cell_of(1000, 2));
      EXPECT_EQ(store.samples().size(), kept.size() + 2);
    } catch (const db::Unusable& unusable) {
      EXPECT_TRUE(unusable.trouble() == Trouble::foreign || unusable.trouble() == Trouble::newer) << unusable.what();
      EXPECT_EQ(bytes(file), damaged);
      ++refused;
      continue;
    }
    expect_right(kept, fault);
    const auto kept_by_uid = by_uid(kept);
    for (const Sample& sample : readable) EXPECT_TRUE(kept_by_uid.contains(sample.uid));
    const auto aside = files_put_aside(file);
    EXPECT_EQ(aside.size(), messages.size());
    if (aside.empty()) {
      EXPECT_EQ(kept.size(), damaged.empty() ? 0 : originals.size());
      ++unharmed;
    } else {
      EXPECT_EQ(bytes(aside[0]).size(), damaged.size());
      saved += kept.size();
      ++repaired;
    }
  }
  // Most faults cause damage, and most rows of a damaged file are saved.
  RecordProperty("repaired", repaired);
  RecordProperty("refused", refused);
  RecordProperty("unharmed", unharmed);
  RecordProperty("saved", static_cast<int>(saved));
  EXPECT_GT(repaired, rounds / 2);
  EXPECT_LE(refused, rounds / 20);
  EXPECT_GT(saved, originals.size() * static_cast<std::size_t>(repaired) / 2);
}

}  // namespace
}  // namespace assur::test
