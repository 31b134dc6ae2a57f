// The files of tuning databases.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace assur::db {

struct DatabaseFile {
  enum class Role : std::uint8_t { named, user, installation };  // named: given by ASSUR_DB or --db
  std::filesystem::path file;
  Role role = Role::named;
};

// The databases in the order of reading: the file named by ASSUR_DB, that of the user, that of the installation. The
// last one is listed only if it exists. No databases if ASSUR_DB is set and empty.
[[nodiscard]] std::vector<DatabaseFile> database_files();

// The database that stores new samples: ASSUR_DB, else $XDG_DATA_HOME/assur/tuning.db, else
// ~/.local/share/assur/tuning.db. Empty if ASSUR_DB is set and empty, or if the home of the user is unknown.
[[nodiscard]] std::optional<std::filesystem::path> own_database();

// True if the file system of a file (which need not exist) is shared by computers, so that processes may share no
// memory.
[[nodiscard]] bool is_on_network(const std::filesystem::path& file);
[[nodiscard]] bool is_network(std::uint64_t file_system);  // file_system: f_type of statfs(2)

}  // namespace assur::db
