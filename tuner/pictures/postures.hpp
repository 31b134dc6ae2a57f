// The postures of a drawing over time.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "pictures/drawing.hpp"

namespace assur::pictures {

struct Postures {
  const Drawing* drawing = nullptr;
  std::span<const double> times = {};     // frames, s
  std::span<const double> places = {};    // of moving points, m: frames x moving x dimension
  std::span<const double> ways = {};      // of moving directions: frames x directions x dimension
  std::vector<std::string> outputs = {};  // names whose paths are drawn if they are points; without any, of all points

  [[nodiscard]] std::size_t frames() const { return times.size(); }
  // True if the point never moves.
  [[nodiscard]] bool rests(int point) const { return static_cast<std::size_t>(point) >= drawing->moving; }
  // True if the axis never turns.
  [[nodiscard]] bool rests(const Drawing::Axis& axis) const;
  [[nodiscard]] Triple place(std::size_t frame, int point) const;
  // Of length 1.
  [[nodiscard]] Triple way(std::size_t frame, const Drawing::Axis& axis) const;
  // The first frame in which the mechanism is and moves as in frame 0; 0 if there is none.
  [[nodiscard]] std::size_t period() const;

  // Both ends of the line of a slider, as long as the motion up to frame `last` needs, and `more` metres longer.
  [[nodiscard]] std::array<Triple, 2> rail(const Drawing::Joint& slider, std::size_t frame, std::size_t last,
                                           double more) const;

 private:
  [[nodiscard]] Triple origin(const Drawing::Joint& slider, std::size_t frame) const;
  [[nodiscard]] double apart(std::size_t one, std::size_t other) const;
};

// True if the joint slides along a line.
[[nodiscard]] bool is_slider(const Drawing::Joint& joint);

}  // namespace assur::pictures
