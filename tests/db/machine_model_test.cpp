#include "db/machine_model.hpp"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include "db/samples.hpp"
#include "parallel/file_tree.hpp"

namespace assur::test {
namespace {

using db::DatabaseFile;
using Files = std::vector<DatabaseFile>;

MachineModel read(const Files& files, const db::Host& host, const db::LibraryAtHand& library = db::library_at_hand) {
  return db::read_machine_model(files, host, library);
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

class Databases : public testing::Test {
 protected:
  std::filesystem::path file(const std::string& name) const { return tree_.root() / name; }
  Files files(const std::vector<std::string>& names) const {
    Files found;
    for (const std::string& name : names) found.push_back({file(name), DatabaseFile::Role::user});
    return found;
  }
  FileTree tree_;
};

TEST_F(Databases, UsesSamplesOfThisMachineSilently) {
  make_database(file("a.db"), host_with(4), 12);
  const MachineModel model = read(files({"a.db"}), host_with(4));
  EXPECT_EQ(model.model->samples(), 12u);
  EXPECT_TRUE(model.messages.empty());
  EXPECT_TRUE(contains(model.model->source(), "this machine")) << model.model->source();
  EXPECT_TRUE(contains(model.model->source(), file("a.db").string()));
}

TEST_F(Databases, UsesSamplesOfTheSameProcessorWithANote) {
  make_database(file("a.db"), host_with(8), 5);
  make_database(file("a.db"), host_with(3), 7);
  make_database(file("b.db"), host_with(2), 9);
  const MachineModel model = read(files({"a.db", "b.db"}), host_with(2, 1));
  EXPECT_EQ(model.model->samples(), 7u);  // from the first file, the machine with the closest number of cores
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_TRUE(contains(model.messages[0], "3 cores")) << model.messages[0];
  EXPECT_TRUE(contains(model.messages[0], "same processor"));
  EXPECT_TRUE(contains(model.messages[0], "assur tune"));
  EXPECT_TRUE(contains(model.model->source(), "same processor"));
}

TEST_F(Databases, UsesSamplesOfTheSameMicroarchitectureLast) {
  db::Host sister = host_with(4);
  sister.machine.model = "Slow One";
  make_database(file("a.db"), sister, 5);
  MachineModel model = read(files({"a.db"}), host_with(4));
  EXPECT_EQ(model.model->samples(), 5u);
  EXPECT_TRUE(contains(model.model->source(), "same microarchitecture")) << model.model->source();
  EXPECT_TRUE(contains(model.model->source(), "Slow One"));
  EXPECT_EQ(model.messages.size(), 1u);
  // A host that is more similar comes first, even if its file comes later.
  make_database(file("b.db"), host_with(8), 6);
  EXPECT_EQ(read(files({"a.db", "b.db"}), host_with(4)).model->samples(), 6u);
  make_database(file("c.db"), host_with(4), 7);
  model = read(files({"a.db", "b.db", "c.db"}), host_with(4));
  EXPECT_EQ(model.model->samples(), 7u);
  EXPECT_TRUE(model.messages.empty());
}

TEST_F(Databases, IgnoresSamplesOfAnotherMachine) {
  db::Host other = host_with(4);
  other.model = 99;
  make_database(file("a.db"), other, 5);
  const MachineModel model = read(files({"a.db"}), host_with(4));
  EXPECT_EQ(model.model->samples(), 0u);
  EXPECT_EQ(model.model->source(), "");
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_TRUE(contains(model.messages[0], "not for this machine")) << model.messages[0];
  EXPECT_TRUE(contains(model.messages[0], "assur tune"));
}

TEST_F(Databases, CombinesSamplesOfOneMachine) {
  const auto users = make_database(file("user.db"), host_with(4), 4);
  const auto system = make_database(file("system.db"), host_with(4), 10);  // the same four cells and six more
  const MachineModel model = read(files({"user.db", "system.db"}), host_with(4));
  EXPECT_EQ(model.model->samples(), 14u);
  EXPECT_TRUE(contains(model.model->source(), file("user.db").string()));
  EXPECT_TRUE(contains(model.model->source(), file("system.db").string()));
}

TEST_F(Databases, CountsCopiesOnce) {
  make_database(file("user.db"), host_with(4), 4);
  db::Store system(file("system.db"), db::Access::write);
  (void)system.import_from(file("user.db"));
  EXPECT_EQ(read(files({"user.db", "system.db"}), host_with(4)).model->samples(), 4u);
}

// Only samples of the library that has changed are left out, with one message.
TEST_F(Databases, LeavesOutSamplesOfOtherLibraryVersions) {
  {
    db::Store store(file("a.db"), db::Access::write);
    const std::int64_t run = store.begin_run(host_with(4), "quick");
    std::vector<Sample> samples;
    for (int i = 0; i < 5; ++i) samples.push_back(sample_of(i, "eigen"));
    for (int i = 0; i < 7; ++i) samples.push_back(sample_of(i, "lanes"));
    for (int i = 0; i < 2; ++i) samples.push_back(sample_of(i, "lanes", Kernel::evaluate));
    store.add(run, samples);
  }
  const auto newer = [](std::string_view name) {
    db::Library library = db::library_at_hand(name);
    if (name == "lanes") library.version = "99";
    return library;
  };
  MachineModel model = read(files({"a.db"}), host_with(4), newer);
  EXPECT_EQ(model.model->samples(), 7u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_TRUE(contains(model.messages[0], "7 of 14 samples")) << model.messages[0];
  EXPECT_TRUE(contains(model.messages[0], "lanes was " + db::library_at_hand("lanes").version + ", is 99"));

  const auto rebuilt = [](std::string_view name) {
    db::Library library = db::library_at_hand(name);
    library.build = "another compiler";
    return library;
  };
  model = read(files({"a.db"}), host_with(4), rebuilt);
  EXPECT_EQ(model.model->samples(), 0u);
  EXPECT_EQ(model.messages.size(), 1u);
  EXPECT_TRUE(contains(model.messages[0], "14 of 14 samples"));

  const auto without = [](std::string_view name) { return db::Library{std::string(name), "", ""}; };
  model = read(files({"a.db"}), host_with(4), without);
  EXPECT_TRUE(contains(model.messages[0], "eigen is not available")) << model.messages[0];
}

TEST_F(Databases, AnUnreadableDatabaseDoesNotBlockTheOthers) {
  tree_.file("text.db", "not a database");
  make_database(file("good.db"), host_with(4), 6);
  const MachineModel model = read(files({"absent.db", "text.db", "good.db"}), host_with(4));
  EXPECT_EQ(model.model->samples(), 6u);
  ASSERT_EQ(model.messages.size(), 1u);
  EXPECT_TRUE(contains(model.messages[0], file("text.db").string()));
}

TEST_F(Databases, GiveNoSamplesIfThereAreNone) {
  const MachineModel model = read({}, host_with(4));
  ASSERT_NE(model.model, nullptr);
  EXPECT_EQ(model.model->samples(), 0u);
  EXPECT_TRUE(model.messages.empty());
}

// ctest sets an empty ASSUR_DB.
TEST(MachineModel, IsReadOnce) { EXPECT_EQ(&machine_model(), &machine_model()); }

TEST(Libraries, OwnCodeHasTheVersionOfAssur) {
  EXPECT_TRUE(contains(db::library_at_hand("eigen").version, "assur " + std::string(db::assur_version())));
  EXPECT_TRUE(contains(db::library_at_hand("assur").version, "assur " + std::string(db::assur_version())));
  EXPECT_FALSE(db::library_at_hand("eigen").build.empty());
  EXPECT_EQ(db::library_at_hand("no such backend").version, "");
}

}  // namespace
}  // namespace assur::test
