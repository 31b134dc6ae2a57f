// Mobility and redundancy of random mechanisms of joints, compared with the rank of their screws, in several orders of
// names: the order of bodies and joints, and of the two bodies of a joint, changes nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "assur/assur.hpp"
#include "lettered_joint.hpp"
#include "properties/random_count.hpp"
#include "scene/triple.hpp"
#include "start/redundant_sets.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

using triple::cross;
using triple::scale;

struct Link {
  char letter;  // R, P, C, S, U, E (planar)
  std::size_t a, b;
  Triple at{}, axis{};
};
using Row = std::vector<double>;

Triple unit(const Triple& a) { return scale(1 / triple::norm(a), a); }
Triple across(const Triple& a) {
  const Triple x = cross(a, {1, 0, 0}), y = cross(a, {0, 1, 0});
  return unit(triple::norm(x) > triple::norm(y) ? x : y);
}

std::size_t rank_of(std::vector<Row> rows) {
  std::size_t rank = 0;
  const std::size_t columns = rows.empty() ? 0 : rows[0].size();
  for (std::vector<bool> used(columns, false); rank < rows.size(); ++rank) {
    double most = 1e-9;  // entries have sizes up to 10, and real pivots are far larger
    std::size_t row = rank, column = columns;
    for (std::size_t i = rank; i < rows.size(); ++i) {
      for (std::size_t c = 0; c < columns; ++c) {
        if (!used[c] && std::abs(rows[i][c]) > most) most = std::abs(rows[i][c]), row = i, column = c;
      }
    }
    if (column == columns) break;
    std::swap(rows[rank], rows[row]);
    used[column] = true;
    for (std::size_t i = rank + 1; i < rows.size(); ++i) {
      const double share = rows[i][column] / rows[rank][column];
      for (std::size_t c = 0; c < columns; ++c) rows[i][c] -= share * rows[rank][c];
    }
  }
  return rank;
}

// The forces (at the origin: moment, force) that a joint transmits, as vectors that its motions do no work against.
std::vector<std::array<Triple, 2>> forces(const Link& j) {
  const Triple u = unit(j.axis), x = across(u), y = cross(u, x);
  std::vector<std::array<Triple, 2>> out;
  const auto force = [&](const Triple& f) { out.push_back({cross(j.at, f), f}); };
  const auto moment = [&](const Triple& m) { out.push_back({m, {0, 0, 0}}); };
  const std::string letter(1, j.letter);
  if (letter == "R" || letter == "S" || letter == "U") force(u), force(x), force(y);
  if (letter == "P" || letter == "C") force(x), force(y);
  if (letter == "E") force(u);
  if (letter == "R" || letter == "C" || letter == "E" || letter == "P") moment(x), moment(y);
  if (letter == "P") moment(u);
  if (letter == "U") moment(y);  // across both axes, u and x
  return out;
}

class Mechanism {
 public:
  explicit Mechanism(unsigned seed) : random_(seed) {}

  std::size_t below(std::size_t n) { return random_() % n; }
  double digit() { return (static_cast<double>(below(21)) - 10) / 10; }
  Triple spot() {
    const double x = digit(), y = digit(), z = digit();
    return {x, y, z};
  }
  Triple direction() {
    for (;;) {
      const Triple v = spot();
      if (triple::norm(v) > 0.3) return v;
    }
  }
  std::size_t body() {
    Triple p[3] = {spot(), spot(), spot()};
    if (triple::norm(cross(triple::subtract(p[1], p[0]), triple::subtract(p[2], p[0]))) < 0.05) {
      p[0] = {0, 0, 0}, p[1] = {1, 0, 0}, p[2] = {0, 1, 0};
    }
    points_.push_back({p[0], p[1], p[2]});
    return points_.size();
  }
  void connect(char letter, std::size_t a, std::size_t b, const Triple& at, const Triple& axis) {
    if (a != b) links_.push_back({letter, a, b, at, axis});
  }
  [[nodiscard]] std::size_t bodies() const { return points_.size(); }

  struct Freedoms {
    std::size_t mobility, redundant;
  };
  [[nodiscard]] Freedoms freedoms() const {
    std::vector<Row> rows;
    for (const Link& j : links_) {
      for (const auto& force : forces(j)) {
        Row row(6 * bodies(), 0.0);
        for (const auto& [body, sign] : {std::pair(j.a, -1.0), std::pair(j.b, 1.0)}) {
          for (std::size_t k = 0; body > 0 && k < 6; ++k) row[6 * (body - 1) + k] += sign * force[k / 3][k % 3];
        }
        rows.push_back(std::move(row));
      }
    }
    const std::size_t rank = rank_of(rows);
    return {6 * bodies() - rank, rows.size() - rank};
  }

  // order > 0: another order of names.
  Scene scene(int order) {
    std::vector<std::size_t> bodies(points_.size()), joints(links_.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i] = i + 1;
    for (std::size_t i = 0; i < joints.size(); ++i) joints[i] = i;
    if (order > 0) {
      std::shuffle(bodies.begin(), bodies.end(), random_);
      std::shuffle(joints.begin(), joints.end(), random_);
    }
    const auto name = [](std::size_t body) { return body == 0 ? "ground" : "b" + std::to_string(body); };
    SceneBuilder b("joints", 3);
    for (const std::size_t i : bodies) {
      Body body{name(i)};
      for (std::size_t k = 0; k < 3; ++k) {
        body.points.push_back({name(i) + "_" + std::to_string(k), points_[i - 1][k], true});
        b.output(body.points.back().name);
      }
      b.add(std::move(body));
    }
    for (const std::size_t i : joints) {
      const Link& j = links_[i];
      const bool swapped = order > 0 && below(2) == 0;
      const Triple u = unit(j.axis), x = across(u);
      test::add(b, {j.letter, "J" + std::to_string(i), name(swapped ? j.b : j.a), name(swapped ? j.a : j.b), j.at,
                    j.letter != 'U' ? j.axis
                    : swapped       ? x
                                    : u,
                    swapped ? u : x});
    }
    return b.time(0, 1, 0.125).build();
  }

 private:
  std::mt19937 random_;
  std::vector<std::array<Triple, 3>> points_;
  std::vector<Link> links_;
};

// Loops of three to five bars whose axes meet in a point (spherical) or are parallel, on a moving body.
Mechanism with_loops(unsigned seed, bool spherical) {
  Mechanism m(seed);
  const std::size_t carrier = m.body();
  const char letter = "RPCSU"[m.below(5)];  // arguments are evaluated in any order
  const Triple at = m.spot(), direction = m.direction();
  m.connect(letter, 0, carrier, at, direction);
  for (std::size_t loop = 1 + m.below(2); loop > 0; --loop) {
    const Triple centre = m.below(3) == 0 ? m.spot() : Triple{0, 0, 0}, parallel = m.direction();
    const auto hinge = [&](std::size_t a, std::size_t b) {
      const Triple axis = spherical ? m.direction() : parallel;
      m.connect('R', a, b, spherical ? triple::add(centre, axis) : m.spot(), axis);
    };
    const std::size_t first = 1 + m.below(m.bodies());
    std::size_t last = first;
    for (std::size_t bars = 2 + m.below(3); bars > 0; --bars) {
      const std::size_t next = m.body();
      hinge(last, next);
      last = next;
    }
    hinge(last, first);
  }
  return m;
}

// A tree of joints with further joints between random bodies. Places and axes are often the same.
Mechanism any(unsigned seed) {
  Mechanism m(seed);
  constexpr const char* kLetters = "RRRRPCSUE";
  const Triple axes[3] = {m.direction(), m.direction(), m.direction()}, places[3] = {m.spot(), m.spot(), m.spot()};
  const std::size_t shares = m.below(10);
  const auto axis = [&] { return m.below(10) < shares ? axes[m.below(3)] : m.direction(); };
  const auto place = [&] { return m.below(10) < shares ? places[m.below(3)] : m.spot(); };
  for (std::size_t n = 1 + m.below(5), i = 1; i <= n; ++i) {
    const std::size_t before = m.below(i), body = m.body();
    const char letter = kLetters[m.below(9)];  // arguments are evaluated in any order
    const Triple at = place(), along = axis();
    m.connect(letter, before, body, at, along);
  }
  for (std::size_t more = 1 + m.below(3); more > 0; --more) {
    const std::size_t a = m.below(m.bodies() + 1), b = m.below(m.bodies() + 1);
    const char letter = kLetters[m.below(9)];
    const Triple at = place(), along = axis();
    m.connect(letter, a, b, at, along);
  }
  return m;
}

void expect_freedoms(Mechanism m, bool count_redundant) {
  const Mechanism::Freedoms wanted = m.freedoms();  // in the posture as written, which may be singular
  std::int64_t mobility = 0;
  for (int order = 0; order < 3; ++order) {
    const GroupedSystem s = group_equations(m.scene(order));
    EXPECT_EQ(s.cannot_assemble, "") << order;
    EXPECT_EQ(s.mobility_at_start, static_cast<std::int64_t>(wanted.mobility)) << order;
    if (order == 0) mobility = s.mobility;
    EXPECT_EQ(s.mobility, mobility) << order;
    if (count_redundant) {
      EXPECT_EQ(s.redundant.size(), wanted.redundant) << order;
    }
  }
}

TEST(JointMobility, OfSphericalLoopsOnAMovingBody) {
  for (int seed = 0; seed < test::random_count(240); ++seed) {
    SCOPED_TRACE(seed);
    expect_freedoms(with_loops(static_cast<unsigned>(seed), true), true);
  }
}

TEST(JointMobility, OfPlanarLoopsOnAMovingBody) {
  for (int seed = 0; seed < test::random_count(240); ++seed) {
    SCOPED_TRACE(seed);
    expect_freedoms(with_loops(static_cast<unsigned>(seed), false), true);
  }
}

// All coefficients of an equation cancel, and its constant is only rounding.
TEST(JointMobility, OfAPlanarLoopAlongACoordinateAxis) { expect_freedoms(with_loops(744, false), true); }

TEST(JointMobility, DoesNotDependOnTheOrderOfNames) {
  for (int seed = 0; seed < test::random_count(800); ++seed) {
    SCOPED_TRACE(seed);
    expect_freedoms(any(static_cast<unsigned>(seed)), false);
  }
}

}  // namespace
}  // namespace assur
