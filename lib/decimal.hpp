// Numbers in messages and files: the same text whatever locale the program around the library has set.
#pragma once

#include <charconv>
#include <string>

namespace assur {

// As printf writes "%.3g" (general), "%.1f" (fixed) and "%.1e" (scientific) in the locale "C"; digits: 3 or 1 here.
[[nodiscard]] inline std::string decimal(double number, int digits, std::chars_format format) {
  char text[400];  // 309 digits before the point, 17 and more behind it
  return {text, std::to_chars(text, text + sizeof text, number, format, digits).ptr};
}
[[nodiscard]] inline std::string general(double number, int digits) {
  return decimal(number, digits, std::chars_format::general);
}
[[nodiscard]] inline std::string fixed(double number, int digits) {
  return decimal(number, digits, std::chars_format::fixed);
}
[[nodiscard]] inline std::string scientific(double number, int digits) {
  return decimal(number, digits, std::chars_format::scientific);
}

}  // namespace assur
