#include "db/aside.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "db/database_files.hpp"
#include "db/reader.hpp"
#include "db/time.hpp"

namespace assur::db {
namespace {

namespace fs = std::filesystem;

// Held while a file is put aside, so that a second process does not put the new file aside.
class Lock {
 public:
  explicit Lock(const fs::path& file) {
    descriptor_ = ::open((file.string() + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (descriptor_ < 0 || flock(descriptor_, LOCK_EX) != 0) {
      throw Unusable(Trouble::blocked, file, "cannot be put aside, because its folder cannot be written");
    }
  }
  ~Lock() { ::close(descriptor_); }  // the lock file stays, because waiting processes hold it open
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;

 private:
  int descriptor_ = -1;
};

// Checks the file before it is opened for writing, so that a damaged one is renamed as it is, and while no other
// process writes logs beside it. A file that is read without locks may look damaged while another process writes.
SQLite::Database check_and_open(const fs::path& file) {
  try {
    (void)open_to_read_checked(file, false);
  } catch (const Unusable& unusable) {  // opening for writing makes an absent file, and undoes what was cut off
    if (unusable.trouble() != Trouble::absent && unusable.trouble() != Trouble::blocked) throw;
  }
  return guarded(file, [&] {
    SQLite::Database database = open_to_write(file, is_on_network(file));
    check_all(database);
    return database;
  });
}

// Returns the new name.
fs::path put_aside(const fs::path& file, Trouble trouble) {
  const std::string name =
      file.string() + (trouble == Trouble::older ? ".old-" : ".corrupt-") + utc_now("%Y%m%dT%H%M%SZ");
  fs::path aside = name;
  for (int number = 2; fs::exists(aside); ++number) aside = name + "-" + std::to_string(number);
  // The log holds content that is not yet in the file, so it is renamed as well.
  for (const char* suffix : {"-wal", "-shm", "-journal"}) {
    std::error_code none;
    fs::rename(file.string() + suffix, aside.string() + suffix, none);
  }
  std::error_code error;
  fs::rename(file, aside, error);
  if (error) throw Unusable(Trouble::blocked, file, "cannot be put aside: " + error.message());
  return aside;
}

}  // namespace

SQLite::Database open_to_read_checked(const fs::path& file, bool without_locks) {
  return guarded(file, [&] {
    SQLite::Database database = open_to_read(file, without_locks);
    check_all(database);
    return database;
  });
}

SQLite::Database open_or_put_aside(const fs::path& file, std::vector<std::string>& messages) {
  try {
    return check_and_open(file);
  } catch (const Unusable& unusable) {
    if (!goes_aside(unusable.trouble())) throw;
  }
  const Lock lock(file);
  try {
    return check_and_open(file);  // another process was faster
  } catch (const Unusable& unusable) {
    if (!goes_aside(unusable.trouble())) throw;
    const fs::path aside = put_aside(file, unusable.trouble());
    messages.push_back(unusable.problem() + ". It was renamed to " + aside.string() +
                       ", and a new file was begun; tune again");
  }
  return open_to_write(file, is_on_network(file));
}

}  // namespace assur::db
