// Text in files of comma-separated values.
#pragma once

#include <string>
#include <string_view>

namespace assur::output {

// A cell: in quotes, and quotes within it doubled.
[[nodiscard]] inline std::string csv_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  return out + '"';
}

}  // namespace assur::output
