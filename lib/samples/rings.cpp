#include <numbers>
#include <string>
#include <vector>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {
namespace {

std::string number(const std::string& name, int i) { return name + std::to_string(i); }

// A closed chain of m points; each also has a rod of length 1 to its own anchor. The zigzag and the slanted rods keep
// the condition of its 2m equations between 5 and 16 for m = 6 .. 360; more symmetric drawings are singular.
struct Ring {
  std::vector<Triple> point, anchor;

  explicit Ring(int m) {
    const double radius = m * std::cos(std::numbers::pi / 6) / kTurn + 0.5;
    for (int i = 0; i < m; ++i) {
      const double angle = kTurn * i / m, side = i % 2 == 0 ? 1 : -1;
      point.push_back((radius - 0.25 * side) * heading(angle));
      anchor.push_back(point.back() + heading(angle + side * std::numbers::pi / 6));
    }
  }
};

// Adds points NAME0.. and the odd anchors, which are fixed; the even anchors exist already. Lengths are those of the
// drawing.
void add_ring(SceneBuilder& builder, const Ring& ring, const std::string& name, const std::string& group) {
  const int m = static_cast<int>(ring.point.size());
  std::vector<std::string> unknowns;
  for (int i = 0; i < m; ++i) {
    const std::string point = number(name, i), anchor = number(name + "A", i);
    builder.point(point, ring.point[static_cast<std::size_t>(i)]);
    if (i % 2 != 0) builder.fixed_point(anchor, ring.anchor[static_cast<std::size_t>(i)]);
    builder.constrain(number(name + "rod", i), Distance{anchor, point, {}});
    builder.constrain(number(name + "link", i), Distance{point, number(name, (i + 1) % m), {}});
    unknowns.push_back(point);
  }
  builder.add(DeclaredGroup{group, std::move(unknowns)});
}

}  // namespace

// The larger configurations of the paper: a terminal of T unknowns and `legs` groups of n unknowns that depend on it,
// each with three nonzeros in a row on average. Terminal: points T0.., even anchors driven on a circle of radius 0.03
// that starts at the drawing. Leg k: points Lk_0.., even anchors carried along by T0.
Scene rings(const Values& values) {
  const double radius = 0.03, quarter = std::numbers::pi / 2;
  const Ring terminal(values.count("terminal") / 2), leg(values.count("n") / 2);
  SceneBuilder builder("rings", 2);

  for (std::size_t i = 0; i < terminal.anchor.size(); i += 2) {
    const std::string anchor = number("TA", static_cast<int>(i));
    const auto [x, y, z] = terminal.anchor[i];
    builder.point(anchor, terminal.anchor[i])
        .drive(anchor + "x", DrivenCoordinate{anchor + ".x", wave(radius, values["omega"], quarter, x - radius)})
        .drive(anchor + "y", DrivenCoordinate{anchor + ".y", wave(radius, values["omega"], 0, y)});
  }
  add_ring(builder, terminal, "T", "SG_T");

  for (int k = 1; k <= values.count("legs"); ++k) {
    const std::string name = number("L", k) + "_";
    Body carrier{number("carrier", k), "T0", {}, {}, {}, {}};
    for (std::size_t i = 0; i < leg.anchor.size(); i += 2) {
      carrier.points.push_back({number(name + "A", static_cast<int>(i)), leg.anchor[i] - terminal.point[0]});
    }
    builder.add(std::move(carrier));
    add_ring(builder, leg, name, number("SG_L", k));
  }
  return builder.time(0, values.plain("steps") * values.plain("step"), values.plain("step")).build();
}

}  // namespace assur::samples
