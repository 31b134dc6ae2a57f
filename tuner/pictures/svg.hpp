// Numbers and letters of SVG.
#pragma once

#include <string>
#include <string_view>

namespace assur::pictures {

// A coordinate, to a tenth of a pixel: "12.3".
[[nodiscard]] std::string at(double value);

// About, in pixels at the size of letters that plot_style() sets.
[[nodiscard]] double width(std::string_view text);

inline constexpr double kLetter = 7.4;  // width of one
inline constexpr double kLine = 15;     // height of one

}  // namespace assur::pictures
