// Packs many numbers into a short text that a page reads fast.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace assur::pictures {

// Rows of `width` numbers each: 24 bits over the range of their column, seven digits in four letters of base64.
struct Packed {
  std::vector<double> low, span;  // width
  std::string text;               // 4 letters for each number; all bits set: not finite
};

// Appends 24 bits as four letters of base64.
void append_letters(std::string& text, std::uint32_t bits);

[[nodiscard]] Packed packed(std::span<const double> rows, std::size_t width);

}  // namespace assur::pictures
