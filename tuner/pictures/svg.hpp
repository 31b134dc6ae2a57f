// What plots and heat maps are written with: elements of SVG, and the figures that they stand in.
#pragma once

#include <string>
#include <string_view>

namespace assur::pictures::svg {

// A coordinate, to a tenth of a pixel: "12.3".
[[nodiscard]] std::string at(double value);

// About, in pixels at the size of letters that plot_style() sets.
[[nodiscard]] double width(std::string_view text);

inline constexpr double kLetter = 7.4;  // width of one
inline constexpr double kLine = 15;     // height of one

// anchor: "start", "middle" or "end". What is shown and read is escaped here; css_class and `look` (more attributes of
// the element) are not.
[[nodiscard]] std::string text(std::string_view css_class, double x, double y, std::string_view anchor,
                               std::string_view what);
[[nodiscard]] std::string line(std::string_view css_class, double x1, double y1, double x2, double y2);
// about: shown where the pointer rests.
[[nodiscard]] std::string rectangle(double x, double y, double w, double h, std::string_view about,
                                    std::string_view look = {});

// A picture that is read to who cannot see it as `title`.
[[nodiscard]] std::string picture(std::string_view css_class, double w, double h, std::string_view title,
                                  std::string_view content);

// An entry of a legend: `content` is drawn on 24 x 18 before the name.
[[nodiscard]] std::string key(std::string_view content, std::string_view name);

// A <figure> with one picture for wide windows and one for narrow ones, of which plot_style() shows one, and a legend.
[[nodiscard]] std::string figure(std::string_view wide, std::string_view narrow, std::string_view keys);

}  // namespace assur::pictures::svg
