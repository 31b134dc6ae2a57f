#include "pictures/faces.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace assur::pictures {
namespace {

using Edges = std::multiset<std::pair<int, int>>;

Edges edges(const std::vector<std::vector<int>>& faces) {
  Edges all;
  for (const auto& face : faces) {
    for (std::size_t k = 0; k < face.size(); ++k) {
      all.insert(std::minmax(face[k], face[(k + 1) % face.size()]));
    }
  }
  return all;
}

std::vector<Triple> cube(double size) {
  std::vector<Triple> corners;
  for (int i = 0; i < 8; ++i) corners.push_back({size * (i & 1), size * (i >> 1 & 1), size * (i >> 2 & 1)});
  return corners;
}

TEST(Faces, ACubeOfAnySizeHasSixSquares) {
  for (const double size : {1e-6, 1.0, 1e6}) {
    std::vector<Triple> points = cube(size);
    points.push_back({0.5 * size, 0.5 * size, 0.5 * size});  // within
    points.push_back({0.5 * size, 0.5 * size, 0});           // in a face
    points.push_back({0.5 * size, 0, 0});                    // on an edge
    const auto found = faces(points);
    ASSERT_EQ(found.size(), 6u);
    for (const auto& face : found) EXPECT_EQ(face.size(), 4u);
    const Edges all = edges(found);
    EXPECT_EQ(all.size(), 24u);  // 12, each between two faces
    for (const auto& [a, b] : all) {
      EXPECT_EQ(all.count({a, b}), 2u);
      const int bits = a ^ b;
      EXPECT_TRUE(bits == 1 || bits == 2 || bits == 4) << a << "-" << b;  // an edge of the cube
    }
  }
}

TEST(Faces, ATetrahedronHasFourTriangles) {
  const auto found = faces({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 1}});
  ASSERT_EQ(found.size(), 4u);
  for (const auto& face : found) EXPECT_EQ(face.size(), 3u);
}

TEST(Faces, PointsInAPlaneFormOnePolygon) {
  std::vector<Triple> points = {{0, 0, 1}};
  for (const int k : {3, 0, 5, 1, 4, 2}) points.push_back({std::cos(k * M_PI / 3), std::sin(k * M_PI / 3), 1});
  const auto found = faces(points);
  ASSERT_EQ(found.size(), 1u);
  ASSERT_EQ(found[0].size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {  // the side of a regular hexagon is its radius
    const Triple &a = points[static_cast<std::size_t>(found[0][i])],
                 &b = points[static_cast<std::size_t>(found[0][(i + 1) % 6])];
    EXPECT_NEAR(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 1, 1e-15 * 8);
  }
}

TEST(Faces, PointsOnALineFormOneEdge) {
  const auto found = faces({{1, 1, 1}, {3, 3, 3}, {0, 0, 0}, {2, 2, 2}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(edges(found).count({1, 2}), 2u);  // one edge for each side
}

TEST(Faces, CoincidentPointsHaveNone) {
  EXPECT_TRUE(faces({}).empty());
  EXPECT_TRUE(faces({{1, 2, 3}}).empty());
  EXPECT_TRUE(faces({{1, 2, 3}, {1, 2, 3}}).empty());
}

TEST(Faces, LinksManyPointsInSpaceToTheFirst) {
  std::vector<Triple> points;
  for (std::size_t i = 0; i <= kMostForFaces; ++i) {
    const double a = 0.7 * static_cast<double>(i);
    points.push_back({std::cos(a), std::sin(a), std::cos(3 * a)});
  }
  const auto found = faces(points);
  ASSERT_EQ(found.size(), kMostForFaces);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i], (std::vector<int>{0, static_cast<int>(i) + 1}));
}

}  // namespace
}  // namespace assur::pictures
