// Where an axis begins and ends, and what it names in between.
#pragma once

#include <string>
#include <vector>

namespace assur::pictures {

struct Ticks {
  double low = 0, high = 1;
  std::vector<double> at;  // ascending, from low to high
};

// Round numbers around [least, greatest], about `most` of them at most. A single value gets some room.
[[nodiscard]] Ticks linear_ticks(double least, double greatest, int most);

// The same for a logarithmic axis, 0 < least: powers of ten, or 1, 2, 5, 10, ... where those would be too few.
[[nodiscard]] Ticks logarithmic_ticks(double least, double greatest, int most);

// "10⁻¹²", "2·10⁻³"; from 1 to below 1000 as it is: "1", "10", "250".
[[nodiscard]] std::string power_of_ten(double value);

// "20 µs", "0.1 ms" is "100 µs": as short as it can be said.
[[nodiscard]] std::string time_text(double seconds);

}  // namespace assur::pictures
