// The schema of tuning databases. Files of other versions are not read.
#pragma once

#include <cstdint>
#include <string_view>

namespace assur::db {

inline constexpr std::int32_t kApplicationId = 0x41737372;  // "Assr"; PRAGMA application_id
inline constexpr std::int32_t kSchemaVersion = 4;           // PRAGMA user_version

// db/schema.sql.
extern const std::string_view kSchema;

}  // namespace assur::db
