// Numbers and names as text for people.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace assur::output {

inline constexpr std::size_t kPageWidth = 80;  // columns

// 12,345
[[nodiscard]] std::string grouped(std::int64_t count);
[[nodiscard]] std::string grouped(std::integral auto count) { return grouped(static_cast<std::int64_t>(count)); }

// "1 group", "12,345 groups"
[[nodiscard]] std::string counted(std::int64_t count, std::string_view noun);
[[nodiscard]] std::string counted(std::integral auto count, std::string_view noun) {
  return counted(static_cast<std::int64_t>(count), noun);
}

// Three digits and a unit: "12.3 µs", "1.04 ms", "75.0 s".
[[nodiscard]] std::string duration(double seconds);

// Six digits: "10", "0.01", "1.5708".
[[nodiscard]] std::string number(double value);

// The lines of a text, joined by "; ".
[[nodiscard]] std::string one_line(std::string text);

// Two decimals: "1.00".
[[nodiscard]] std::string fixed(double value);

// Two digits with an exponent: "2.2e-16"; "0" for zero, "-" for NaN (unknown), "not finite" if infinite.
[[nodiscard]] std::string error_figure(double value);
[[nodiscard]] inline std::string error_figure(const std::optional<double>& value) {
  return value ? error_figure(*value) : "-";
}

// "a, b, c", or "a, b, c and 12 more" beyond `most`.
[[nodiscard]] std::string listed(const std::vector<std::string>& names, std::size_t most = 20);

// Width of a UTF-8 text on a terminal: its number of code points.
[[nodiscard]] std::size_t display_width(std::string_view text);

// The text, or its beginning with "..." if it is wider than `most` columns.
[[nodiscard]] std::string shortened(const std::string& text, std::size_t most);

// Breaks a text at spaces into lines of at most `width` columns; a longer word has its own line.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t width);

}  // namespace assur::output
