// A checksum over many values, the same on every machine. It finds accidental damage, not deliberate changes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "assur/performance.hpp"

namespace assur::db {

class Checksum {
 public:
  // The length is included: "ab", "c" differs from "a", "bc".
  Checksum& operator<<(std::string_view text);
  Checksum& operator<<(std::int64_t number);
  Checksum& operator<<(double number);  // all NaN are equal, and -0 is 0, as a database returns them

  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  void take(std::uint64_t bits);

  std::uint64_t value_ = 0x243f6a8885a308d3;  // digits of pi
};

[[nodiscard]] std::uint64_t checksum(const Shape& shape);

// To 16 hexadecimal digits, and back; false if the text has another form.
[[nodiscard]] std::string hexadecimal(std::uint64_t number);
[[nodiscard]] bool parse_hexadecimal(std::string_view text, std::uint64_t& number);

}  // namespace assur::db
