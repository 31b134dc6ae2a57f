// Symbols of joints in pictures; tuner/pictures/animation/symbols.js draws the same ones in animations.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>

#include "numbers.hpp"
#include "pictures/moving_svg.hpp"
#include "scene/triple.hpp"

namespace assur::pictures {
namespace {

using Symbol = Drawing::Symbol;
using triple::scale;

Triple unit(const Triple& v) { return scale(1 / std::max<double>(triple::norm(v), 1e-300), v); }

// Two directions perpendicular to the axis and to each other.
std::array<Triple, 2> across(const Triple& axis) {
  const Triple b = unit(triple::cross(std::abs(axis[2]) < 0.9 ? Triple{0, 0, 1} : Triple{1, 0, 0}, axis));
  return {b, unit(triple::cross(axis, b))};
}

constexpr std::string_view kFree = "class=\"j\"", kDriven = "class=\"j d\"";

std::string circle(double radius, std::string_view look = kFree) {
  return "<circle " + std::string(look) + " r=\"" + pixels(radius) + "\"/>";
}

// A ball with the light on its upper left.
std::string ball(double size) {
  const double r = 0.6 * size;
  return circle(1.1 * size) + "<path d=\"M" + pixels(Pixel{-r, 0}) + "A" + pixels(Pixel{r, r}) + " 0 0 1 " +
         pixels(Pixel{0, -r}) + "\" stroke=\"" + std::string(kInk) + "\"/>";
}

// A triangle on a hatched line.
std::string ground(double size) {
  const double down = 2.3 * size, half = 1.5 * size;
  return "<path class=\"j\" d=\"M0,0L" + pixels(Pixel{-half, down}) + "L" + pixels(Pixel{half, down}) + "Z\"/>" +
         hatched({-down, down}, {down, down}, size);
}

class Symbols {
 public:
  Symbols(MovingSvg& svg, const Drawing::Joint& joint, double size)
      : svg_(svg), j_(joint), size_(size), look_(joint.driven ? kDriven : kFree) {}

  void draw() {
    if (svg_.postures().rests(j_.point)) svg_.around(j_.point, ground(size_));
    if (j_.symbol == Symbol::spherical) return svg_.around(j_.point, ball(size_));
    if (j_.axes.empty()) return svg_.around(j_.point, circle(size_, look_));
    if (j_.symbol == Symbol::revolute) return cylinder(1.8);
    if (j_.symbol == Symbol::cylindrical) return cylinder(2.6);
    if (j_.symbol == Symbol::universal) return cross();
    box();
  }

 private:
  // The axis k of the joint: to the right, upwards, to the eye.
  [[nodiscard]] Triple axis(std::size_t frame, std::size_t k = 0) const {
    return svg_.view().turned(svg_.postures().way(frame, j_.axes[k]));
  }

  // From the side: the outline, whose ends are arcs, and the near disc.
  void cylinder(double half) {
    struct Shape {
      Pixel far, near, side;
      std::string arc;
    };
    const auto shape = [&](std::size_t f) {
      Triple t = axis(f);
      if (t[2] < 0) t = scale(-1, t);
      const double flat = std::hypot(t[0], t[1]), ux = flat > 0 ? t[0] / flat : Number(1),
                   uy = flat > 0 ? -t[1] / flat : Number(0);
      const Pixel c = svg_.at(f, j_.point);
      const double dx = half * size_ * t[0], dy = -half * size_ * t[1];
      return Shape{{c[0] - dx, c[1] - dy},
                   {c[0] + dx, c[1] + dy},
                   {-uy * size_, ux * size_},
                   "A" + pixels(Pixel{std::max<double>(0.1, size_ * t[2]), size_}) + " " +
                       pixels(std::atan2(uy, ux) * 360 / kTurn) + " 0 1 "};
    };
    const auto off = [](const Pixel& p, const Pixel& by, double sign) {
      return pixels(Pixel{p[0] + sign * by[0], p[1] + sign * by[1]});
    };
    const auto outline = [&](std::size_t f) {
      const Shape s = shape(f);
      return "M" + off(s.far, s.side, 1) + s.arc + off(s.far, s.side, -1) + "L" + off(s.near, s.side, -1) + s.arc +
             off(s.near, s.side, 1) + "Z";
    };
    const auto disc = [&](std::size_t f) {
      const Shape s = shape(f);
      return "M" + off(s.near, s.side, 1) + s.arc + off(s.near, s.side, -1) + s.arc + off(s.near, s.side, 1) + "Z";
    };
    svg_.element("path", "d", outline, look_);
    svg_.element("path", "d", disc, look_);
  }

  void cross() {
    for (std::size_t k = 0; k < j_.axes.size(); ++k) {
      const auto line = [&](std::size_t f) {
        const Triple t = scale(2 * size_, axis(f, k));
        const Pixel c = svg_.at(f, j_.point);
        return pixels(std::vector<Pixel>{{c[0] - t[0], c[1] + t[1]}, {c[0] + t[0], c[1] - t[1]}});
      };
      svg_.element("polyline", "points", line,
                   "stroke=\"" + std::string(kInk) + "\" stroke-width=\"" + pixels(0.6 * size_) + "\"");
    }
    svg_.around(j_.point, circle(0.6 * size_));
  }

  // Half the edges of a block or of a plate, pixels.
  [[nodiscard]] std::array<Triple, 3> edges(std::size_t f) const {
    const Triple first = svg_.postures().way(f, j_.axes[0]);
    const bool is_plate = j_.symbol == Symbol::planar;
    const Triple normal = j_.axes.size() > 1 ? unit(triple::cross(first, svg_.postures().way(f, j_.axes[1]))) : first;
    const auto [b, n] = across(normal);
    const auto turned = [&](const Triple& v, double half) { return scale(half * size_, svg_.view().turned(v)); };
    if (is_plate) return {turned(b, 3), turned(n, 3), turned(normal, 0.3)};
    return {turned(normal, 2), turned(b, 1.25), turned(n, 1.25)};
  }

  // The three faces that look at the eye.
  void box() {
    for (std::size_t k = 0; k < 3; ++k) {
      if (svg_.postures().drawing->dimension == 2 && std::abs(edges(0)[k][2]) < 0.5) continue;  // seen from its edge
      const auto face = [&](std::size_t f) {
        const std::array<Triple, 3> half = edges(f);
        const double sign = half[k][2] < 0 ? -1 : 1;
        const Triple &a = half[(k + 1) % 3], &b = half[(k + 2) % 3];
        const Pixel c = svg_.at(f, j_.point);
        std::vector<Pixel> corners;
        for (const auto& [p, q] : {std::pair{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}) {
          corners.push_back(
              {c[0] + sign * half[k][0] + p * a[0] + q * b[0], c[1] - sign * half[k][1] - p * a[1] - q * b[1]});
        }
        return pixels(corners);
      };
      svg_.element("polygon", "points", face, look_);
    }
  }

  MovingSvg& svg_;
  const Drawing::Joint& j_;
  double size_;
  std::string_view look_;
};

}  // namespace

void draw_joint(MovingSvg& svg, const Drawing::Joint& joint, double size) { Symbols(svg, joint, size).draw(); }

}  // namespace assur::pictures
