#include "check/closed_forms.hpp"

#include <charconv>
#include <numbers>

#include "scene/law_evaluate.hpp"

namespace assur::check {
namespace {

// The angle of the only driver of the scene.
LongJet motor(const Scene& scene, double t) {
  return evaluate<long double>(std::get<PointAngle>(scene.drivers().at(0).kind).law, static_cast<long double>(t));
}

// 12 for "B12"; empty for other names.
std::optional<int> number_behind(char letter, const std::string& name) {
  int number = 0;
  if (name.size() < 2 || name[0] != letter) return std::nullopt;
  const auto [end, error] = std::from_chars(name.data() + 1, name.data() + name.size(), number);
  if (error != std::errc() || end != name.data() + name.size()) return std::nullopt;
  return number;
}

// B_i = (i distance + cos f, sin f), because all rods of length 1 are parallel to the crank.
ClosedForm rhombi(const Scene& scene, double distance) {
  return [scene, distance](const std::string& output, double t) -> std::optional<std::array<LongJet, 3>> {
    const std::optional<int> i = number_behind('B', output);
    if (!i) return std::nullopt;
    return on_circle({distance * *i, 0, 0}, 1, motor(scene, t));
  };
}

// The end B of the crank, above the rail, for a piston at (x, 0); B is 0.1 m from the origin and 0.3 m from the piston.
ClosedForm piston(const Scene& scene) {
  const Law law = std::get<DrivenCoordinate>(scene.drivers().at(0).kind).law;
  const auto length = [&scene](std::size_t i) {
    return static_cast<long double>(*scene.constraints().at(i).as<Distance>()->value);
  };
  const long double crank = length(0), rod = length(1);
  return [law, crank, rod](const std::string& output, double t) -> std::optional<std::array<LongJet, 3>> {
    if (output != "B") return std::nullopt;
    const LongJet x = evaluate<long double>(law, static_cast<long double>(t));
    const LongJet along = (x * x + (crank + rod) * (crank - rod)) / (x * 2.0L);
    return std::array<LongJet, 3>{along, sqrt((along + crank) * (crank - along)), LongJet{}};
  };
}

// A four-bar whose joint C lies on the left of the line from B to D.
ClosedForm four_bar(const Scene& scene) {
  const auto at = [&scene](const std::string& name) {
    for (const Point& p : scene.points()) {
      if (p.name == name) return p.at;
    }
    throw Error(Error::Kind::input, "the closed form needs a point '" + name + "'");
  };
  const auto length = [&scene](const std::string& name) {
    for (const Constraint& c : scene.constraints()) {
      if (c.name == name) return *c.as<Distance>()->value;
    }
    throw Error(Error::Kind::input, "the closed form needs a distance '" + name + "'");
  };
  return [scene, A = at("A"), D = at("D"), crank = length("crank"), coupler = length("coupler"),
          rocker = length("rocker")](const std::string& output, double t) -> std::optional<std::array<LongJet, 3>> {
    const std::array<LongJet, 3> B = on_circle(A, crank, motor(scene, t));
    if (output == "B") return B;
    if (output == "C") return meet(B, coupler, D, rocker);
    return std::nullopt;
  };
}

// A point P that turns about the origin once a second, at a distance of 1 m, and its angle.
ClosedForm unit_circle() {
  return [](const std::string& output, double t) -> std::optional<std::array<LongJet, 3>> {
    constexpr long double kTurn = 2 * std::numbers::pi_v<long double>;
    const LongJet angle{kTurn * t, kTurn, 0};
    if (output == "angle") return std::array<LongJet, 3>{angle, LongJet{}, LongJet{}};
    if (output == "P") return on_circle({0, 0, 0}, 1, angle);
    return std::nullopt;
  };
}

// C = 2 r cos(angle) along the rail: the smooth continuation of the motion where the rod is perpendicular to the rail.
ClosedForm equal_slider_crank(const Scene& scene) {
  const double length = *scene.constraints().at(0).as<Distance>()->value;
  return [scene, length](const std::string& output, double t) -> std::optional<std::array<LongJet, 3>> {
    if (output == "rod_angle") return std::array<LongJet, 3>{motor(scene, t) * -1.0L, LongJet{}, LongJet{}};
    if (output != "C" && output != "displacement" && output != "slide.lambda") return std::nullopt;
    const std::array<LongJet, 3> crank = on_circle({0, 0, 0}, length, motor(scene, t));
    return std::array<LongJet, 3>{crank[0] * 2, LongJet{}, LongJet{}};
  };
}

}  // namespace

std::array<LongJet, 3> on_circle(const Triple& centre, double radius, const LongJet& angle) {
  const auto [cosine, sine] = cos_sin(angle);
  return {cosine * radius + centre[0], sine * radius + centre[1], LongJet{}};
}

std::array<LongJet, 3> meet(const std::array<LongJet, 3>& P, double p, const Triple& Q, double q) {
  const LongJet dx = Q[0] - P[0], dy = Q[1] - P[1], square = dx * dx + dy * dy;
  const long double pp = static_cast<long double>(p) * p, qq = static_cast<long double>(q) * q;
  const LongJet along = (square + (pp - qq)) / (square * 2.0L);
  const LongJet across = sqrt(pp / square - along * along);
  return {P[0] + along * dx - across * dy, P[1] + along * dy + across * dx, LongJet{}};
}

ClosedForm closed_form(const std::string& name, const Scene& scene) {
  if (name == "n_four_bar") return rhombi(scene, 1);
  if (name == "parallelograms" || name == "parallelogram") return rhombi(scene, 2);
  if (name == "equal_slider_crank") return equal_slider_crank(scene);
  if (name == "piston") return piston(scene);
  if (name == "four_bar") return four_bar(scene);
  if (name == "unit_circle") return unit_circle();
  throw Error(Error::Kind::input, "there is no closed form '" + name + "'");
}

}  // namespace assur::check
