// The time of a record as text.
#pragma once

#include <array>
#include <ctime>
#include <string>

namespace assur::db {

// UTC, "2026-11-21T18:04:05Z"; format: of strftime.
[[nodiscard]] inline std::string utc_now(const char* format = "%Y-%m-%dT%H:%M:%SZ") {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), format, &parts)};
}

}  // namespace assur::db
