// Where tuning databases lie.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace assur::db {

struct DatabaseFile {
  enum class Role : std::uint8_t { named, user, installation };  // named: by ASSUR_DB or --db
  std::filesystem::path file;
  Role role = Role::named;
};

// In the order in which they are asked: ASSUR_DB, the user's, that of the installation. Whether they exist is not
// looked at, but for the last. None at all where ASSUR_DB is set to nothing.
[[nodiscard]] std::vector<DatabaseFile> database_files();

// Where this user's samples are stored: ASSUR_DB, else $XDG_DATA_HOME/assur/tuning.db, else
// ~/.local/share/assur/tuning.db. Empty where ASSUR_DB is set to nothing, or nobody knows the user's home.
[[nodiscard]] std::optional<std::filesystem::path> own_database();

// Whether computers share the file system that a file is on, or will be: then no memory is shared beside it.
[[nodiscard]] bool is_on_network(const std::filesystem::path& file);
[[nodiscard]] bool is_network(std::uint64_t file_system);  // by its number, statfs(2)

}  // namespace assur::db
