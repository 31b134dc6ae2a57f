#include "db/connection.hpp"

#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <new>
#include <thread>

#include "files/input_file.hpp"

namespace assur::db {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kPatience = 60s;        // while another process writes
constexpr auto kReadersPatience = 1s;  // used only without a write-ahead log

// Judges a file by its first 100 bytes (https://www.sqlite.org/fileformat.html, 1.3).
void refuse_unusable(const fs::path& file) {
  if (const std::string kind = why_not_regular(file); !kind.empty()) throw Unusable(Trouble::foreign, file, kind);
  std::array<char, 100> header{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream && errno != ENOENT && errno != ENOTDIR) {
    throw Unusable(Trouble::blocked, file, std::string("cannot be read: ") + std::strerror(errno));
  }
  stream.read(header.data(), header.size());
  const std::string_view bytes(header.data(), static_cast<std::size_t>(stream.gcount()));
  if (bytes.empty()) throw Unusable(Trouble::absent, file, "there is no tuning database yet; run `assur tune`");
  const std::string_view magic("SQLite format 3\0", 16), id("Assr");  // kApplicationId
  const bool is_sqlite = bytes.substr(0, 16) == magic.substr(0, bytes.size());
  const bool is_cut = bytes.size() < header.size(), is_ours = !is_cut && bytes.substr(68, 4) == id;
  if (is_sqlite && is_ours) return;
  if (is_ours || (is_sqlite && is_cut)) throw Unusable(Trouble::damaged, file, "its first bytes are damaged");
  throw Unusable(Trouble::foreign, file, "is not a tuning database of assur, and is left unchanged; name another file");
}

// Every path is given as a URI, because only a URI can declare a file immutable.
std::string uri(const fs::path& file, std::string_view query) {
  std::string text = "file:";
  for (const char c : fs::absolute(file).string()) {
    if (c == '%') {
      text += "%25";
    } else if (c == '?') {
      text += "%3f";
    } else if (c == '#') {
      text += "%23";
    } else {
      text += c;
    }
  }
  return text.append(query);
}

bool has_content(const fs::path& file, const char* suffix) {
  std::error_code none;
  const auto size = fs::file_size(file.string() + suffix, none);
  return !none && size > 0;
}

std::int32_t version_of(SQLite::Database& database) { return database.execAndGet("PRAGMA user_version").getInt(); }

void refuse_other_version(const fs::path& file, std::int32_t version) {
  const std::string differs = "its schema has version " + std::to_string(version) + ", but this assur uses version " +
                              std::to_string(kSchemaVersion);
  if (version > kSchemaVersion) {
    throw Unusable(Trouble::newer, file, differs + "; it is left unchanged; use a newer assur");
  }
  if (version < kSchemaVersion) throw Unusable(Trouble::older, file, differs);
}

// For files that may be damaged: checks sizes in them, and lets views and triggers call built-in functions only.
void distrust(SQLite::Database& database) { database.exec("PRAGMA cell_size_check = ON; PRAGMA trusted_schema = OFF"); }

// Tries again every few milliseconds. SQLite's own waits become too long to meet the moment when a tuner that starts or
// ends releases the file.
template <class Work>
auto while_busy(std::chrono::milliseconds patience, Work&& work) {
  for (const auto start = std::chrono::steady_clock::now();; std::this_thread::sleep_for(2ms)) {
    try {
      return work();
    } catch (const SQLite::Exception& error) {
      if (error.getErrorCode() != SQLITE_BUSY || std::chrono::steady_clock::now() - start > patience) throw;
    }
  }
}

SQLite::Database open_read_only(const fs::path& file, std::string_view query) {
  // Only one thread uses it, for a few milliseconds; no locks for each call save a quarter of the time.
  SQLite::Database database(uri(file, query), SQLite::OPEN_READONLY | SQLite::OPEN_URI | SQLite::OPEN_NOMUTEX);
  distrust(database);
  const std::int32_t version = version_of(database);  // the first access to the file
  database.setBusyTimeout(static_cast<int>(std::chrono::milliseconds(kReadersPatience).count()));
  refuse_other_version(file, version);
  return database;
}

// Changing the journal mode needs exclusive access, which the busy timeout does not fully cover.
void set_journal(SQLite::Database& database, const char* statement, std::chrono::milliseconds patience) {
  while_busy(patience, [&] { return database.exec(statement); });
}

// Root does not make a folder among those of a user, who could not write in it later (`sudo assur tune`).
void make_folder(const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  fs::path there = folder;
  struct stat found {};
  while (stat(there.c_str(), &found) != 0 && there.has_relative_path()) there = there.parent_path();
  if (there != folder && geteuid() == 0 && found.st_uid != 0) {
    throw Unusable(Trouble::blocked, file,
                   "its folder does not exist, and if root makes it, user " + std::to_string(found.st_uid) +
                       ", who owns " + there.string() + ", cannot write in it; run the command as this user");
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Unusable(Trouble::blocked, file, "its folder cannot be created: " + error.message());
}

// True if a folder without write permission prevents the log.
bool lacks_permission(const SQLite::Exception& error) {
  const int code = error.getErrorCode();
  return code == SQLITE_CANTOPEN || code == SQLITE_READONLY || code == SQLITE_PERM;
}

SQLite::Database try_without_writing(const fs::path& file, bool without_locks) {
  const bool journal = has_content(file, "-journal");
  try {
    return open_read_only(file, "?mode=ro");
  } catch (const SQLite::Exception& error) {
    if (!without_locks || !lacks_permission(error)) throw;
    if (!journal) return open_read_only(file, "?immutable=1");  // ignores the content of the log
    throw Unusable(Trouble::blocked, file,
                   std::string("a tuning run was cut off while it wrote (") + error.what() +
                       "); `assur db check` restores its content");
  }
}

// A new file gets its tables in one transaction, unless another process was faster.
void make_tables(SQLite::Database& database) {
  SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
  if (database.execAndGet("SELECT count(*) FROM sqlite_schema").getInt() == 0) {
    database.exec(std::string(kSchema));
    database.exec("PRAGMA application_id = " + std::to_string(kApplicationId));
    database.exec("PRAGMA user_version = " + std::to_string(kSchemaVersion));
  }
  transaction.commit();
}

}  // namespace

void rethrow(const fs::path& file, const SQLite::Exception& error) {
  const std::string what = error.what();
  switch (error.getErrorCode()) {
    case SQLITE_NOMEM:
      throw std::bad_alloc();
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Unusable(Trouble::blocked, file, "is locked by another process");
    case SQLITE_FULL:
      throw Unusable(Trouble::blocked, file, "no space is left to write it; the samples stored before are kept");
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
    case SQLITE_CANTOPEN:
    case SQLITE_IOERR:
      throw Unusable(Trouble::blocked, file, "cannot be read or written: " + what);
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
      throw Unusable(Trouble::damaged, file, "is damaged: " + what);
    default:  // missing tables or columns, a violated constraint, ...
      throw Unusable(Trouble::damaged, file, "has unexpected content: " + what);
  }
}

SQLite::Database open_to_read(const fs::path& file, bool without_locks) {
  refuse_unusable(file);
  return guarded(
      file, [&] { return while_busy(kReadersPatience, [&] { return try_without_writing(file, without_locks); }); });
}

SQLite::Database open_to_write(const fs::path& file, bool network) {
  make_folder(file);
  try {
    refuse_unusable(file);
  } catch (const Unusable& unusable) {
    if (unusable.trouble() != Trouble::absent) throw;
  }
  return guarded(file, [&] {
    SQLite::Database database(uri(file, ""), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE | SQLite::OPEN_URI);
    database.setBusyTimeout(static_cast<int>(std::chrono::milliseconds(kPatience).count()));
    distrust(database);
    database.exec("PRAGMA foreign_keys = ON");
    const std::int32_t version = version_of(database);
    if (version > kSchemaVersion) refuse_other_version(file, version);
    if (sqlite3_db_readonly(database.getHandle(), "main") == 1) {
      throw Unusable(Trouble::blocked, file, "cannot be written: the file or its folder is read-only");
    }
    if (version == 0) make_tables(database);
    refuse_other_version(file, version_of(database));
    // In both modes a killed process loses nothing that was committed.
    set_journal(database, network ? "PRAGMA journal_mode = DELETE" : "PRAGMA journal_mode = WAL", kPatience);
    database.exec(network ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL");
    return database;
  });
}

void leave(SQLite::Database& database) noexcept {
  try {
    database.setBusyTimeout(0);
    set_journal(database, "PRAGMA journal_mode = DELETE", kReadersPatience);
  } catch (const std::exception&) {  // then the log remains; the next process that writes removes it
  }
}

}  // namespace assur::db
