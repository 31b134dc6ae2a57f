// What there is to draw of a scene: its points, and what holds them together.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "assur/scene.hpp"

namespace assur::pictures {

struct Drawing {
  struct Group {
    std::string name;
    int level = 0;
  };
  struct Point {
    // In the order in which they are known. Resting: solved once, for no driver moves it.
    static constexpr int kFixed = -3, kResting = -2, kDriven = -1;

    std::string name;
    int group = kFixed;  // index into `groups`, or one of these
    bool slides = false;
    Triple at = {};  // of a fixed one, m
  };
  // rod: of a constant length; actuator: of a driven one; rail: the second point slides along it; relation: whatever
  // else an element says about both
  enum class Kind : std::uint8_t { rod, actuator, rail, relation };
  struct Link {
    int from = 0, to = 0;  // points
    Kind kind = Kind::rod;
    std::string name;
  };
  struct Body {
    std::string name;
    std::vector<int> points;
  };

  int dimension = 2;
  std::vector<Group> groups;  // in solving order
  std::vector<Point> points;  // those that may move first
  std::size_t moving = 0;     // how many these are
  std::vector<Link> links;    // no pair of points twice
  std::vector<Body> bodies;   // moving, two points or more
};

// Groups are those of the formulation `groups`, everything wanted. Throws what analyze() does.
[[nodiscard]] Drawing drawing_of(const Scene& scene);

}  // namespace assur::pictures
