// Random mechanisms in space, written with joints: bodies on driven joints, platforms that move as chosen, and legs
// between them. The motion of each body follows from products of rotations, from a circle and a sphere, or from one
// equation that is solved here.
#include <gtest/gtest.h>

#include "decompositions.hpp"
#include "simulation/random_count.hpp"
#include "simulation/random_joints.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

using references::cross;
using references::dot;
using references::operator+;
using references::operator-;
using references::operator*;
using test::aligned;
using test::Draw;
using test::exact;
using test::Frame;
using test::JointMechanism;
using test::length_of;
using test::moved;
using test::Place3;
using test::Real;
using test::turned;

using Frames = JointMechanism::Frames;

double number(const Real& a) { return static_cast<double>(a.value); }

Triple square_to(JointMechanism& m, const Triple& axis) {
  for (;;) {
    const Triple other = triple::cross(axis, m.direction());
    if (triple::norm(other) > 0.3 * triple::norm(axis)) return other;
  }
}

// ---- joints as products of motions, in coordinates of the posture as written

struct Step {
  bool turns;
  Triple at, axis;  // axis: a unit vector nearly
  std::size_t curve;
};

Frame motion_of(const JointMechanism& m, const Step& s, long double t) {
  return s.turns ? turned(s.at, s.axis, m.value(s.curve, t)) : moved(s.axis, m.value(s.curve, t));
}

// The freedoms of a joint, from body a to body b.
std::vector<Step> steps_of(JointMechanism& m, char letter, const Triple& at, const Triple& axis, const Triple& second) {
  const auto turn = [&](const Triple& u) { return Step{true, at, u, m.curve(m.swinging(0.5))}; };
  const auto slide = [&](const Triple& u) { return Step{false, at, u, m.curve(m.shift())}; };
  switch (letter) {
    case 'R':
      return {turn(axis)};
    case 'P':
      return {slide(axis)};
    case 'C':
      return {turn(axis), slide(axis)};
    case 'U':
      return {turn(axis), turn(second)};
    case 'S':
      return {turn({1, 0, 0}), turn({0, 1, 0}), turn({0, 0, 1})};
    default: {  // planar
      const Triple u = square_to(m, axis);
      return {slide(u), slide(triple::cross(axis, u)), turn(axis)};
    }
  }
}

// The smallest singular value of the screws of a chain of freedoms, with unit length `size`. Frames: of the body before
// each step.
double regularity(const std::vector<Step>& steps, const std::vector<Frame>& before, const Place3& centre, double size) {
  Eigen::MatrixXd screws(6, static_cast<Eigen::Index>(steps.size()));
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Place3 u = references::unit(before[i].turn(steps[i].axis));
    const Place3 v = steps[i].turns ? cross(before[i].at(steps[i].at) - centre, u) : u;
    const auto column = static_cast<Eigen::Index>(i);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto j = static_cast<std::size_t>(k);
      screws(k, column) = steps[i].turns ? number(u[j]) : 0;
      screws(3 + k, column) = steps[i].turns ? number(v[j]) / size : number(v[j]);
    }
  }
  return screws.jacobiSvd().singularValues().minCoeff();
}

// ---- bodies on driven joints

void add_driven(JointMechanism& m, std::size_t on) {
  static constexpr char kLetters[] = {'R', 'P', 'C'};
  const char letter = kLetters[m.draw().below(3)];
  const Triple at = m.spot(), axis = m.direction();
  const std::size_t b = m.body(), j = m.connect(letter, on, b, at, axis);
  std::vector<Step> steps;
  if (letter != 'P') steps.push_back({true, at, axis, m.curve(m.angle())}), m.drive(j, b, true, steps.back().curve);
  if (letter != 'R') steps.push_back({false, at, axis, m.curve(m.shift())}), m.drive(j, b, false, steps.back().curve);
  m.keep(
      [=, &m](long double t, Frames& f) {
        f[b] = f[on];
        for (const Step& s : steps) f[b] = f[b].after(motion_of(m, s, t));
        return 1.0;
      },
      0);
}

// ---- a platform with a driven pose, at the end of a chain of joints with six freedoms that move as chosen

std::string random_chain(Draw& draw) {
  std::string joints;
  for (int left = 6; left > 0;) {
    static constexpr std::pair<char, int> kFreedoms[] = {{'R', 1}, {'P', 1}, {'C', 2}, {'U', 2}, {'S', 3}, {'E', 3}};
    const auto [letter, freedoms] = kFreedoms[draw.below(6)];
    if (freedoms > left) continue;
    joints += letter;
    left -= freedoms;
  }
  return joints;
}

bool add_chain(JointMechanism& m, std::size_t on, const std::string& joints) {
  std::vector<Step> steps;
  std::vector<std::size_t> bodies;  // after each step
  std::size_t last = on;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const std::size_t next = i + 1 < joints.size() ? m.body() : m.platform();
    const Triple at = m.spot(), axis = m.direction(), second = square_to(m, axis);
    m.connect(joints[i], last, next, at, axis, second);
    for (const Step& s : steps_of(m, joints[i], at, axis, second)) steps.push_back(s), bodies.push_back(next);
    last = next;
  }
  m.drive_pose(last);
  const Triple centre = m.spot();
  return m.keep(
      [=, &m](long double t, Frames& f) {
        Frame end = f[on];
        std::vector<Frame> before;
        for (std::size_t i = 0; i < steps.size(); ++i) {
          before.push_back(end);
          end = f[bodies[i]] = end.after(motion_of(m, steps[i], t));
        }
        // The angles of the driver have no derivatives where the second one is a quarter turn.
        const double level = number(end.z[2] * end.z[2] + end.y[2] * end.y[2]);
        return std::min(level - 0.15, regularity(steps, before, end.at(centre), m.size()));
      },
      0.1);
}

// ---- legs between bodies that move

// A rod from C to Q, as written. At C it has a spherical joint, and may turn about itself, or a universal joint with
// the first axis on another body and the second one on the rod.
struct Rod {
  char joint;
  Triple C, Q, first, second;

  [[nodiscard]] Triple way() const { return triple::subtract(Q, C); }
  // The rotation of the rod whose ends are `now` apart, if the body with the first axis is at `base`. Returns the
  // distance from singular postures.
  double turn(const Frame& base, const Place3& now, Frame& rod) const {
    if (joint == 'S') {
      const Triple x = triple::cross(way(), {1, 0, 0}), y = triple::cross(way(), {0, 1, 0});
      const Triple side = triple::norm(x) > triple::norm(y) ? x : y;
      rod = aligned(way(), side, now, base.turn(side));
      return 1;
    }
    // The second axis is at right angles to the first one, d; its product with the direction of the rod is as written.
    const Place3 d = references::unit(base.turn(first)), n = references::unit(now);
    const Place3 x = n - dot(n, d) * d, y = cross(d, n), e = references::unit(exact(second));
    const Real product = dot(e, references::unit(exact(way()))), square = dot(x, x);
    const Real inside = square - product * product;
    if (!(inside.value > 0)) return 0;
    const bool left = dot(e, cross(exact(first), exact(way()))).value > 0;
    const Real root = (left ? Real{1} : Real{-1}) * sqrt(inside);
    rod = aligned(way(), second, now, (product / square) * x + (root / square) * y);
    return std::abs(number(root));
  }
};

Rod random_rod(JointMechanism& m) {
  const Triple first = m.direction();
  return {m.draw().maybe() ? 'S' : 'U', m.spot(), m.spot(), first, square_to(m, first)};
}

std::size_t rod_body(JointMechanism& m, const Rod& r, double share) {
  return r.joint == 'U' ? m.body() : m.rod(triple::add(r.C, triple::scale(share, r.way())));
}

// A crank or slider on a, and a rod from it to b: a circle or a line, and a sphere.
bool add_rod(JointMechanism& m, std::size_t a, std::size_t b, bool turns) {
  const Triple at = m.spot(), axis = m.direction();
  const Rod rod = random_rod(m);
  const std::size_t K = m.body(), L = rod_body(m, rod, 0.3);
  m.connect(turns ? 'R' : 'P', a, K, at, axis);
  m.connect(rod.joint, K, L, rod.C, rod.first, rod.second), m.connect('S', L, b, rod.Q);
  return m.keep(
      [=, &m](long double, Frames& f) {
        const Place3 u = references::unit(exact(axis)), q0 = exact(rod.Q), c0 = exact(rod.C);
        const Place3 q = f[a].turn_back(f[b].at(rod.Q) - f[a].o);  // in coordinates of a
        const Real square = dot(q0 - c0, q0 - c0);
        double margin = std::sqrt(number(square)) / m.size();
        if (turns) {
          // |d|^2 + |r|^2 - 2 d . r(angle) is the square of the rod.
          const Place3 r = c0 - exact(at), flat = r - dot(r, u) * u, side = cross(u, flat), d = q - exact(at);
          const Real x = dot(d, flat), y = dot(d, side), xy = x * x + y * y;
          const Real g = (dot(d, d) + dot(r, r) - square) / 2 - dot(d, u) * dot(r, u), inside = xy - g * g;
          if (!(inside.value > 0)) return 0.0;
          const bool left = dot(q0 - exact(at), side).value > 0;
          const Real root = (left ? Real{1} : Real{-1}) * sqrt(inside);
          f[K] = f[a].after(turned(at, axis, atan2((y * g - x * root) / xy, (x * g + y * root) / xy)));
          margin = std::min(
              {margin, std::abs(number(root / (length_of(flat) * sqrt(square)))), number(length_of(flat)) / m.size()});
        } else {
          const Place3 d = c0 - q;  // |d + way u|^2 is the square of the rod
          const Real along = dot(d, u), inside = along * along - dot(d, d) + square;
          if (!(inside.value > 0)) return 0.0;
          const Real side = dot(c0 - q0, u).value < 0 ? Real{-1} : Real{1};
          f[K] = f[a].after(moved(axis, side * sqrt(inside) - along));
          margin = std::min(margin, std::abs(number(sqrt(inside / square))));
        }
        const Place3 end = f[b].at(rod.Q);
        const double free = rod.turn(f[K], end - f[K].at(rod.C), f[L]);
        f[L].put(exact(rod.Q), end);
        return std::min(margin, free);
      },
      0.3);
}

// A cylinder K with a rod L in it.
struct Strut {
  Rod rod;
  std::size_t a, b, K, L, slide;

  double place(Frames& f, double size) const {
    const Place3 from = f[a].at(rod.C), to = f[b].at(rod.Q);
    const double free = rod.turn(f[a], to - from, f[K]);
    f[L] = f[K];
    f[K].put(exact(rod.C), from), f[L].put(exact(rod.Q), to);
    return std::min(free, number(length_of(to - from)) / size);
  }
};

Strut strut(JointMechanism& m, std::size_t a, std::size_t b) {
  Strut s{random_rod(m), a, b, 0, 0, 0};
  s.K = rod_body(m, s.rod, 0.2), s.L = rod_body(m, s.rod, 0.7);
  m.connect(s.rod.joint, a, s.K, s.rod.C, s.rod.first, s.rod.second);
  s.slide = m.connect('P', s.K, s.L, s.rod.C, s.rod.way());
  m.connect('S', s.L, b, s.rod.Q);
  return s;
}

bool add_strut(JointMechanism& m, std::size_t a, std::size_t b) {
  const Strut s = strut(m, a, b);
  return m.keep([=, &m](long double, Frames& f) { return s.place(f, m.size()); }, 0.3);
}

// A platform that moves as chosen; the lengths of its six struts follow.
bool add_hexapod(JointMechanism& m, const std::vector<std::size_t>& on) {
  const std::size_t T = m.body();
  const Triple centre = m.spot();
  std::vector<Strut> struts;
  for (const std::size_t a : on) {
    struts.push_back(strut(m, a, T));
    m.follow(struts.back().slide);
  }
  std::vector<Step> steps = steps_of(m, 'S', centre, {}, {});
  for (const Triple& e : {Triple{1, 0, 0}, Triple{0, 1, 0}, Triple{0, 0, 1}}) {
    steps.push_back({false, centre, e, m.curve(m.shift())});
  }
  return m.keep(
      [=, &m](long double t, Frames& f) {
        for (const Step& s : steps) f[T] = f[T].after(motion_of(m, s, t));
        Eigen::MatrixXd lines(6, 6);
        double margin = 1;
        for (std::size_t i = 0; i < 6; ++i) {
          margin = std::min(margin, struts[i].place(f, m.size()));
          const Place3 p = f[T].at(struts[i].rod.Q), u = references::unit(p - f[on[i]].at(struts[i].rod.C));
          const Place3 moment = cross(p - f[T].at(centre), u);
          for (std::size_t k = 0; k < 3; ++k) {
            const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(k);
            lines(row, column) = number(u[k]), lines(row, 3 + column) = number(moment[k]) / m.size();
          }
        }
        return std::min(margin, lines.jacobiSvd().singularValues().minCoeff());
      },
      0.1);
}

// A driven crank K on a, a cylinder L on a ball at its end, and a rocker M on b with the line of the cylinder: RSCR.
// The ball keeps its distance from the line, which is an equation for the angle of the rocker. It is solved by Newton's
// method, in steps from the posture as written.
bool add_rscr(JointMechanism& m, std::size_t a, std::size_t b) {
  constexpr int kSteps = 16, kIterations = 8;
  const Triple foot = m.spot(), axis = m.direction(), ball = m.spot(), on_line = m.spot(), line = m.direction();
  const Triple hinge = m.spot(), hinge_axis = m.direction();
  const std::size_t K = m.body(), L = m.body(), M = m.body();
  const std::size_t crank = m.connect('R', a, K, foot, axis);
  m.connect('S', K, L, ball), m.connect('C', L, M, on_line, line), m.connect('R', M, b, hinge, hinge_axis);
  const Step turn{true, foot, axis, m.curve(m.angle())};
  m.drive(crank, K, true, turn.curve);
  return m.keep(
      [=, &m](long double t, Frames& f) {
        f[K] = f[a].after(motion_of(m, turn, t));
        const Place3 u = references::unit(exact(line)), n = references::unit(exact(hinge_axis));
        const Place3 c = exact(on_line), start = exact(ball), end = f[b].turn_back(f[K].at(ball) - f[b].o);
        const auto across = [&](const Place3& w) { return w - dot(w, u) * u; };
        const Place3 arm = across(start - c);
        double margin = number(length_of(arm)) / m.size();
        Real angle{0}, share{0};
        Place3 p = start;  // the ball, seen from the rocker
        for (int k = 1; k <= kSteps && margin > 0; ++k) {
          const Place3 goal = start + Real{static_cast<long double>(k) / kSteps} * (end - start);
          for (int i = 0; i < kIterations; ++i) {
            p = turned(hinge, hinge_axis, Real{0} - angle).at(goal);
            const Place3 w = across(p - c), way = cross(p - exact(hinge), n);
            const Real slope = dot(w, way);
            angle = angle - (dot(w, w) - dot(arm, arm)) / (2 * slope);
            share = slope / (length_of(w) * length_of(way));
          }
          margin = std::min({margin, std::abs(number(share)), number(length_of(p - exact(hinge))) / m.size()});
          if (!(std::abs(number(dot(p - c, p - c))) < 1e6 * m.size() * m.size())) return 0.0;  // diverged
        }
        p = turned(hinge, hinge_axis, Real{0} - angle).at(end);
        const Place3 w = across(p - c);
        if (!(std::abs(number(dot(w, w) / dot(arm, arm)) - 1) < 1e-12)) return 0.0;
        f[M] = f[b].after(turned(hinge, hinge_axis, angle));
        const Real spin = atan2(dot(cross(u, arm), w), dot(arm, w));
        f[L] = f[M].after(moved(line, dot(p - start, u))).after(turned(on_line, line, spin));
        return margin;
      },
      0.3);
}

const TimeGrid kGrid{0, 1, 1.0 / 100};

struct Tree {
  std::shared_ptr<JointMechanism> mechanism;
  std::string kinds;
  bool regular = false;
};

Tree random_tree(Draw& draw) {
  Tree tree{std::make_shared<JointMechanism>(draw, 3), {}};
  JointMechanism& m = *tree.mechanism;
  const auto earlier = [&] {
    std::size_t s = draw.below(m.solids());
    while (m.solid(s).spins) s = draw.below(m.solids());
    return s;
  };
  const auto other = [&](std::size_t a) {
    std::size_t b = earlier();
    while (b == a) b = earlier();
    return b;
  };
  for (std::size_t i = 0, drivers = 1 + draw.below(3); i < drivers; ++i) add_driven(m, i == 0 ? 0 : earlier());
  for (std::size_t i = 0, units = 1 + draw.below(3); i < units;) {
    const std::size_t a = other(0), b = other(a);
    const bool swap = draw.maybe();
    const std::string chain = random_chain(draw);
    std::vector<std::size_t> on;
    for (int k = 0; k < 6; ++k) on.push_back(earlier());
    std::string kind;
    bool added = false;
    switch (draw.below(6)) {
      case 0:
        kind = "chain " + chain, added = add_chain(m, earlier(), chain);
        break;
      case 1:
      case 2:
        kind = "rod", added = add_rod(m, swap ? b : a, swap ? a : b, draw.maybe());
        break;
      case 3:
        kind = "strut", added = add_strut(m, swap ? b : a, swap ? a : b);
        break;
      case 4:
        kind = "RSCR", added = add_rscr(m, swap ? b : a, swap ? a : b);
        break;
      default:
        kind = "hexapod", added = add_hexapod(m, on);
    }
    if (!added) continue;
    tree.kinds += ", " + kind;
    ++i;
  }
  tree.regular = m.calm(0.05, kGrid);
  return tree;
}

TEST(RandomJoints, ChainsAndLegsInSpaceMoveAsChosen) {
  const int all = test::random_count(40);
  int found = 0, with_rscr = 0;
  for (std::uint64_t seed = 1; found < all; ++seed) {
    Draw draw(seed);
    const Tree tree = random_tree(draw);
    if (!tree.regular) continue;
    ++found;
    with_rscr += tree.kinds.find("RSCR") != std::string::npos ? 1 : 0;
    SCOPED_TRACE("seed " + std::to_string(seed) + tree.kinds);
    try {
      const Scene scene = tree.mechanism->write(kGrid);
      const GroupedSystem s = group_equations(scene.with_outputs({"all"}));
      EXPECT_EQ(s.cannot_assemble, "");
      EXPECT_TRUE(s.undetermined.empty());
      for (const Redundancy& r : s.redundant) ADD_FAILURE() << "not redundant: " << r.dropped;
      (void)tree.mechanism->groups_of_units(s);
      tree.mechanism->expect_motion(scene);
      (void)test::expect_same_by_code(scene, seed % 2 != 0 ? "irreducible/lanes" : "irreducible/lanes:4");
    } catch (const std::exception& e) {
      ADD_FAILURE() << e.what();
    }
  }
  EXPECT_GE(with_rscr, all / 8);
}

}  // namespace
}  // namespace assur
