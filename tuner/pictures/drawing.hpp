// The drawing of a scene: its points, the bodies and links between them, and the joints.
#pragma once

#include <cstdint>
#include <set>
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
    Triple at = {};      // of a fixed one, m
  };
  // A vector of the scene, or a fixed direction without a name.
  struct Direction {
    std::string name;
    bool fixed = false;
    Triple at = {};  // components of a fixed direction
  };
  // The direction of an axis: a direction, or that from one point to another.
  struct Axis {
    int direction = -1, from = -1, to = -1;
  };
  // rod: constant length; actuator: driven length; relation: any other constraint between both points.
  enum class Kind : std::uint8_t { rod, actuator, relation };
  struct Link {
    int from = 0, to = 0;  // points
    Kind kind = Kind::rod;
    std::string name;
    bool inside = false;  // within one body, or between points at rest
  };
  struct Body {
    std::string name;
    std::vector<int> points;
  };
  enum class Symbol : std::uint8_t { revolute, prismatic, cylindrical, spherical, universal, planar };
  // A joint of the scene, or of points and equations: a point where links or bodies meet is a revolute joint in the
  // plane and a spherical one in space, unless an equation makes it a hinge; a point on a line is a prismatic joint.
  struct Joint {
    std::string name;
    Symbol symbol = Symbol::revolute;
    int point = 0;
    std::vector<Axis> axes = {};       // universal: two; planar: the normal, or two directions of the plane
    int origin = -1;                   // prismatic, cylindrical: a point of the line; -1: the first place of `point`
    std::vector<std::string> of = {};  // bodies; empty for a joint of points and equations
    bool driven = false;               // a driver sets its angle or displacement
  };

  int dimension = 2;
  std::vector<Group> groups;  // in solving order
  std::vector<Point> points;  // points that may move come first
  std::size_t moving = 0;     // number of points that may move
  std::vector<Direction> directions;
  std::vector<Link> links;    // without repeated pairs
  std::vector<Body> bodies;   // moving bodies with two points or more
  std::vector<Joint> joints;  // first those of the scene
};

// Makes the drawing, without the points and vectors in `left_out`. Groups are those of the formulation `groups` with
// all outputs. Throws like group_equations().
[[nodiscard]] Drawing drawing_of(const Scene& scene, std::set<std::string> left_out = {});

}  // namespace assur::pictures
