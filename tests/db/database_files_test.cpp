#include "db/database_files.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>

#include "parallel/file_tree.hpp"

namespace assur::test {
namespace {

// Sets an environment variable until the end of the scope.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    set(value);
  }
  ~Variable() { set(before_ ? before_->c_str() : nullptr); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  void set(const char* value) const {
    if (value) {
      setenv(name_, value, 1);
    } else {
      unsetenv(name_);
    }
  }

  const char* name_;
  std::optional<std::string> before_;
};

using Role = db::DatabaseFile::Role;

TEST(DatabaseFiles, NamedDatabaseComesBeforeTheUsers) {
  const Variable named("ASSUR_DB", "some.db"), data("XDG_DATA_HOME", "/data"), home("HOME", "/home/me");
  const auto files = db::database_files();
  ASSERT_GE(files.size(), 2u);
  EXPECT_EQ(files[0].file, "some.db");
  EXPECT_EQ(files[0].role, Role::named);
  EXPECT_EQ(files[1].file, "/data/assur/tuning.db");
  EXPECT_EQ(files[1].role, Role::user);
  EXPECT_EQ(db::own_database(), "some.db");
}

TEST(DatabaseFiles, UserDatabaseIsInTheDataFolder) {
  const Variable named("ASSUR_DB", nullptr), home("HOME", "/home/me");
  {
    const Variable data("XDG_DATA_HOME", nullptr);
    EXPECT_EQ(db::own_database(), "/home/me/.local/share/assur/tuning.db");
  }
  const Variable data("XDG_DATA_HOME", "not/absolute");
  EXPECT_EQ(db::own_database(), "/home/me/.local/share/assur/tuning.db");
  const Variable nobody("HOME", nullptr);
  EXPECT_EQ(db::own_database(), std::nullopt);
}

TEST(DatabaseFiles, AnEmptyVariableMeansNoDatabase) {
  const Variable named("ASSUR_DB", "");
  EXPECT_TRUE(db::database_files().empty());
  EXPECT_EQ(db::own_database(), std::nullopt);
}

TEST(DatabaseFiles, RecognisesNetworkFileSystems) {
  EXPECT_TRUE(db::is_network(0x6969));       // NFS
  EXPECT_TRUE(db::is_network(0xfe534d42));   // SMB 2
  EXPECT_FALSE(db::is_network(0xef53));      // ext4
  EXPECT_FALSE(db::is_network(0x01021994));  // tmpfs
  EXPECT_FALSE(db::is_on_network("/proc/not/there"));
}

}  // namespace
}  // namespace assur::test
