#include "db/checksum.hpp"

#include <bit>
#include <charconv>
#include <cmath>

#include "numbers.hpp"

namespace assur::db {

// Every input bit reaches every output bit: the multiplication carries upwards, and the shift moves the high half down.
void Checksum::take(std::uint64_t bits) {
  value_ = (value_ ^ bits) * 0x9e3779b97f4a7c15;  // 2^64 / golden ratio
  value_ ^= value_ >> 32;
  value_ *= 0xd6e8feb86659fd93;
  value_ ^= value_ >> 29;
}

Checksum& Checksum::operator<<(std::string_view text) {
  take(text.size());
  // Eight bytes at a time, the first one highest; the remaining bytes are the low end of a word.
  for (; text.size() >= 8; text.remove_prefix(8)) {
    const auto byte = [&](std::size_t i) { return std::uint64_t{static_cast<unsigned char>(text[i])}; };
    take(byte(0) << 56 | byte(1) << 48 | byte(2) << 40 | byte(3) << 32 | byte(4) << 24 | byte(5) << 16 | byte(6) << 8 |
         byte(7));  // one load
  }
  if (text.empty()) return *this;
  std::uint64_t word = 0;
  for (const char byte : text) word = word << 8 | static_cast<unsigned char>(byte);
  take(word);
  return *this;
}

Checksum& Checksum::operator<<(std::int64_t number) {
  take(static_cast<std::uint64_t>(number));
  return *this;
}

Checksum& Checksum::operator<<(double number) {
  if (std::isnan(number)) number = kNan;
  take(std::bit_cast<std::uint64_t>(number == 0 ? 0.0 : number));
  return *this;
}

std::uint64_t checksum(const Shape& s) {
  Checksum sum;
  sum << std::int64_t{s.n} << std::int64_t{s.nnz} << std::int64_t{s.groups} << std::int64_t{s.rhs} << s.fill
      << s.operations << s.depth << s.terms << static_cast<std::int64_t>(s.pattern) << std::int64_t{s.one_program};
  return sum.value();
}

std::string hexadecimal(std::uint64_t number) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; number >>= 4) text[i] = kDigits[number & 15];
  return text;
}

bool parse_hexadecimal(std::string_view text, std::uint64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
  return error == std::errc() && text.size() == 16 && end == text.data() + 16;
}

}  // namespace assur::db
