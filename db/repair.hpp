// Finds damage, and copies good rows to a new file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "db/connection.hpp"
#include "db/contents.hpp"

namespace assur::db {

// Damage to the structure of the file, as SQLite reports it; empty if there is none. Throws SQLite::Exception.
[[nodiscard]] std::vector<std::string> structural_damage(SQLite::Database& database);

// Opens a file for writing. A damaged file is renamed to FILE.corrupt-TIME, and its good rows are copied to a new one;
// `messages` then has a note. Throws Unusable.
[[nodiscard]] SQLite::Database open_whole(const std::filesystem::path& file, std::vector<std::string>& messages);

struct Copied {
  std::int64_t samples = 0, known = 0;  // new in the target, and already there
};

// Copies runs and samples, with all rows that they refer to, in one transaction. Rows whose uid exists already are not
// changed. If it throws SQLite::Exception, nothing has changed.
Copied copy(const Contents& contents, SQLite::Database& target);

}  // namespace assur::db
