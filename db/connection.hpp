// Opens a database file.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <filesystem>
#include <span>
#include <string>
#include <utility>

#include "db/schema.hpp"
#include "db/unusable.hpp"

namespace assur::db {

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

// Nothing is written; an older schema is read as it is. Throws Unusable.
[[nodiscard]] SQLite::Database open_to_read(const std::filesystem::path& file);

// The same of a damaged file, whose end may be missing.
[[nodiscard]] SQLite::Database open_to_salvage(const std::filesystem::path& file);

// Folder and file are made if they are not there; an older schema is brought up to date. Not checked for damage.
// network: the file lies where processes of other computers may write it: then no write-ahead log, which needs shared
// memory. Throws Unusable.
[[nodiscard]] SQLite::Database open_to_write(const std::filesystem::path& file, bool network);

// After writing: without a log beside it the file can be read where nobody may write. Another process that is at work
// on it keeps the log, and leaves the file so itself.
void leave(SQLite::Database& database) noexcept;

// From the version that the database has, in one transaction; a new file gets `schema`. Throws SQLite::Exception, and
// then nothing has changed.
void bring_up_to_date(SQLite::Database& database, std::string_view schema, std::span<const Migration> steps,
                      std::int32_t version);

}  // namespace assur::db
