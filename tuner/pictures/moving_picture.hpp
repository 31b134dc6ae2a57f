// A mechanism in motion as an SVG picture, with the symbols of engineers.
#pragma once

#include <string>
#include <string_view>

#include "pictures/postures.hpp"

namespace assur::pictures {

// The picture shows one period of a motion that repeats, else the motion there and back. It has as many frames as fit
// into 60 kB; a mechanism that is too large for this stands still.
[[nodiscard]] std::string moving_picture(const Postures& postures, std::string_view title);

}  // namespace assur::pictures
