// Reads lines of comma-separated values, for tables and variants.
#pragma once

#include <string_view>
#include <vector>

namespace assur {

// The text without spaces, tabs and carriage returns at both ends.
[[nodiscard]] std::string_view trimmed(std::string_view text);

// Removes the first line, with its end of line, from `text` and returns it.
[[nodiscard]] std::string_view take_line(std::string_view& text);

// The fields between the commas, trimmed; a line without a comma is one field.
[[nodiscard]] std::vector<std::string_view> fields_of(std::string_view line);

// The number, or NaN if the text is not one finite number. The decimal sign is a point in every locale.
[[nodiscard]] double parse_number(std::string_view text);

}  // namespace assur
