#include "pictures/svg.hpp"

#include <algorithm>

#include "decimal.hpp"

namespace assur::pictures {

std::string at(double value) { return fixed(value, 1); }

double width(std::string_view text) {
  const auto starts = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; };
  return kLetter * static_cast<double>(std::count_if(text.begin(), text.end(), starts));
}

}  // namespace assur::pictures
