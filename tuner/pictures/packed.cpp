#include "pictures/packed.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "numbers.hpp"

namespace assur::pictures {
namespace {

constexpr std::uint32_t kNotFinite = (1U << 24U) - 1;
constexpr double kSteps = kNotFinite - 1;

}  // namespace

void append_letters(std::string& text, std::uint32_t bits) {
  static constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (const unsigned shift : {18U, 12U, 6U, 0U}) text += kLetters[(bits >> shift) & 63U];
}

Packed packed(std::span<const double> rows, std::size_t width) {
  Packed out{std::vector(width, kInfinity), std::vector(width, 0.0), {}};
  std::vector<double> high(width, -kInfinity);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!std::isfinite(rows[i])) continue;
    out.low[i % width] = std::min(out.low[i % width], rows[i]);
    high[i % width] = std::max(high[i % width], rows[i]);
  }
  for (std::size_t c = 0; c < width; ++c) {
    if (high[c] < out.low[c]) out.low[c] = high[c] = 0;
    out.span[c] = high[c] - out.low[c];
  }
  out.text.reserve(4 * rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t c = i % width;
    const double share = out.span[c] > 0 ? (rows[i] - out.low[c]) / out.span[c] : 0;
    append_letters(out.text,
                   std::isfinite(rows[i]) ? static_cast<std::uint32_t>(std::lround(share * kSteps)) : kNotFinite);
  }
  return out;
}

}  // namespace assur::pictures
