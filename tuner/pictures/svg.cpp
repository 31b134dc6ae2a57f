#include "pictures/svg.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace assur::pictures {

std::string at(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", value);
  return text.data();
}

double width(std::string_view text) {
  const auto starts = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; };
  return kLetter * static_cast<double>(std::count_if(text.begin(), text.end(), starts));
}

}  // namespace assur::pictures
