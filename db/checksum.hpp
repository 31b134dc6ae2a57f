// One number over many values, the same on every machine. It finds damage; it is no protection against intent.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "assur/performance.hpp"

namespace assur::db {

class Checksum {
 public:
  // The length counts too: "ab", "c" is not "a", "bc".
  Checksum& operator<<(std::string_view text);
  Checksum& operator<<(std::int64_t number);
  Checksum& operator<<(double number);  // all NaN are one, -0 is 0: as a database gives them back

  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  void take(std::uint64_t bits);

  std::uint64_t value_ = 0x243f6a8885a308d3;  // digits of pi
};

[[nodiscard]] std::uint64_t checksum(const Shape& shape);

// 16 hexadecimal digits, and back: false for a text that is something else.
[[nodiscard]] std::string hexadecimal(std::uint64_t number);
[[nodiscard]] bool parse_hexadecimal(std::string_view text, std::uint64_t& number);

}  // namespace assur::db
