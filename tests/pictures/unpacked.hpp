// Unpacks numbers like the page of an animation.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace assur::pictures {

inline std::vector<double> unpacked(const std::string& text, const std::vector<double>& low,
                                    const std::vector<double>& span) {
  static constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<double> numbers;
  for (std::size_t i = 0; i + 4 <= text.size(); i += 4) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 4; ++k) bits = bits * 64 + static_cast<std::uint32_t>(kLetters.find(text[i + k]));
    const std::size_t c = i / 4 % low.size();
    const bool is_number = bits + 1 < 1U << 24U;
    numbers.push_back(is_number ? low[c] + span[c] * bits / ((1U << 24U) - 2)
                                : std::numeric_limits<double>::quiet_NaN());
  }
  return numbers;
}

}  // namespace assur::pictures
