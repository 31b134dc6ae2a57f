// Elements of SVG that move.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "pictures/postures.hpp"
#include "pictures/view.hpp"

namespace assur::pictures {

// Colours of the picture.
inline constexpr std::string_view kInk = "#1b1f24", kPaper = "#f7f8fa", kFaint = "#7a8490",
                                  kMotor = "#ffb300";  // fills driven joints

// Tenths of a pixel: "12.3", "12", "1,2", "1,2 3,4".
[[nodiscard]] std::string pixels(double x);
[[nodiscard]] std::string pixels(const Pixel& p);
[[nodiscard]] std::string pixels(const std::vector<Pixel>& points);
[[nodiscard]] Pixel between(const Pixel& p, const Pixel& q, double share);
[[nodiscard]] double distance(const Pixel& p, const Pixel& q);

class MovingSvg {
 public:
  // frames: in the order in which they are shown; they take `seconds` and are repeated.
  MovingSvg(const Postures& postures, const View& view, std::vector<std::size_t> frames, double seconds)
      : postures_(postures), view_(view), frames_(std::move(frames)), seconds_(seconds) {}

  [[nodiscard]] const Postures& postures() const { return postures_; }
  [[nodiscard]] const View& view() const { return view_; }
  [[nodiscard]] Pixel at(std::size_t frame, int point) const { return view_.at(postures_.place(frame, point)); }
  [[nodiscard]] const std::string& text() const { return text_; }

  // Text that does not move.
  void add(std::string_view text) { text_ += text; }
  // <tag attribute="..." more>, where the attribute has a value for each frame.
  void element(std::string_view tag, std::string_view attribute, const std::function<std::string(std::size_t)>& value,
               std::string_view more);
  // Elements around a point, which is their origin.
  void around(int point, std::string_view elements);
  // A line with a margin, so that crossing bars are seen one before the other. ends: two places in each frame.
  void bar(const std::function<std::vector<Pixel>(std::size_t)>& ends, std::string_view colour, double width);

 private:
  [[nodiscard]] std::string timing(const std::vector<std::string>& values) const;

  const Postures& postures_;
  const View& view_;
  std::vector<std::size_t> frames_;
  double seconds_;
  std::string text_;
  int bars_ = 0;
};

// A line with hatching of this size on its right, seen along it.
[[nodiscard]] std::string hatched(const Pixel& p, const Pixel& q, double size);

// The symbol of a joint, of this size in pixels: a ring or a cylinder, a block, a ball, a cross, a plate; on the ground
// with a hatched triangle.
void draw_joint(MovingSvg& svg, const Drawing::Joint& joint, double size);

}  // namespace assur::pictures
