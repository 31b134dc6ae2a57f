// Common parts of queries to the tuning database.
#pragma once

#include <filesystem>

#include "commands/commands.hpp"
#include "db/database_files.hpp"
#include "db/store.hpp"

namespace assur::command {

// The databases to query, in order: --db alone, else all.
[[nodiscard]] std::vector<db::DatabaseFile> databases_of(const Common& common);

// The database that stores samples: --db, else that of the user. Throws Error (environment) if there is no such place.
[[nodiscard]] std::filesystem::path own_database_of(const Common& common);

int db_info(const Common& common);

}  // namespace assur::command
