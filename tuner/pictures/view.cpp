#include "pictures/view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numbers.hpp"
#include "scene/triple.hpp"

namespace assur::pictures {
namespace {

constexpr double kYaw = -0.9, kPitch = 0.45;             // of the eye, rad
constexpr double kMargin = 34, kLow = 200, kHigh = 420;  // pixels
constexpr double kClearly = 1.5;                         // another view must spread the places this much wider

}  // namespace

View::View(int dimension, const std::vector<Triple>& seen, double width) {
  if (dimension == 3) {
    turn_to(kYaw, kPitch);
    std::array best = {kYaw, kPitch};
    double most = kClearly * spread(seen);
    for (int k = 0; k < 12; ++k) {
      for (const double pitch : {0.25, kPitch, 0.65, 0.9}) {
        const double yaw = kYaw + k * std::numbers::pi / 6;
        turn_to(yaw, pitch);
        if (const double now = spread(seen); now > most * 1.0001) best = {yaw, pitch}, most = now;
      }
    }
    turn_to(best[0], best[1]);
  }
  std::array<double, 2> low = {kInfinity, kInfinity}, high = {-kInfinity, -kInfinity};
  for (const Triple& p : seen) {
    const Triple t = turned(p);
    for (std::size_t k = 0; k < 2; ++k)
      low[k] = std::min<double>(low[k], t[k]), high[k] = std::max<double>(high[k], t[k]);
  }
  if (!(low[0] <= high[0])) low = high = {0, 0};
  const double wide = high[0] - low[0], tall = high[1] - low[1], least = std::max(std::max(wide, tall) / 1e3, 1e-300);
  zoom_ = (width - 2 * kMargin) / std::max(wide, least);
  height_ = std::clamp(tall * zoom_ + 2 * kMargin, kLow, kHigh);
  zoom_ = std::min(zoom_, (height_ - 2 * kMargin) / std::max(tall, least));
  x_ = width / 2 - zoom_ * (low[0] + high[0]) / 2;
  y_ = height_ / 2 + zoom_ * (low[1] + high[1]) / 2;
}

void View::turn_to(double yaw, double pitch) {
  const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch);
  right_ = {-sy, cy, 0};
  up_ = {-cy * sp, -sy * sp, cp};
  eye_ = {cy * cp, sy * cp, sp};
}

// The standard deviation in the narrow direction of the picture.
double View::spread(const std::vector<Triple>& seen) const {
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  const double share = 1 / std::max(1.0, static_cast<double>(seen.size()));
  for (const Triple& p : seen) x += share * turned(p)[0], y += share * turned(p)[1];
  for (const Triple& p : seen) {
    const double dx = turned(p)[0] - x, dy = turned(p)[1] - y;
    xx += share * dx * dx, xy += share * dx * dy, yy += share * dy * dy;
  }
  return std::sqrt(std::max(0.0, (xx + yy) / 2 - std::hypot((xx - yy) / 2, xy)));
}

Pixel View::at(const Triple& place) const {
  const Triple t = turned(place);
  return {x_ + zoom_ * t[0], y_ - zoom_ * t[1]};
}

Triple View::turned(const Triple& v) const {
  return {triple::dot(right_, v), triple::dot(up_, v), triple::dot(eye_, v)};
}

}  // namespace assur::pictures
