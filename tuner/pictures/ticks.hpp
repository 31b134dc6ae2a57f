// Range and ticks of an axis.
#pragma once

#include <string>
#include <vector>

namespace assur::pictures {

struct Ticks {
  double low = 0, high = 1;
  std::vector<double> at;  // ascending, from low to high
};

// About `most` round numbers or fewer, whose range includes [least, greatest]. The range of a single value is widened.
[[nodiscard]] Ticks linear_ticks(double least, double greatest, int most);

// The same for a logarithmic axis, 0 < least: powers of ten, or 1, 2, 5, 10, ... if those are too few.
[[nodiscard]] Ticks logarithmic_ticks(double least, double greatest, int most);

// "10⁻¹²", "2·10⁻³"; from 1 to below 1000 without a power: "1", "10", "250".
[[nodiscard]] std::string power_of_ten(double value);

// "20 µs", "100 µs": the shortest text.
[[nodiscard]] std::string time_text(double seconds);

}  // namespace assur::pictures
