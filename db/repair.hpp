// Damage: how it is found, and how good rows are brought into a new file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "db/connection.hpp"
#include "db/contents.hpp"

namespace assur::db {

// Of the file's structure, as SQLite tells it; empty if it is whole. Throws SQLite::Exception.
[[nodiscard]] std::vector<std::string> structural_damage(SQLite::Database& database);

// Opens to write. A damaged file is put aside as FILE.corrupt-TIME, where it stays, and its good rows go into a new
// one, which is said in `messages`. Throws Unusable.
[[nodiscard]] SQLite::Database open_whole(const std::filesystem::path& file, std::vector<std::string>& messages);

struct Copied {
  std::int64_t samples = 0, known = 0;  // new in the target, and already there
};

// Runs, and samples with all that they refer to, in one transaction; what is there already, by uid, stays. Throws
// SQLite::Exception, and then nothing has changed.
Copied copy(const Contents& contents, SQLite::Database& target);

}  // namespace assur::db
