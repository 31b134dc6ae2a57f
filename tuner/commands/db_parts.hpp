// What the questions to the tuning database have in common.
#pragma once

#include <filesystem>

#include "commands/commands.hpp"
#include "db/places.hpp"
#include "db/store.hpp"

namespace assur::command {

// Those that are asked, in order: --db alone, else all.
[[nodiscard]] std::vector<db::DatabaseFile> databases_of(const Common& common);

// Where samples are stored: --db, else the user's. Throws Error (environment) if there is no such place.
[[nodiscard]] std::filesystem::path own_database_of(const Common& common);

int db_info(const Common& common);

}  // namespace assur::command
