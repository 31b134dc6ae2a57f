// Chains of 64 groups on as many levels, of one to three classes.
#pragma once

#include "assur/scene.hpp"

namespace assur::bench {

// Slider-cranks and rockers in turn: each rocker is moved by the slider before it, and moves the next one.
[[nodiscard]] Scene slider_chain();
// Six-bars in series: each bell crank is moved by a four-bar, and its other arm moves a rocker.
[[nodiscard]] Scene six_bar_chain();
// Points in space at known distances from two fixed points and from the point before.
[[nodiscard]] Scene spatial_chain();

}  // namespace assur::bench
