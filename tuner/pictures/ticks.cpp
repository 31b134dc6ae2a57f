#include "pictures/ticks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "decimal.hpp"

namespace assur::pictures {
namespace {

constexpr double kRounding = 1e-9;              // tolerance for values on a tick
constexpr double kFewDecades = 2.5;             // up to this range, ticks lie within decades, too
constexpr std::array kRound = {1.0, 2.0, 5.0};  // in each decade

// Steps of 1, 2 or 5 times a power of ten.
double round_step(double least) {
  const double decade = std::pow(10, std::floor(std::log10(least) + kRounding));
  for (const double r : kRound) {
    if (r * decade >= least * (1 - kRounding)) return r * decade;
  }
  return 10 * decade;
}

Ticks decades(int low, int high, int most) {
  Ticks ticks{std::pow(10, low), std::pow(10, high), {}};
  const int stride = std::max(1, (high - low + most - 1) / most);
  // Multiples of the stride, so that the same powers are labelled for every range.
  for (int k = low; k <= high; ++k) {
    if (k % stride == 0) ticks.at.push_back(std::pow(10, k));
  }
  return ticks;
}

Ticks within_decades(double least, double greatest) {
  std::vector<double> all;
  const int from = static_cast<int>(std::floor(std::log10(least))) - 1;
  const int to = static_cast<int>(std::ceil(std::log10(greatest))) + 1;
  for (int k = from; k <= to; ++k) {
    for (const double r : kRound) all.push_back(r * std::pow(10, k));
  }
  const auto begin = std::find_if(all.rbegin(), all.rend(), [&](double v) { return v <= least * (1 + kRounding); });
  const auto end = std::find_if(all.begin(), all.end(), [&](double v) { return v >= greatest * (1 - kRounding); });
  auto first = begin.base() - 1, last = end;
  if (first == last) ++last;
  return {*first, *last, {first, last + 1}};
}

std::string superscript(int number) {
  static constexpr std::array kDigits = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = number < 0 ? "⁻" : "";
  for (const char digit : std::to_string(std::abs(number))) text += kDigits[static_cast<std::size_t>(digit - '0')];
  return text;
}

}  // namespace

Ticks linear_ticks(double least, double greatest, int most) {
  if (!(greatest > least)) {
    const double room = least == 0 ? 1 : std::abs(least) / 2;
    least -= room;
    greatest += room;
  }
  const double step = round_step((greatest - least) / most);
  const auto first = static_cast<long>(std::floor(least / step + kRounding));
  const auto last = static_cast<long>(std::ceil(greatest / step - kRounding));
  Ticks ticks;
  for (long k = first; k <= last; ++k) ticks.at.push_back(static_cast<double>(k) * step);
  ticks.low = ticks.at.front();
  ticks.high = ticks.at.back();
  return ticks;
}

Ticks logarithmic_ticks(double least, double greatest, int most) {
  if (std::log10(greatest / least) <= kFewDecades) return within_decades(least, greatest);
  const int low = static_cast<int>(std::floor(std::log10(least) + kRounding));
  const int high = static_cast<int>(std::ceil(std::log10(greatest) - kRounding));
  return decades(low, high, most);
}

std::string power_of_ten(double value) {
  const int k = static_cast<int>(std::floor(std::log10(value) + kRounding));
  const double factor = value / std::pow(10, k);
  if (k >= 0 && k <= 2) return general(value, 6);
  const std::string power = "10" + superscript(k);
  return std::abs(factor - 1) < 1e-6 ? power : general(factor, 3) + "·" + power;
}

std::string time_text(double seconds) {
  struct Unit {
    double size;
    const char* name;
  };
  static constexpr std::array kUnits = {Unit{1, " s"}, Unit{1e-3, " ms"}, Unit{1e-6, " µs"}, Unit{1e-9, " ns"}};
  const auto* const unit =
      std::find_if(kUnits.begin(), kUnits.end() - 1, [&](const Unit& u) { return seconds >= u.size * (1 - 1e-6); });
  return general(seconds / unit->size, 4) + unit->name;
}

}  // namespace assur::pictures
