// tuner/pictures/animation, embedded at build time.
#pragma once

#include <string_view>

namespace assur::pictures {

[[nodiscard]] std::string_view animation_body();    // HTML: controls and canvases
[[nodiscard]] std::string_view animation_style();   // CSS, in addition to that of every page
[[nodiscard]] std::string_view animation_script();  // JavaScript, in the order of its dependencies

}  // namespace assur::pictures
