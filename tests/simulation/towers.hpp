// Platforms on one another: groups of four and of nine unknowns in a chain.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "assur/scene.hpp"

namespace assur::test {

// Rigid platforms whose points lie on circles, on legs of driven lengths: three in the plane, six in space. The first
// `coupled` of them stand on the platform below, the others on the ground.
inline Scene tower(int dimension, int platforms, std::size_t coupled) {
  SceneBuilder b("tower", dimension);
  const int legs = dimension == 2 ? 3 : 6;
  std::vector<std::string> below;
  std::vector<Triple> at;
  for (int k = 0; k <= platforms; ++k) {
    const double level = 1.2 * k, size = 1 - 0.03 * k;
    std::vector<std::string> points;
    std::vector<Triple> here;
    for (int leg = 0; leg < legs; ++leg) {
      points.push_back("P" + std::to_string(k) + "_" + std::to_string(leg));
      const double angle = std::numbers::pi * (dimension == 2 ? (2.0 * leg + k) / 3 : (leg + 0.7 * (leg % 2)) / 3.0);
      here.push_back(dimension == 2 ? Triple{size * std::cos(angle), level + size * std::sin(angle), 0}
                                    : Triple{size * std::cos(angle), size * std::sin(angle), level});
      if (k == 0) {
        b.fixed_point(points.back(), here.back());
      } else {
        b.point(points.back(), here.back());
      }
    }
    if (k > 0) {
      Body platform{"platform" + std::to_string(k)};
      platform.rigid = points;
      b.add(std::move(platform));
      for (std::size_t leg = 0; leg < points.size(); ++leg) {
        const std::size_t on = dimension == 2 ? leg : (leg + 1) % points.size();
        std::string base = below[on];
        if (leg >= coupled && k > 1) {
          base = "G" + std::to_string(k) + "_" + std::to_string(leg);
          b.fixed_point(base, at[on]);
        }
        double square = 0;
        for (std::size_t i = 0; i < 3; ++i) {
          const double way = here[leg][i] - at[on][i];
          square += way * way;
        }
        const Law law = Law::harmonics({{0.002, 2.0 + 0.3 * k, 0.7 * static_cast<double>(leg)}}, std::sqrt(square));
        b.drive("leg" + std::to_string(k) + "_" + std::to_string(leg), DrivenDistance{base, points[leg], law});
      }
    }
    below = std::move(points);
    at = std::move(here);
  }
  return b.time(0, 0.2, 0.002).build();
}

}  // namespace assur::test
