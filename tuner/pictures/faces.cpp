#include "pictures/faces.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "scene/triple.hpp"

namespace assur::pictures {
namespace {

using triple::cross;
using triple::dot;
using triple::norm;
using triple::subtract;

constexpr double kFlat = 1e-9;  // distance from a plane, relative to the size, below which a point lies in it

// The corners of the convex hull, in order, of points in a plane with this normal.
std::vector<int> polygon(const std::vector<Triple>& points, std::vector<int> in_plane, const Triple& normal,
                         double tolerance) {
  const Triple& o = points[static_cast<std::size_t>(in_plane.front())];
  Triple x = subtract(points[static_cast<std::size_t>(in_plane[1])], o);
  for (const int i : in_plane) {  // takes the longest axis for accuracy
    const Triple to = subtract(points[static_cast<std::size_t>(i)], o);
    if (norm(to) > norm(x)) x = to;
  }
  const Triple y = cross(normal, x);  // its length differs from that of x
  struct Flat {
    double x, y;
    int index;
  };
  std::vector<Flat> flat;
  for (const int i : in_plane) {
    const Triple to = subtract(points[static_cast<std::size_t>(i)], o);
    flat.push_back({dot(to, x) / norm(x), dot(to, y) / norm(y), i});
  }
  std::sort(flat.begin(), flat.end(), [](const Flat& a, const Flat& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  // The two chains of the hull, from left to right and back, without points along its edges.
  std::vector<Flat> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t begin = hull.size();
    for (const Flat& p : flat) {
      while (hull.size() >= begin + 2) {
        const Flat &a = hull[hull.size() - 2], &b = hull.back();
        const double across = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
        if (across > tolerance * std::hypot(p.x - a.x, p.y - a.y)) break;
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(flat.begin(), flat.end());
  }
  std::vector<int> corners;
  for (const Flat& p : hull) corners.push_back(p.index);
  return corners;
}

// The first point at each place.
std::vector<int> places(const std::vector<Triple>& points, double tolerance) {
  std::vector<int> distinct;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::none_of(distinct.begin(), distinct.end(), [&](int j) {
          return norm(subtract(points[i], points[static_cast<std::size_t>(j)])) <= tolerance;
        })) {
      distinct.push_back(static_cast<int>(i));
    }
  }
  return distinct;
}

}  // namespace

std::vector<std::vector<int>> faces(const std::vector<Triple>& points) {
  double size = 0;
  for (const Triple& p : points) size = std::max<double>(size, norm(subtract(p, points.front())));
  const double tolerance = kFlat * size;
  const std::vector<int> all = places(points, tolerance);
  if (all.size() < 2) return {};
  const auto at = [&](int i) -> const Triple& { return points[static_cast<std::size_t>(i)]; };

  // The largest triangle with the longest edge shows whether the points lie on a line, in a plane, or in space.
  const int first = all.front();
  const int far = *std::max_element(all.begin(), all.end(), [&](int i, int j) {
    return norm(subtract(at(i), at(first))) < norm(subtract(at(j), at(first)));
  });
  const Triple edge = subtract(at(far), at(first));
  Triple normal{};
  for (const int i : all) {
    const Triple n = cross(edge, subtract(at(i), at(first)));
    if (norm(n) > norm(normal)) normal = n;
  }
  if (norm(normal) <= tolerance * norm(edge)) {
    const auto along = [&](int i, int j) { return dot(subtract(at(i), at(j)), edge) < 0; };
    const auto [from, to] = std::minmax_element(all.begin(), all.end(), along);
    return {{*from, *to}};
  }
  const auto height = [&](int i, int of, const Triple& n) { return dot(subtract(at(i), at(of)), n) / norm(n); };
  if (std::all_of(all.begin(), all.end(), [&](int i) { return std::abs(height(i, first, normal)) <= tolerance; })) {
    return {polygon(points, all, normal, tolerance)};
  }
  std::vector<std::vector<int>> found;
  if (all.size() > kMostForFaces) {
    for (std::size_t i = 1; i < all.size(); ++i) found.push_back({first, all[i]});
    return found;
  }
  std::set<std::vector<int>> seen;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      for (std::size_t k = j + 1; k < all.size(); ++k) {
        const Triple n = cross(subtract(at(all[j]), at(all[i])), subtract(at(all[k]), at(all[i])));
        if (norm(n) <= tolerance * size) continue;
        std::vector<int> in_plane;
        bool above = false, below = false;
        for (const int p : all) {
          const double h = height(p, all[i], n);
          if (std::abs(h) <= tolerance) in_plane.push_back(p);
          above = above || h > tolerance;
          below = below || h < -tolerance;
        }
        if ((above && below) || !seen.insert(in_plane).second) continue;
        found.push_back(polygon(points, in_plane, n, tolerance));
      }
    }
  }
  return found;
}

}  // namespace assur::pictures
