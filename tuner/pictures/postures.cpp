#include "pictures/postures.hpp"

#include <algorithm>

#include "index.hpp"
#include "numbers.hpp"
#include "scene/triple.hpp"

namespace assur::pictures {
namespace {

constexpr double kReturns = 0.03, kLeaves = 0.05;  // distances, relative to the size: the motion is back, or away

Triple unit(const Triple& v) {
  const double size = triple::norm(v);
  return size > 0 ? triple::scale(1 / size, v) : Triple{1, 0, 0};
}

}  // namespace

bool is_slider(const Drawing::Joint& j) {
  return (j.symbol == Drawing::Symbol::prismatic || j.symbol == Drawing::Symbol::cylindrical) && !j.axes.empty();
}

bool Postures::rests(const Drawing::Axis& axis) const {
  return axis.direction >= 0 ? drawing->directions[idx(axis.direction)].fixed : rests(axis.from) && rests(axis.to);
}

Triple Postures::place(std::size_t frame, int point) const {
  if (rests(point)) return drawing->points[idx(point)].at;
  const auto dimension = static_cast<std::size_t>(drawing->dimension);
  Triple at{};
  for (std::size_t k = 0; k < dimension; ++k) at[k] = places[(frame * drawing->moving + idx(point)) * dimension + k];
  return at;
}

Triple Postures::way(std::size_t frame, const Drawing::Axis& axis) const {
  if (axis.direction < 0) return unit(triple::subtract(place(frame, axis.to), place(frame, axis.from)));
  const Drawing::Direction& d = drawing->directions[idx(axis.direction)];
  if (d.fixed) return unit(d.at);
  const auto dimension = static_cast<std::size_t>(drawing->dimension);
  std::size_t column = 0, moving = 0;
  for (const Drawing::Direction& other : drawing->directions) {
    if (other.fixed) continue;
    if (&other < &d) ++column;
    ++moving;
  }
  Triple at{};
  for (std::size_t k = 0; k < dimension; ++k) at[k] = ways[(frame * moving + column) * dimension + k];
  return unit(at);
}

Triple Postures::origin(const Drawing::Joint& slider, std::size_t frame) const {
  return slider.origin < 0 ? place(0, slider.point) : place(frame, slider.origin);
}

std::array<Triple, 2> Postures::rail(const Drawing::Joint& slider, std::size_t frame, std::size_t last,
                                     double more) const {
  double low = kInfinity, high = -kInfinity;
  for (std::size_t f = 0; f <= last; f += last / 200 + 1) {
    const Triple off = triple::subtract(place(f, slider.point), origin(slider, f));
    const double along = triple::dot(off, way(f, slider.axes[0]));
    low = std::min(low, along), high = std::max(high, along);
  }
  more += 0.12 * (high - low);
  const Triple from = origin(slider, frame), axis = way(frame, slider.axes[0]);
  return {triple::add(from, triple::scale(low - more, axis)), triple::add(from, triple::scale(high + more, axis))};
}

// The largest distance between the places of two frames, m.
double Postures::apart(std::size_t one, std::size_t other) const {
  double most = 0;
  for (std::size_t i = 0; i < drawing->moving; ++i) {
    const int point = static_cast<int>(i);
    most = std::max<double>(most, triple::norm(triple::subtract(place(one, point), place(other, point))));
  }
  return most;
}

std::size_t Postures::period() const {
  double size = 0;
  for (std::size_t f = 0; f < frames(); ++f) size = std::max(size, apart(f, 0));
  bool away = false;
  for (std::size_t f = 2; f < frames(); ++f) {
    const double off = apart(f, 0);
    away = away || off > kLeaves * size;
    if (!away || off > kReturns * size) continue;
    const std::size_t next = std::min(f + 1, frames() - 1);
    if (next > f && apart(next, 0) < off) continue;   // still on its way back
    if (apart(next, 1) <= apart(f - 1, 1)) return f;  // not the other way
  }
  return 0;
}

}  // namespace assur::pictures
