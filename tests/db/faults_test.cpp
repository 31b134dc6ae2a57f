// Faults of database files: no crash, no wrong samples. A file is used as a whole, or not at all.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <random>

#include "db/connection.hpp"
#include "db/machine_model.hpp"
#include "db/reader.hpp"
#include "db/samples.hpp"
#include "db/writer.hpp"
#include "parallel/file_tree.hpp"
#include "parallel/in_a_child.hpp"
#include "properties/random_count.hpp"
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
std::optional<Trouble> trouble(const fs::path& file, Access access, std::string* problem = nullptr) {
  try {
    const Store store(file, access);
    (void)store.samples();
  } catch (const db::Unusable& unusable) {
    if (problem) *problem = unusable.problem();
    EXPECT_EQ(unusable.kind(), Error::Kind::environment);
    EXPECT_EQ(std::string(unusable.what()).rfind(file.string() + ": ", 0), 0u) << unusable.what();
    return unusable.trouble();
  }
  return std::nullopt;
}

// Files beside `file` whose names begin with its name and `suffix`, without write-ahead logs and their indices.
std::vector<fs::path> files_beside(const fs::path& file, const std::string& suffix) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(file.parent_path())) {
    const std::string name = entry.path().filename().string();
    const bool is_part = name.ends_with("-wal") || name.ends_with("-shm");
    if (name.starts_with(file.filename().string() + suffix) && !is_part) found.push_back(entry.path());
  }
  return found;
}

void change(const fs::path& file, const std::string& sql) {
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec(sql);
}

// A copy in a folder of its own, without what a copy before it left there.
fs::path lone_copy(const fs::path& file) {
  const fs::path folder = file.parent_path() / "copy";
  fs::remove_all(folder);
  fs::create_directory(folder);
  fs::copy_file(file, folder / "tuning.db");
  return folder / "tuning.db";
}

// Reading refuses the file, says why and what to do, and changes nothing. Writing renames it and begins a new one.
void expect_put_aside(const fs::path& file, Trouble expected, const std::string& problem = "") {
  const std::string before = bytes(file);
  std::string found;
  EXPECT_EQ(trouble(file, Access::read, &found), expected);
  if (!problem.empty()) {
    EXPECT_EQ(found, file.string() + ": " + problem);
  }
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 0u);
  EXPECT_EQ(model.messages, std::vector<std::string>{found + "; `assur tune --db " + file.string() +
                                                     "` puts it aside and begins a new file"});
  EXPECT_EQ(bytes(file), before);
  EXPECT_EQ(files_beside(file, "").size(), 1u);

  const Store store(file, Access::write);
  const auto aside = files_beside(file, expected == Trouble::older ? ".old-" : ".corrupt-");
  ASSERT_EQ(aside.size(), 1u);
  EXPECT_EQ(store.messages(), std::vector<std::string>{found + ". It was renamed to " + aside[0].string() +
                                                       ", and a new file was begun; tune again"});
  EXPECT_TRUE(bytes(aside[0]) == before);
  EXPECT_TRUE(store.samples().empty());
  EXPECT_TRUE(store.runs().empty());
  EXPECT_TRUE(model_of(file).messages.empty());
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
  EXPECT_EQ(files_beside(file, ".").size(), 0u);
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
  change(file, "PRAGMA user_version = 99");
  expect_left_alone(file, Trouble::newer);
}

TEST(Faults, AnOlderSchemaIsPutAside) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE)
      .exec(bytes(fs::path(ASSUR_SOURCE_DIR) / "tests/data/databases/version_2.sql"));
  change(file, "PRAGMA user_version = 2");
  expect_put_aside(file, Trouble::older, "its schema has version 2, but this assur uses version 4");
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
  if (GetParam()) change(file, "PRAGMA journal_mode = WAL");
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

// "No permission" is no absence, which advises to tune.
TEST(Faults, AFileThatMustNotBeReadIsNotMissing) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 5);
  fs::permissions(tree.root(), fs::perms(0755));
  for (const fs::path& closed : {file, tree.root()}) {
    fs::permissions(closed, fs::perms::none);
    const int status = in_a_child([&] {
      if (getuid() == 0 && setuid(65534) != 0) return 1;  // root may read everywhere
      std::string problem;
      if (trouble(file, Access::read, &problem) != Trouble::blocked) return 2;
      if (problem.find("cannot be read: Permission denied") == std::string::npos) return 3;
      const std::vector<db::DatabaseFile> users = {{file, db::DatabaseFile::Role::user}};
      return db::read_machine_model(users, host_with(4), db::library_at_hand).messages.size() == 1 ? 0 : 4;
    });
    EXPECT_EQ(status, 0) << closed;
    fs::permissions(closed, fs::perms(0755));
  }
}

TEST(Faults, RootMakesNoFolderAmongThoseOfAUser) {
  if (getuid() != 0) GTEST_SKIP() << "needs root";
  FileTree tree;
  ASSERT_EQ(chown(tree.root().c_str(), 65534, 65534), 0);
  std::string problem;
  EXPECT_EQ(trouble(tree.root() / "share/assur/tuning.db", Access::write, &problem), Trouble::blocked);
  EXPECT_NE(problem.find("user 65534, who owns " + tree.root().string()), std::string::npos) << problem;
  EXPECT_TRUE(fs::is_empty(tree.root()));
  EXPECT_EQ(trouble(tree.root() / "tuning.db", Access::write), std::nullopt);
}

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

// The checksum of a sample includes the rows that it refers to.
TEST(Faults, AnyChangeOfASampleDamagesTheFile) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 10);
  const std::pair<const char*, int> changes[] = {
      // the first sample that has changed
      {"UPDATE sample SET seconds = seconds * 2 WHERE id = 7", 7},
      {"UPDATE sample SET kernel = 'solve' WHERE id = 3", 3},
      {"UPDATE sample SET kernel = 'dance' WHERE id = 3", 3},
      {"UPDATE sample SET backward_error = NULL WHERE id = 3", 3},
      {"UPDATE sample SET slowness = 1 WHERE id = 3", 3},
      {"UPDATE shape SET n = n + 1 WHERE id = 3", 3},
      {"UPDATE shape SET pattern = '000000000000000g' WHERE id = 3", 3},
      {"UPDATE strategy SET text = 'groups/klu'", 1},
      {"UPDATE strategy SET text = 'nonsense'", 1},
      {"UPDATE library SET version = '9'", 1},
      {"UPDATE machine SET cores = 5", 1},
      {"UPDATE tuning_run SET uid = 'x'", 1},
      {"PRAGMA foreign_keys = OFF; DELETE FROM shape WHERE id = 3", 3},
      {"DROP TRIGGER sample_removed; DELETE FROM sample WHERE id = 7 OR id = 9", 0},
  };
  for (const auto& [sql, sample] : changes) {
    SCOPED_TRACE(sql);
    const fs::path copy = lone_copy(file);
    change(copy, sql);
    expect_put_aside(copy, Trouble::damaged,
                     sample == 0 ? "is damaged: 10 samples were stored, but 8 are there"
                                 : "is damaged: sample " + std::to_string(sample) +
                                       ": it, or a row that it refers to, was changed or is missing");
  }
}

// The column is only written, so its damage is not found by reading rows.
TEST(Faults, ARenamedColumnDamagesTheFile) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 10);
  change(file, "ALTER TABLE strategy RENAME COLUMN q TO r");
  std::string problem;
  EXPECT_EQ(trouble(file, Access::read, &problem), Trouble::damaged);
  EXPECT_EQ(problem, file.string() + ": is damaged: its tables are not those of db/schema.sql");
  EXPECT_EQ(Store(file, Access::write).messages().size(), 1u);
}

// Rows that were removed with SQL.
TEST(Faults, RemovedSamplesAreNotMissing) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 50);
  change(file, "DELETE FROM sample WHERE id > 40");
  const MachineModel model = model_of(file);
  EXPECT_EQ(model.model->samples(), 40u);
  EXPECT_TRUE(model.messages.empty());
  EXPECT_TRUE(Store(file, Access::write).messages().empty());
}

// If the samples of this machine are damaged, those of a similar one in the same file are not used either.
TEST(Faults, NoOtherMachineOfADamagedFileIsUsed) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 10);
  make_database(file, host_with(8), 20);
  EXPECT_EQ(model_of(file).model->samples(), 10u);
  change(file, "UPDATE sample SET seconds = seconds * 2 WHERE id = 7");
  expect_put_aside(file, Trouble::damaged);
}

// Many bytes in the middle are damaged, as by a failing disk.
TEST(Faults, AHoleDamagesTheFile) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 500);
  std::string damaged = bytes(file);
  std::mt19937_64 random(20261121);
  const std::size_t at = damaged.size() / 2;
  for (std::size_t i = 0; i < 3000; ++i) damaged[at + i] = static_cast<char>(random());
  write_bytes(file, damaged);
  expect_put_aside(file, Trouble::damaged, "is damaged: database disk image is malformed");
}

// A log that stayed would be applied to the new file. Names that exist are not used again.
TEST(Faults, PutsALogAsideWithItsFile) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 10);
  const int status = in_a_child([&]() -> int {
    Store store(file, Access::write);
    store.add(store.begin_run(host_with(4), "quick"), cell_of(0, 5));
    return raise(SIGKILL);
  });
  ASSERT_EQ(status, 127);  // ended by a signal
  const std::string log = bytes(file.string() + "-wal");
  ASSERT_FALSE(log.empty());
  for (std::size_t round = 1; round <= 3; ++round) {
    fs::resize_file(file, 50);
    const Store store(file, Access::write);
    ASSERT_EQ(store.messages().size(), 1u);
    EXPECT_TRUE(store.samples().empty());
    EXPECT_EQ(files_beside(file, ".corrupt-").size(), round);
  }
  std::size_t logs = 0;
  for (const fs::path& aside : files_beside(file, ".corrupt-")) logs += bytes(aside.string() + "-wal") == log ? 1 : 0;
  EXPECT_EQ(logs, 1u);
}

TEST(Faults, OneOfSeveralTunersPutsAFileAside) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 50);
  change(file, "UPDATE sample SET seconds = seconds * 2 WHERE id = 7");
  std::vector<pid_t> tuners;
  for (int tuner = 0; tuner < 4; ++tuner) {
    tuners.push_back(fork());
    if (tuners.back() != 0) continue;
    alarm(60);
    try {
      Store store(file, Access::write);
      store.add(store.begin_run(host_with(4), "quick"), cell_of(0, 5));
      _exit(static_cast<int>(store.messages().size()));
    } catch (const std::exception& error) {
      fprintf(stderr, "%s\n", error.what());
      _exit(100);
    }
  }
  int notes = 0;
  for (const pid_t tuner : tuners) {
    int status = -1;
    waitpid(tuner, &status, 0);
    EXPECT_TRUE(WIFEXITED(status));
    notes += WEXITSTATUS(status);
  }
  EXPECT_EQ(notes, 1);
  EXPECT_EQ(files_beside(file, ".corrupt-").size(), 1u);
  EXPECT_EQ(Store(file, Access::read).samples().size(), 20u);
}

// Puts a sample into a database as it is, with a checksum that fits. slowness: time of the fixed work, s; NaN: unknown.
void put_unchecked(const fs::path& file, const Sample& sample) {
  SQLite::Database database(file.string(), SQLite::OPEN_READWRITE);
  const db::Tables tables = db::read_tables(database);
  const auto& [id, run] = *tables.runs.begin();
  db::Writer(database).sample(sample, tables.libraries.begin()->second.value, id, run.value.run.uid,
                              run.value.run.machine);
}

// A later assur with the same schema may know more kernels.
TEST(Faults, SamplesOfALaterKernelAreLeftOut) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 20);
  Sample later = sample_of(30);
  later.strategy.solver.backend = "quantum+leaps";
  put_unchecked(file, later);
  EXPECT_EQ(model_of(file).model->samples(), 20u);
  EXPECT_TRUE(model_of(file).messages.empty());
  const Store store(file, Access::write);
  EXPECT_TRUE(store.messages().empty());
  EXPECT_EQ(store.counts().samples, 20);
  EXPECT_EQ(store.counts().unknown, 1);
}

// A checksum tells nothing if another program computed it, or one with a fault.
TEST(Faults, ImpossibleSamplesDamageTheFileWhateverTheirChecksum) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
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
    const fs::path copy = lone_copy(file);
    Sample bad = sample_of(30);
    bad.slowness = 1e-6;
    changes[i](bad);
    put_unchecked(copy, bad);
    expect_put_aside(copy, Trouble::damaged);
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

// Random faults cause no crash and no wrong row. A file is used with all of its samples, or put aside.
TEST(Faults, SurvivesRandomFaults) {
  FileTree tree;
  const auto good = tree.root() / "good.db";
  const auto originals = by_uid(make_database(good, host_with(4), 300));
  const std::string whole = bytes(good);
  std::mt19937_64 random(20261121);
  const auto below = [&](std::size_t bound) { return static_cast<std::size_t>(random() % bound); };
  const auto expect_all = [&](const std::vector<Sample>& samples) {
    ASSERT_EQ(samples.size(), originals.size());
    for (const Sample& sample : samples) {
      const auto original = originals.find(sample.uid);
      ASSERT_NE(original, originals.end());
      ASSERT_TRUE(same(sample, original->second));
    }
  };
  const int rounds = test::random_count(100);
  int put_aside = 0, refused = 0, unharmed = 0;
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

    // The runtime and readers report errors, but write nothing.
    MachineModel model;
    ASSERT_NO_THROW(model = model_of(file));
    EXPECT_EQ(model.model->samples(), model.messages.empty() ? originals.size() : 0);
    const auto why_not = trouble(file, Access::read);
    if (!why_not) {
      EXPECT_TRUE(model.messages.empty());
      expect_all(Store(file, Access::read).samples());
    }
    EXPECT_TRUE(bytes(file) == damaged);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);

    // The tuner continues with the whole file, or with a new one.
    try {
      Store store(file, Access::write);
      const auto aside = files_beside(file, ".corrupt-"), old = files_beside(file, ".old-");
      EXPECT_EQ(aside.size() + old.size(), store.messages().size());
      if (store.messages().empty() && !damaged.empty()) {
        EXPECT_EQ(why_not, std::nullopt);
        expect_all(store.samples());
        ++unharmed;
      } else {
        EXPECT_NE(why_not, std::nullopt);
        EXPECT_TRUE(store.samples().empty());
        ++put_aside;
      }
      if (!aside.empty()) {
        EXPECT_TRUE(bytes(aside[0]) == damaged);
      }
      const std::size_t kept = store.samples().size();
      store.add(store.begin_run(host_with(4), "quick"), cell_of(1000, 2));
      EXPECT_EQ(store.samples().size(), kept + 2);
    } catch (const db::Unusable& unusable) {
      EXPECT_TRUE(unusable.trouble() == Trouble::foreign || unusable.trouble() == Trouble::newer) << unusable.what();
      EXPECT_TRUE(bytes(file) == damaged);
      ++refused;
    }
  }
  RecordProperty("put_aside", put_aside);
  RecordProperty("refused", refused);
  RecordProperty("unharmed", unharmed);
  EXPECT_GT(put_aside, rounds / 2);
  EXPECT_LE(refused, rounds / 20);
}

}  // namespace
}  // namespace assur::test
