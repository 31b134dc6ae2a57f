#include "db/store.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <set>

#include "db/connection.hpp"
#include "db/samples.hpp"
#include "parallel/file_tree.hpp"
#include "parallel/in_a_child.hpp"

namespace assur::test {
namespace {

using db::Access;
using db::Store;

TEST(Store, ReturnsSamplesBitwise) {
  FileTree tree;
  const auto file = tree.root() / "folder/made/for it.db";
  std::vector<Sample> given = cell_of(0, 5);
  given[1].kernel = Kernel::step;
  given[1].strategy = parse_strategy("irreducible/lanes:8+float+refine+once+predict=hermite:5+chunks=3 3x2");
  given[1].shape = {
      123, 456, 78, 9, 1'000'000'000'000, 2'000'000'000'000, 3'000'000'000'000, 4'000'000'000'000, ~std::uint64_t{0}};
  given[4].kernel = Kernel::pack;
  given[4].strategy = parse_strategy("irreducible/lanes:16+together");
  given[2].spread = -0.0;
  given[2].backward_error = 0;
  given[2].forward_error = 5e-324;
  given[3].seconds = 0.1 + 0.2;  // with all of its digits
  {
    Store store(file, Access::write);
    EXPECT_TRUE(store.messages().empty());
    const std::int64_t run = store.begin_run(host_with(4), "quick");
    store.add(run, given);
    EXPECT_EQ(store.samples().size(), given.size());
  }
  const Store store(file, Access::read);
  const auto found = store.samples();
  ASSERT_EQ(found.size(), given.size());
  for (std::size_t i = 0; i < given.size(); ++i) EXPECT_TRUE(same(found[i], given[i])) << i;
  const db::Counts counts = store.counts(host_with(4).fingerprint());
  EXPECT_EQ(counts.samples, 5);
  EXPECT_EQ(counts.unknown + counts.stale, 0);
}

TEST(Store, RecordsTheRunAndItsEnd) {
  FileTree tree;
  Store store(tree.root() / "tuning.db", Access::write);
  const std::int64_t run = store.begin_run(host_with(4, 2.5), "patient");
  store.add(run, cell_of(0, 3));
  db::Run noted = store.runs().at(0);
  EXPECT_EQ(noted.id, run);
  EXPECT_EQ(noted.uid.size(), 32u);
  EXPECT_EQ(noted.machine, host_with(4, 2.5).fingerprint());
  EXPECT_EQ(noted.profile, "patient");
  EXPECT_EQ(noted.threads, 3);
  EXPECT_EQ(noted.samples, 3);
  EXPECT_FALSE(noted.finished);
  store.finish_run(run, {db::Grade::noisy, 12.5, 0.75, "stopped by hand"});
  noted = store.runs().at(0);
  EXPECT_TRUE(noted.finished);
  EXPECT_EQ(noted.grade, "noisy");
  EXPECT_EQ(noted.seconds, 12.5);
  EXPECT_EQ(noted.coverage, 0.75);
  EXPECT_EQ(noted.note, "stopped by hand");
  EXPECT_THROW(store.finish_run(run + 1, {}), Error);
}

// Raw times and the slowness of the machine are stored; reading converts them to the usual pace.
TEST(Store, GivesTimesAtTheUsualPaceOfAllSamples) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const auto put = [&](std::vector<Sample> samples, double slowness, double pace) {
    for (Sample& s : samples) s.slowness = slowness;
    Store store(file, Access::write);
    const std::int64_t run = store.begin_run(host_with(4), "quick");
    store.add(run, samples, pace);
    store.finish_run(run, {});
  };
  std::vector<Sample> usual = cell_of(0, 8);
  const std::vector<Sample> hurried = {sample_of(20)}, old = {sample_of(21)};
  usual[0].kernel = Kernel::meeting;
  usual[0].strategy = parse_strategy("irreducible/lanes 2x1");
  usual[1].strategy = parse_strategy("irreducible/lapack 1x2");
  usual[2].strategy = parse_strategy("irreducible/cusolver");
  usual[3].strategy = parse_strategy("irreducible/magma");
  // 1.6 times 2 us is the usual pace of the fixed work. This run took the machine for faster than it is.
  put(usual, 1.6, 2e-6);
  put(hurried, 0.5, 2e-6);
  put(old, 1, kNan);
  const auto found = by_uid(Store(file, Access::read).samples());
  ASSERT_EQ(found.size(), 10u);
  for (std::size_t i = 0; i < usual.size(); ++i) {
    const Sample& s = usual[i];
    const double times = i < 4 ? 1 : 1.6;  // the pace of one core does not change those of several threads and of GPUs
    EXPECT_DOUBLE_EQ(found.at(s.uid).seconds, times * s.seconds) << i;
    EXPECT_DOUBLE_EQ(found.at(s.uid).spread, times * s.spread) << i;
    EXPECT_DOUBLE_EQ(found.at(s.uid).slowness, 1) << i;
  }
  EXPECT_DOUBLE_EQ(found.at(hurried[0].uid).seconds, 1.6 * hurried[0].seconds);
  EXPECT_DOUBLE_EQ(found.at(hurried[0].uid).slowness, 1 / 3.2);
  EXPECT_TRUE(same(found.at(old[0].uid), old[0]));

  SQLite::Database database(file.string());
  SQLite::Statement stored(database, "SELECT seconds, slowness FROM sample ORDER BY id");
  ASSERT_TRUE(stored.executeStep());
  EXPECT_DOUBLE_EQ(stored.getColumn(0).getDouble(), usual[0].seconds);
  EXPECT_DOUBLE_EQ(stored.getColumn(1).getDouble(), 3.2e-6);
  SQLite::Statement view(database, "SELECT m.seconds, s.uid FROM measured m JOIN sample s ON s.id = m.sample");
  int rows = 0;
  for (; view.executeStep(); ++rows) {
    EXPECT_NEAR(view.getColumn(0).getDouble() / found.at(view.getColumn(1).getString()).seconds, 1, 1e-14);
  }
  EXPECT_EQ(rows, 10);
  // Rows for people have raw times and slowness; samples of old databases have no slowness.
  const db::Answer answer = Store(file, Access::read).sample_rows();
  const auto column = [&](const char* name) {
    return std::find(answer.columns.begin(), answer.columns.end(), name) - answer.columns.begin();
  };
  const auto raw = static_cast<std::size_t>(column("raw_seconds")), slow = static_cast<std::size_t>(column("slowness"));
  ASSERT_EQ(answer.rows.size(), 10u);
  EXPECT_DOUBLE_EQ(std::get<double>(answer.rows[8][raw]), hurried[0].seconds / 2);
  EXPECT_DOUBLE_EQ(std::get<double>(answer.rows[8][slow]), 1 / 3.2);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(answer.rows[9][raw]));
  EXPECT_TRUE(std::holds_alternative<std::monostate>(answer.rows[9][slow]));
  // An export keeps the raw times bitwise.
  (void)Store(file, Access::read).export_to(tree.root() / "export.db");
  const std::string of_file = "SELECT uid, seconds, spread, slowness FROM ";
  database.exec("ATTACH '" + (tree.root() / "export.db").string() + "' AS export");
  EXPECT_EQ(database.execAndGet("SELECT count(*) FROM export.sample").getInt(), 10);
  EXPECT_EQ(
      database.execAndGet("SELECT count(*) FROM (" + of_file + "sample EXCEPT " + of_file + "export.sample)").getInt(),
      0);
}

// The fixed work may differ between versions.
TEST(Store, EveryVersionHasItsOwnPace) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const std::vector<Sample> before = cell_of(0, 5), now = cell_of(1, 3);
  {
    Store store(file, Access::write);
    store.add(store.begin_run(host_with(4), "quick"), before, 9e-6);
    store.add(store.begin_run(host_with(4), "quick"), now, 3e-6);
  }
  SQLite::Database(file.string(), SQLite::OPEN_READWRITE).exec("UPDATE tuning_run SET assur = 'older' WHERE id = 1");
  const auto found = by_uid(Store(file, Access::read).samples());
  for (const Sample& s : before) EXPECT_DOUBLE_EQ(found.at(s.uid).seconds, s.seconds);
  for (const Sample& s : now) EXPECT_DOUBLE_EQ(found.at(s.uid).seconds, s.seconds);
  EXPECT_EQ(Store(file, Access::read).usual_pace(host_with(4)), 3e-6);
  EXPECT_EQ(Store(file, Access::read).usual_pace(host_with(2)), std::nullopt);
}

TEST(Store, AddsACellAsAWhole) {
  FileTree tree;
  Store store(tree.root() / "tuning.db", Access::write);
  const std::int64_t run = store.begin_run(host_with(4), "quick");
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL, 9e-316, 1e300}) {
    auto cell = cell_of(0, 3);
    cell[2].seconds = bad;
    EXPECT_THROW(store.add(run, cell), Error) << bad;
    if (!std::isnan(bad)) {
      EXPECT_THROW(store.add(run, cell_of(0, 3), bad), Error) << bad;
    }
  }
  auto cell = cell_of(0, 3);
  cell[1].uid = "not a uid";
  EXPECT_THROW(store.add(run, cell), Error);
  EXPECT_THROW(store.add(run + 1, cell_of(0, 3)), Error);
  EXPECT_TRUE(store.samples().empty());
}

TEST(Store, TheSameUidIsTheSameSample) {
  FileTree tree;
  Store store(tree.root() / "tuning.db", Access::write);
  const std::int64_t run = store.begin_run(host_with(4), "quick");
  std::vector<Sample> cell = cell_of(0, 2);
  store.add(run, cell);
  cell[0].seconds *= 2;
  store.add(run, cell);
  ASSERT_EQ(store.samples().size(), 2u);
  EXPECT_EQ(store.samples()[0].seconds, cell[0].seconds / 2);
  cell[0].uid = cell[1].uid = "";  // add() draws them
  store.add(run, cell);
  std::set<std::string> uids;
  for (const Sample& sample : store.samples()) uids.insert(sample.uid);
  EXPECT_EQ(uids.size(), 4u);
}

TEST(Store, ContinuesAnUnfinishedRun) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  const auto cell = cell_of(0, 2);
  std::int64_t run = 0;
  {
    Store store(file, Access::write);
    run = store.begin_run(host_with(4), "quick");
    store.add(run, cell);
  }
  Store store(file, Access::write);
  EXPECT_EQ(store.unfinished_run(host_with(4), "patient"), std::nullopt);
  EXPECT_EQ(store.unfinished_run(host_with(2), "quick"), std::nullopt);
  EXPECT_EQ(store.unfinished_run(host_with(4), "quick"), run);
  store.finish_run(run, {});
  EXPECT_EQ(store.unfinished_run(host_with(4), "quick"), std::nullopt);
}

TEST(Store, DoesNotContinueARunOfAnotherProcess) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  std::array<int, 2> started{}, go{};
  ASSERT_EQ(pipe(started.data()), 0);
  ASSERT_EQ(pipe(go.data()), 0);
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    char byte = 0;
    Store store(file, Access::write);
    (void)store.begin_run(host_with(4), "quick");
    if (write(started[1], "s", 1) != 1 || read(go[0], &byte, 1) != 1) _exit(1);
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(started[0], &byte, 1), 1);
  Store store(file, Access::write);
  EXPECT_EQ(store.unfinished_run(host_with(4), "quick"), std::nullopt);
  ASSERT_EQ(write(go[1], "g", 1), 1);
  waitpid(child, nullptr, 0);
  EXPECT_NE(store.unfinished_run(host_with(4), "quick"), std::nullopt);
}

TEST(Store, KeepsModelsByMachineAndName) {
  FileTree tree;
  Store store(tree.root() / "tuning.db", Access::write);
  store.put_model(host_with(4), "kernels", "{\"a\": 1}");
  store.put_model(host_with(4), "kernels", "{\"a\": 2}");
  store.put_model(host_with(2), "kernels", "{}");
  EXPECT_EQ(store.model(host_with(4), "kernels"), "{\"a\": 2}");
  EXPECT_EQ(store.model(host_with(2), "kernels"), "{}");
  EXPECT_EQ(store.model(host_with(4), "others"), std::nullopt);
  EXPECT_EQ(store.models().rows.size(), 2u);
}

TEST(Store, FiltersByRunMachineLibraryAndKernel) {
  FileTree tree;
  Store store(tree.root() / "tuning.db", Access::write);
  const std::int64_t first = store.begin_run(host_with(4), "quick"), second = store.begin_run(host_with(2), "quick");
  store.add(first, std::vector{sample_of(0, "eigen"), sample_of(1, "klu"), sample_of(2, "klu", Kernel::evaluate)});
  store.add(second, std::vector{sample_of(0, "klu", Kernel::solve)});
  EXPECT_EQ(store.samples({.run = first}).size(), 3u);
  EXPECT_EQ(store.samples({.machine = host_with(2).fingerprint()}).size(), 1u);
  EXPECT_EQ(store.samples({.machine = host_with(2).fingerprint().substr(0, 8)}).size(), 1u);
  EXPECT_EQ(store.samples({.library = "klu"}).size(), 2u);
  EXPECT_EQ(store.samples({.library = "assur"}).size(), 1u);  // samples of equations have no solver
  EXPECT_EQ(store.samples({.kernel = Kernel::solve}).size(), 1u);
  EXPECT_EQ(store.samples({.run = first, .library = "klu"}).size(), 1u);
  EXPECT_EQ(store.sample_rows({.library = "klu"}).rows.size(), 2u);
}

TEST(Store, ForgetsMatchingSamplesAndUnusedRows) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  {
    Store store(file, Access::write);
    const std::int64_t first = store.begin_run(host_with(4), "quick"), second = store.begin_run(host_with(2), "quick");
    store.add(first, std::vector{sample_of(0, "eigen"), sample_of(1, "klu")});
    store.add(second, std::vector{sample_of(2, "klu")});
    store.finish_run(first, {});
    store.finish_run(second, {});
    store.put_model(host_with(2), "kernels", "{}");
    EXPECT_THROW(store.forget({}), Error);
    const db::Forgotten klu = store.forget({.library = "klu"});
    EXPECT_EQ(klu.samples, 2);
    EXPECT_EQ(klu.runs, 1);
    EXPECT_EQ(store.samples().size(), 1u);
    EXPECT_EQ(store.model(host_with(2), "kernels"), std::nullopt);
    EXPECT_EQ(store.forget({.machine = "nobody"}).samples, 0);
  }
  SQLite::Database database(file.string());
  for (const char* table : {"library", "shape", "strategy", "machine", "tuning_run"}) {
    EXPECT_EQ(database.execAndGet(std::string("SELECT count(*) FROM ") + table).getInt(), 1) << table;
  }
  Store store(file, Access::write);
  EXPECT_EQ(store.forget_all().samples, 1);
  EXPECT_TRUE(store.runs().empty());
}

TEST(Store, ExportsAndMergesByUid) {
  FileTree tree;
  const auto ours = tree.root() / "ours.db", theirs = tree.root() / "theirs.db", file = tree.root() / "export.db";
  const auto here = make_database(ours, host_with(4), 10), there = make_database(theirs, host_with(2), 5);
  EXPECT_EQ(Store(ours, Access::read).export_to(file), 10);
  EXPECT_THROW((void)Store(ours, Access::read).export_to(file), Error);
  EXPECT_FALSE(std::filesystem::exists(file.string() + ".part"));
  EXPECT_EQ(bytes(file)[18], 1);  // no log, so that the file can be read in a read-only folder
  EXPECT_EQ(by_uid(Store(file, Access::read).samples()).size(), 10u);

  Store merged(theirs, Access::write);
  db::Imported imported = merged.import_from(file);
  EXPECT_EQ(imported.samples, 10);
  EXPECT_EQ(imported.known, 0);
  imported = merged.import_from(file);
  EXPECT_EQ(imported.samples, 0);
  EXPECT_EQ(imported.known, 10);
  EXPECT_EQ(merged.runs().size(), 2u);
  const auto all = by_uid(merged.samples());
  ASSERT_EQ(all.size(), 15u);
  for (const Sample& sample : here) EXPECT_TRUE(same(all.at(sample.uid), sample));
  for (const Sample& sample : there) EXPECT_TRUE(same(all.at(sample.uid), sample));
  EXPECT_EQ(merged.samples({.machine = host_with(4).fingerprint()}).size(), 10u);
  EXPECT_EQ(merged.export_to(tree.root() / "part.db", {.machine = host_with(2).fingerprint()}), 5);
  EXPECT_THROW((void)merged.import_from(tree.root() / "nothing.db"), Error);
}

// Times count for one instance: a call with 8 lanes counts an eighth. At n = 4 klu is best, at n = 8 lanes:8 is best,
// although its call takes longer.
TEST(Store, ViewsShowTheBestOfEachShapeAndCrossovers) {
  FileTree tree;
  Store store(tree.root() / "tuning.db", Access::write);
  const std::int64_t run = store.begin_run(host_with(4), "quick");
  const auto put = [&](std::int32_t n, Kernel kernel, const std::string& strategy, double seconds, double error) {
    Sample s;
    s.kernel = kernel;
    s.shape = {n, 2 * n, 1, 1, 0, 0, 0, 0};
    s.strategy = parse_strategy(strategy);
    s.seconds = seconds;
    s.backward_error = error;
    store.add(run, std::vector{s});
  };
  for (const Kernel kernel : {Kernel::factor, Kernel::solve}) {
    put(4, kernel, "groups/klu", 9e-6, 1e-12);  // replaced by the next measurement
    put(4, kernel, "groups/klu", 1e-6, 1e-16);
    put(4, kernel, "groups/lanes:8", 16e-6, 1e-15);
    put(8, kernel, "groups/klu", 4e-6, 1e-16);
    put(8, kernel, "groups/lanes:8", 8e-6, 1e-15);
  }
  const db::Answer best = store.best({.kernel = Kernel::factor});
  const std::vector<std::string> columns = {"machine",  "kernel",  "n",         "nnz",
                                            "fill",     "groups",  "rhs",       "pattern",
                                            "strategy", "seconds", "runner_up", "runner_up_takes"};
  EXPECT_EQ(best.columns, columns);
  ASSERT_EQ(best.rows.size(), 2u);
  EXPECT_EQ(std::get<std::string>(best.rows[0][8]), "groups/klu");
  EXPECT_EQ(std::get<double>(best.rows[0][9]), 1e-6);
  EXPECT_EQ(std::get<std::string>(best.rows[0][10]), "groups/lanes:8");
  EXPECT_NEAR(std::get<double>(best.rows[0][11]), 2, 1e-15);
  EXPECT_EQ(std::get<std::string>(best.rows[1][8]), "groups/lanes:8");
  EXPECT_EQ(std::get<double>(best.rows[1][9]), 1e-6);

  // Two sizes of factor, solve, and a factorisation with three solutions.
  EXPECT_EQ(store.best().rows.size(), 6u);
  const db::Answer crossovers = store.crossovers();
  ASSERT_EQ(crossovers.rows.size(), 3u);
  EXPECT_EQ(crossovers.columns, (std::vector<std::string>{"machine", "kernel", "dense", "groups", "rhs", "n_before",
                                                          "strategy_before", "n", "strategy"}));
  for (const auto& row : crossovers.rows) {
    EXPECT_EQ(std::get<std::int64_t>(row[5]), 4);
    EXPECT_EQ(std::get<std::string>(row[6]), "groups/klu");
    EXPECT_EQ(std::get<std::int64_t>(row[7]), 8);
    EXPECT_EQ(std::get<std::string>(row[8]), "groups/lanes:8");
  }

  SQLite::Database database((tree.root() / "tuning.db").string());
  SQLite::Statement front(database,
                          "SELECT n, strategy, on_front FROM error_against_time WHERE kernel = 'factor+3solve' "
                          "ORDER BY n, seconds");
  const auto next = [&] {
    EXPECT_TRUE(front.executeStep());
    return front.getColumn(1).getString() + (front.getColumn(2).getInt() ? " on front" : "");
  };
  EXPECT_EQ(next(), "groups/klu on front");  // faster and more exact
  EXPECT_EQ(next(), "groups/lanes:8");
  EXPECT_EQ(next(), "groups/lanes:8 on front");  // faster
  EXPECT_EQ(next(), "groups/klu on front");      // more exact
}

TEST(Store, SupportsConcurrentTunersAndReaders) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  constexpr int kTuners = 3, kCells = 40, kCell = 5;
  std::vector<pid_t> tuners;
  for (int tuner = 0; tuner < kTuners; ++tuner) {
    const pid_t child = fork();
    if (child == 0) {
      alarm(60);
      try {
        Store store(file, Access::write);  // all tuners at once; one of them creates the file
        const std::int64_t run = store.begin_run(host_with(4), "quick");
        for (int cell = 0; cell < kCells; ++cell) store.add(run, cell_of(cell, kCell));
        store.finish_run(run, {});
      } catch (const std::exception& error) {
        fprintf(stderr, "%s\n", error.what());
        _exit(1);
      }
      _exit(0);
    }
    tuners.push_back(child);
  }
  // A reader always sees whole cells, and never fewer than before.
  std::size_t seen = 0, looks = 0;
  int running = kTuners, status = 0;
  while (running > 0) {
    if (waitpid(-1, &status, WNOHANG) > 0) {
      --running;
      EXPECT_EQ(status, 0);
    }
    try {
      const std::size_t now = Store(file, Access::read).samples().size();
      EXPECT_EQ(now % kCell, 0u);
      EXPECT_GE(now, seen);
      seen = now;
      ++looks;
    } catch (const db::Unusable& unusable) {
      EXPECT_EQ(unusable.trouble(), db::Trouble::absent) << unusable.what();
    }
  }
  EXPECT_GT(looks, 0u);
  Store store(file, Access::write);
  EXPECT_TRUE(store.messages().empty());
  EXPECT_EQ(store.samples().size(), static_cast<std::size_t>(kTuners * kCells * kCell));
  EXPECT_EQ(store.runs().size(), static_cast<std::size_t>(kTuners));
}

// A tuner starts and ends repeatedly, which changes the journal mode. The file never appears damaged.
TEST(Store, ReadersWorkWhileATunerStartsAndEnds) {
  FileTree tree;
  const auto file = tree.root() / "tuning.db";
  make_database(file, host_with(4), 5);
  EXPECT_EQ(bytes(file)[18], 1);  // at rest without a log
  const pid_t child = fork();
  if (child == 0) {
    alarm(60);
    for (int cell = 1; cell <= 60; ++cell) {
      try {
        Store store(file, Access::write);
        if (!store.messages().empty()) _exit(1);
        store.add(store.begin_run(host_with(4), "quick"), cell_of(cell, 5));  // new shapes each time
      } catch (const std::exception& error) {
        fprintf(stderr, "%s\n", error.what());
        _exit(1);
      }
    }
    _exit(0);
  }
  int status = -1;
  for (std::int64_t seen = 5; waitpid(child, &status, WNOHANG) == 0;) {
    try {
      const Store store(file, Access::read);
      const db::Counts counts = store.counts();
      EXPECT_EQ(counts.samples % 5, 0);
      EXPECT_GE(counts.samples, seen);
      seen = counts.samples;
    } catch (const db::Unusable& unusable) {  // the tuner locked the file for longer than a reader waits
      EXPECT_EQ(unusable.trouble(), db::Trouble::blocked) << unusable.what();
    }
  }
  EXPECT_EQ(status, 0);
  EXPECT_EQ(Store(file, Access::read).samples().size(), 305u);
  { const Store next(file, Access::write); }  // removes the log that a reader may have kept in place
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(tree.root()), {}), 1);
}

}  // namespace
}  // namespace assur::test
