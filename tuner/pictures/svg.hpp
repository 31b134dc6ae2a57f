// Elements of SVG for plots and heat maps, and the figures that contain them.
#pragma once

#include <string>
#include <string_view>

namespace assur::pictures::svg {

// A coordinate with a tenth of a pixel: "12.3".
[[nodiscard]] std::string at(double value);

// Approximate width in pixels, for the font size of plot_style().
[[nodiscard]] double width(std::string_view text);

inline constexpr double kLetter = 7.4;  // width of a letter, pixels
inline constexpr double kLine = 15;     // height of a line, pixels

// A text. anchor: "start", "middle" or "end". Texts are escaped here; css_class and `look` (further attributes) are
// not.
[[nodiscard]] std::string text(std::string_view css_class, double x, double y, std::string_view anchor,
                               std::string_view what);
[[nodiscard]] std::string line(std::string_view css_class, double x1, double y1, double x2, double y2);
// about: tooltip.
[[nodiscard]] std::string rectangle(double x, double y, double w, double h, std::string_view about,
                                    std::string_view look = {});

// A picture; `title` is its text for screen readers.
[[nodiscard]] std::string picture(std::string_view css_class, double w, double h, std::string_view title,
                                  std::string_view content);

// An entry of a legend: `content` is drawn on 24 x 18 pixels before the name.
[[nodiscard]] std::string key(std::string_view content, std::string_view name);

// A <figure> with a legend and with pictures for wide and narrow windows, of which plot_style() shows one.
[[nodiscard]] std::string figure(std::string_view wide, std::string_view narrow, std::string_view keys);

}  // namespace assur::pictures::svg
