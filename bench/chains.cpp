#include "chains.hpp"

#include <cmath>
#include <string>

namespace assur::bench {
namespace {

constexpr double kStep = 0.01, kEnd = 10;  // s
constexpr int kStages = 32;                // of two groups

std::string number(const char* name, int i) { return name + std::to_string(i); }

// A crank of radius 0.1 about A0 that turns once in two seconds.
SceneBuilder crank(const char* name, int dimensions) {
  SceneBuilder b(name, dimensions);
  b.fixed_point("A0", {0, 0, 0}).point("B0", {0.1, 0, 0}).constrain("crank", Distance{"A0", "B0", 0.1});
  const Law turn = Law::polynomial({0, 3.14});
  if (dimensions == 2) {
    b.drive("motor", PointAngle{"A0", "B0", "", turn});
  } else {
    b.fixed_vector("z", {0, 0, 1}).drive("motor", PointAngle{"A0", "B0", "z", turn});
  }
  return b;
}

Scene finish(SceneBuilder b, const std::string& last) {
  b.output(last).time(0, kEnd, kStep);
  return std::move(b).build();
}

}  // namespace

Scene slider_chain() {
  SceneBuilder b = crank("sliders", 2);
  b.fixed_point("O", {0, 0, 0}).fixed_vector("x", {1, 0, 0});
  for (int i = 0; i < kStages; ++i) {
    const double x = 2 * (i + 1);
    const std::string P = number("P", i), A = number("A", i + 1), B = number("B", i + 1);
    b.point(P, {x - 0.9, 0, 0})
        .constrain(number("slot", i), OnLine{P, "O", "x"})
        .constrain(number("rod", i), Distance{number("B", i), P, 1})
        .fixed_point(A, {x + 0.1, -1, 0})
        .point(B, {x + 0.1, 0, 0})
        .constrain(number("coupler", i), Distance{P, B, 1})
        .constrain(number("rocker", i), Distance{A, B, 1});
  }
  return finish(std::move(b), number("B", kStages));
}

Scene six_bar_chain() {
  SceneBuilder b = crank("six_bars", 2);
  for (int i = 0; i < kStages; ++i) {
    const double x = 2.2 * i;
    const std::string A = number("A", i + 1), C = number("C", i), D = number("D", i), G = number("G", i),
                      B = number("B", i + 1);
    b.fixed_point(A, {x + 1.1, -1, 0})
        .point(C, {x + 1.1, 0, 0})
        .constrain(number("coupler", i), Distance{number("B", i), C, 1})
        .constrain(number("rocker", i), Distance{A, C, 1})
        .add(Body{number("bell", i), "", {}, {A, C}, {{D, {0.9, -0.3, 0}}}, {}})
        .fixed_point(G, {x + 2.3, -1, 0})
        .point(B, {x + 2.3, 0, 0})
        .constrain(number("link", i), Distance{D, B, 0.9})
        .constrain(number("arm", i), Distance{G, B, 1});
  }
  return finish(std::move(b), number("B", kStages));
}

Scene spatial_chain() {
  SceneBuilder b = crank("spatial", 3);
  for (int i = 0; i < 2 * kStages; ++i) {
    const double x = i + 1.1;
    const std::string F = number("F", i), G = number("G", i), B = number("B", i + 1);
    b.fixed_point(F, {x, 1, 0})
        .fixed_point(G, {x, 0.2, 1})
        .point(B, {x, 0, 0})
        .constrain(number("rod", i), Distance{number("B", i), B, 1})
        .constrain(number("first", i), Distance{F, B, 1})
        .constrain(number("second", i), Distance{G, B, std::hypot(0.2, 1)});
  }
  return finish(std::move(b), number("B", 2 * kStages));
}

}  // namespace assur::bench
