// The mechanisms of the comparison, sample("four_bar:N") and sample("stewart"), as bare numbers for programs that do
// not use the library, and the few vector products that these programs need. C++17, because Simbody's headers do not
// compile as C++20.
#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace peers {

inline constexpr double kPi = 3.14159265358979323846;

using Vec = std::array<double, 3>;

inline Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vec operator*(double s, const Vec& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vec heading(double azimuth) { return {std::cos(azimuth), std::sin(azimuth), 0}; }

// Loop i: a coupler from B(i-1) to B(i), and a rocker from B(i) to (2 i, 0). B(0) is the end of the crank about (0, 0).
struct FourBars {
  static constexpr double kCrank = 0.8, kRocker = 1.3, kSpeed = 2 * kPi;  // m, m, rad/s
  static constexpr double coupler(int loop) { return loop == 1 ? 1.8 : 2.0; }
};

struct Wave {
  double amplitude, phase, offset = 0;
  [[nodiscard]] double at(double t) const { return offset + amplitude * std::sin(t + phase); }
};

// Six handles turn about axes through A. A rod joins each handle to P on the terminal, whose pose is given.
struct Stewart {
  static constexpr double kHandle = 0.2, kRod = 0.55;  // m
  struct Leg {
    Vec A, axis;  // of the handle's hinge, on the ground
    Vec P;        // on the terminal
  };
  // Pose of the terminal: x, y, z, and psi, theta, phi of Rz(psi) Ry(theta) Rx(phi).
  static constexpr std::array<Wave, 6> kPose = {
      {{0.05, 0}, {0.05, 1}, {0.05, 2, 0.55}, {0.15, 0.5}, {0.15, 1.5}, {0.15, 2.5}}};

  static std::array<Leg, 6> legs() {
    std::array<Leg, 6> all;
    for (int k = 0; k < 6; ++k) {
      const double pair = 2 * kPi / 3 * (k / 2), side = k % 2 == 0 ? -1 : 1;
      const double base = pair + 0.35 * side, elevation = 0.1;
      const Vec rise = {0, 0, std::sin(elevation)};
      all[static_cast<std::size_t>(k)] = {0.5 * heading(base),
                                          std::cos(elevation) * heading(base + kPi / 2 + 0.2) + rise,
                                          0.3 * heading(pair + 0.7 * side)};
    }
    return all;
  }

  // Position of P of a leg at time t.
  static Vec joint(const Leg& leg, double t) {
    const double psi = kPose[3].at(t), theta = kPose[4].at(t), phi = kPose[5].at(t);
    const auto [x, y, z] = leg.P;
    const double y1 = std::cos(phi) * y - std::sin(phi) * z, z1 = std::sin(phi) * y + std::cos(phi) * z;
    const double x2 = std::cos(theta) * x + std::sin(theta) * z1, z2 = std::cos(theta) * z1 - std::sin(theta) * x;
    return {kPose[0].at(t) + std::cos(psi) * x2 - std::sin(psi) * y1,
            kPose[1].at(t) + std::sin(psi) * x2 + std::cos(psi) * y1, kPose[2].at(t) + z2};
  }
};

}  // namespace peers
