// A parallel projection of metres to pixels.
#pragma once

#include <array>
#include <vector>

#include "assur/scene.hpp"

namespace assur::pictures {

using Pixel = std::array<double, 2>;  // to the right, downwards

class View {
 public:
  // Shows these places, in the plane from above, in space from a direction in which they are spread well. The picture
  // has this width and a height of its own, pixels.
  View(int dimension, const std::vector<Triple>& seen, double width);

  [[nodiscard]] double height() const { return height_; }
  [[nodiscard]] double zoom() const { return zoom_; }  // pixels for each metre
  [[nodiscard]] Pixel at(const Triple& place) const;
  // A vector to the right, upwards and to the eye.
  [[nodiscard]] Triple turned(const Triple& vector) const;
  [[nodiscard]] double depth(const Triple& place) const { return turned(place)[2]; }  // larger: nearer to the eye

 private:
  void turn_to(double yaw, double pitch);
  [[nodiscard]] double spread(const std::vector<Triple>& seen) const;

  Triple right_{1, 0, 0}, up_{0, 1, 0}, eye_{0, 0, 1};
  double zoom_ = 1, x_ = 0, y_ = 0, height_ = 0;
};

}  // namespace assur::pictures
