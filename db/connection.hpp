// Opens database files.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <filesystem>
#include <string>
#include <utility>

#include "db/schema.hpp"
#include "db/unusable.hpp"

namespace assur::db {

// Throws the error of SQLite as an Unusable with a message for people.
[[noreturn]] void rethrow(const std::filesystem::path& file, const SQLite::Exception& error);

template <class Work>
decltype(auto) guarded(const std::filesystem::path& file, Work&& work) {
  try {
    return std::forward<Work>(work)();
  } catch (const SQLite::Exception& error) {
    rethrow(file, error);
  }
}

// Opens a file without writing. In a folder where no log can be opened, reads the file without locks, as if nobody
// wrote it; if that is not allowed, the file is blocked. Throws Unusable.
[[nodiscard]] SQLite::Database open_to_read(const std::filesystem::path& file, bool without_locks = true);

// Opens a file for writing, without a check for damage. Makes missing folders and files. network: other computers may
// write the file; it then has no write-ahead log, which needs shared memory. Throws Unusable.
[[nodiscard]] SQLite::Database open_to_write(const std::filesystem::path& file, bool network);

// Ends writing: removes the write-ahead log, so that the file can be read from read-only places. If another process
// uses the file, the log stays, and that process removes it.
void leave(SQLite::Database& database) noexcept;

}  // namespace assur::db
