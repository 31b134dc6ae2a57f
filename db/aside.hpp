// Opens files of which all is good. Nothing of another file is used: to tune again takes a minute.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "db/connection.hpp"

namespace assur::db {

// open_to_read(), with a check of all of the file.
[[nodiscard]] SQLite::Database open_to_read_checked(const std::filesystem::path& file, bool without_locks = true);

// Opens a file for writing and checks all of it. A damaged file is renamed to FILE.corrupt-TIME, one of an older schema
// to FILE.old-TIME, and a new one is made; `messages` then has a note. Throws Unusable.
[[nodiscard]] SQLite::Database open_or_put_aside(const std::filesystem::path& file, std::vector<std::string>& messages);

}  // namespace assur::db
