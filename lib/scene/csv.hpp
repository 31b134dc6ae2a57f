// Lines of comma-separated values: what the readers of tables have in common.
#pragma once

#include <string_view>
#include <vector>

namespace assur {

// Without spaces, tabs and carriage returns at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

// The first line of `text`, which loses it and the end of line behind it.
[[nodiscard]] std::string_view take_line(std::string_view& text);

// The fields between the commas, trimmed; a line without a comma is one field.
[[nodiscard]] std::vector<std::string_view> fields_of(std::string_view line);

// NaN if the text is not one finite number; whatever the locale, the decimal sign is a point.
[[nodiscard]] double parse_number(std::string_view text);

}  // namespace assur
