// Opens a database file, and tells what can be wrong with one apart.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "assur/status.hpp"
#include "db/schema.hpp"

namespace assur::db {

enum class Trouble : std::uint8_t {
  absent,   // no such file, or an empty one
  foreign,  // a file of something else: never touched
  newer,    // of a version to come: never touched
  older,    // of an older version: opening it to write brings it up to date
  damaged,  // was a tuning database
  blocked,  // locked, no space, no permission, ...: the file may be good
};

class Unusable : public Error {
 public:
  Unusable(Trouble trouble, const std::filesystem::path& file, const std::string& what)
      : Error(Kind::environment, file.string() + ": " + what), trouble_(trouble) {}
  [[nodiscard]] Trouble trouble() const noexcept { return trouble_; }

 private:
  Trouble trouble_;
};

// As an Unusable with words for people.
[[noreturn]] void rethrow(const std::filesystem::path& file, const SQLite::Exception& error);

template <class Work>
decltype(auto) guarded(const std::filesystem::path& file, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const SQLite::Exception& error) {
    rethrow(file, error);
  }
}

// Nothing is written, and where no process is at work on the file it is not locked either. Throws Unusable.
[[nodiscard]] SQLite::Database open_to_read(const std::filesystem::path& file);

// Folder and file are made if they are not there; an older schema is brought up to date. Not checked for damage.
// network: the file lies where processes of other computers may write it: then no write-ahead log, which needs shared
// memory. Throws Unusable.
[[nodiscard]] SQLite::Database open_to_write(const std::filesystem::path& file, bool network);

// From the version that the database has, in one transaction; a new file gets `schema`. Throws SQLite::Exception, and
// then nothing has changed.
void bring_up_to_date(SQLite::Database& database, std::string_view schema, std::span<const Migration> steps,
                      std::int32_t version);

}  // namespace assur::db
