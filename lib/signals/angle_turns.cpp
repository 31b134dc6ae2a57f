#include "signals/angle_turns.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "index.hpp"
#include "numbers.hpp"
#include "signals/drive_program.hpp"

namespace assur {
namespace {
constexpr double kFirstSteps = 16;  // bound for a path of unknown shape: four times the chord, squared
constexpr double kMostBow = 0.25;   // of a vector, relative to its length: the inverse of a Jacobian may grow
constexpr double kNoise = 1e-12;    // relative to the terms of a vector: a shorter vector has no direction

}  // namespace

double whole_turns(double from, double to) { return std::round((to - from) / kTurn); }

AngleTurns::AngleTurns(const OutputProgram& outputs)
    : outputs_(outputs),
      columns_(outputs.angles()),
      now_(columns_.size()),
      next_(columns_.size()),
      turns_(columns_.size()),
      bows_(columns_.size()) {}

void AngleTurns::start(const double* q) {
  (void)follow(q, 0, 0);
  for (std::size_t i = 0; i < now_.size(); ++i) {
    next_[i].speed = -1;
    now_[i] = next_[i];
    turns_[i] = 0;
  }
}

// True if the way is shorter than half of any way from `from` to `to` round the origin.
bool AngleTurns::is_short(const Arm& from, const Arm& to, double way) {
  if (way <= std::min(from.square, to.square)) return true;
  return 2 * std::sqrt(way) <= std::sqrt(from.square) + std::sqrt(to.square);
}

AngleTurns::Way AngleTurns::follow(const double* q, double seconds, double times) {
  Way found = Way::known;
  for (std::size_t i = 0, count = now_.size(); i < count; ++i) {
    const Arm& now = now_[i];
    Arm& next = next_[i];
    outputs_.arm(i, q, next.x, next.y);
    const double dx = next.x - now.x, dy = next.y - now.y;
    next.square = next.x * next.x + next.y * next.y;
    next.chord = dx * dx + dy * dy;
    const double way = now.speed < 0 ? kFirstSteps * next.chord : std::max(next.chord, now.speed * seconds * seconds);
    const bool is_bent = times * times * bows_[i] > kMostBow * kMostBow * std::min(now.square, next.square);
    if (found == Way::unknown || (is_short(now, next, way) && !is_bent)) continue;
    found = is_noise(i, now, next, q) ? Way::none : Way::unknown;
  }
  return found;
}

void AngleTurns::measure(const double* q, std::span<double* const> probes, std::span<double> scratch,
                         std::size_t lane) {
  std::fill(bows_.begin(), bows_.end(), 0.0);
  for (const double* const probe : probes) {
    for (std::size_t a = lane; a < scratch.size(); ++a) scratch[a] = q[a - lane] + probe[a];
    for (std::size_t i = 0; i < bows_.size(); ++i) {
      double x = 0, y = 0;
      outputs_.arm(i, scratch.data() + lane, x, y);
      bows_[i] += std::hypot(x - now_[i].x, y - now_[i].y);
    }
  }
  for (double& bow : bows_) bow *= bow;
}

bool AngleTurns::is_noise(std::size_t i, const Arm& from, const Arm& to, const double* q) const {
  return std::sqrt(std::max(from.square, to.square)) <= kNoise * outputs_.size_of_arm(i, q);
}

void AngleTurns::accept(double seconds) {
  for (std::size_t i = 0; i < now_.size(); ++i) {
    const Arm& from = now_[i];
    Arm& to = next_[i];
    // The shorter way may cross the half-line where atan2 jumps.
    if (std::signbit(from.y) != std::signbit(to.y)) {
      const double left = from.x * to.y - from.y * to.x;
      if (left > 0 && std::signbit(to.y)) turns_[i] += 1;
      if (left < 0 && std::signbit(from.y)) turns_[i] -= 1;
    }
    to.speed = seconds == 0 ? from.speed : to.chord / (seconds * seconds);
    now_[i] = to;
  }
}

void AngleTurns::continue_from(std::span<const double> row) {
  for (std::size_t i = 0; i < now_.size(); ++i) {
    turns_[i] = whole_turns(std::atan2(now_[i].y, now_[i].x), row[columns_[i]]);
  }
}

void AngleTurns::save(Snapshot& into) const {
  into.arms = now_;
  into.turns = turns_;
  into.bows = bows_;
}

void AngleTurns::restore(const Snapshot& from) {
  now_ = from.arms;
  turns_ = from.turns;
  bows_ = from.bows;
}

int angles_together(const System& s, const Structure& structure) {
  std::size_t laws = 0;
  for (const DriverInput& in : s.inputs) laws += in.laws.size();
  const std::size_t words = (laws + 63) / 64;
  std::vector<std::uint64_t> behind(s.coordinates.size() * words);  // coordinates: a bit for each law
  const auto of = [&](std::int32_t c) { return std::span(behind).subspan(idx(c) * words, words); };
  const auto add = [&](std::int32_t to, std::int32_t from) {
    for (std::size_t w = 0; w < words; ++w) of(to)[w] |= of(from)[w];
  };
  std::size_t law = 0;
  for (const DriverInput& in : s.inputs) {
    for (std::size_t k = 0; k < in.laws.size(); ++k, ++law) {
      if (!is_angle(s, in, static_cast<int>(k))) continue;
      for (Index c = in.first; c < in.first + in.count; ++c) of(c)[law / 64] |= std::uint64_t{1} << (law % 64);
    }
  }
  for (const Assignment& a : s.assignments) {
    for (const Term& t : s.form(a.form)) add(a.coordinate, t.coordinate);
  }
  for (const Group& group : structure.groups) {
    if (group.unknowns.empty()) continue;
    const std::int32_t first = group.unknowns.front();
    for (const std::int32_t c : group.inputs) add(first, c);
    for (const std::int32_t c : group.unknowns) add(c, first);
  }
  int most = 1;
  for (std::size_t c = 0; c < s.coordinates.size(); ++c) {
    int count = 0;
    for (const std::uint64_t word : of(static_cast<std::int32_t>(c))) count += std::popcount(word);
    most = std::max(most, count);
  }
  return most;
}

}  // namespace assur
