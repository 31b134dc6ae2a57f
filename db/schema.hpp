// The schema of tuning databases, and migrations of older ones.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace assur::db {

inline constexpr std::int32_t kApplicationId = 0x41737372;  // "Assr"; PRAGMA application_id
inline constexpr std::int32_t kSchemaVersion = 3;           // PRAGMA user_version

// db/schema.sql.
extern const std::string_view kSchema;

// SQL that migrates from version `from` to the next one; all needed migrations run in one transaction.
struct Migration {
  std::int32_t from;
  std::string_view sql;
};

// db/migrations/*.sql, ascending; the last one leads to kSchemaVersion.
[[nodiscard]] std::span<const Migration> migrations();

}  // namespace assur::db
