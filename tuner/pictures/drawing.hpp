// The drawing of a scene: its points, and the links between them.
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
    // Points that belong to no group, in the order of solving. Resting: solved once, because no driver moves it.
    static constexpr int kFixed = -3, kResting = -2, kDriven = -1;

    std::string name;
    int group = kFixed;  // index into `groups`, or one of these
    bool slides = false;
    Triple at = {};  // of a fixed one, m
  };
  // rod: constant length; actuator: driven length; rail: the second point slides along it; relation: any other
  // constraint between both points.
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
  std::vector<Point> points;  // points that may move come first
  std::size_t moving = 0;     // number of points that may move
  std::vector<Link> links;    // without repeated pairs
  std::vector<Body> bodies;   // moving bodies with two points or more
};

// Makes the drawing. Groups are those of the formulation `groups` with all outputs. Throws like analyze().
[[nodiscard]] Drawing drawing_of(const Scene& scene);

}  // namespace assur::pictures
