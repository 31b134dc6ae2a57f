// Random trees of dyads and triads, written with joints: their groups, and their motion against closed forms. The
// names, the order of all parts and the order of the bodies of a joint are random.
#include <gtest/gtest.h>

#include "simulation/random_count.hpp"
#include "simulation/random_joints.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

using references::dot;
using references::operator+;
using references::operator-;
using references::operator*;
using test::Draw;
using test::exact;
using test::Frame;
using test::JointMechanism;
using test::length_of;
using test::Place3;
using test::Real;

using Frames = JointMechanism::Frames;

Real area(const Place3& a, const Place3& b) { return a[0] * b[1] - a[1] * b[0]; }
Place3 left(const Place3& a) { return {-a[1], a[0], Real{}}; }
double number(const Real& a) { return static_cast<double>(a.value); }

// The rotation with this cosine and sine.
Frame turned(const Real& c, const Real& s) {
  Frame f;
  f.x = {c, s, Real{}}, f.y = {-s, c, Real{}};
  return f;
}
// The rotation that takes d to the direction of D.
Frame aligned(const Place3& d, const Place3& D) {
  const Real n = length_of(d) * length_of(D);
  return turned(dot(d, D) / n, area(d, D) / n);
}
// The body whose points p and q are at P and Q.
Frame through(const Triple& p, const Place3& P, const Triple& q, const Place3& Q) {
  Frame f = aligned(exact(q) - exact(p), Q - P);
  f.put(exact(p), P);
  return f;
}
Real sign_of(const Real& a) { return Real{a.value < 0 ? -1.0L : 1.0L}; }

// ---- drivers

void add_crank(JointMechanism& m, std::size_t on) {
  const Triple at = m.spot();
  const std::size_t b = m.body(), j = m.connect('R', on, b, at), q = m.curve(m.angle());
  m.drive(j, b, true, q);
  m.keep(
      [&m, on, b, at, q](long double t, Frames& f) {
        f[b] = f[on].after(test::turned(at, {0, 0, 1}, m.value(q, t)));
        return 1.0;
      },
      0);
}

void add_slider(JointMechanism& m, std::size_t on) {
  const Triple at = m.spot(), axis = m.direction();
  const std::size_t b = m.body(), j = m.connect('P', on, b, at, axis), q = m.curve(m.shift());
  m.drive(j, b, false, q);
  m.keep(
      [&m, on, b, axis, q](long double t, Frames& f) {
        f[b] = f[on].after(test::moved(axis, m.value(q, t)));
        return 1.0;
      },
      0);
}

// ---- dyads: links K on body a and L on body b; the letters are those of the joints a-K, K-L, L-b

bool add_rrr(JointMechanism& m, std::size_t a, std::size_t b) {
  const Triple P = m.spot(), C = m.spot(), Q = m.spot();
  const std::size_t K = m.body(), L = m.body();
  m.connect('R', a, K, P), m.connect('R', K, L, C), m.connect('R', L, b, Q);
  return m.keep(
      [=](long double, Frames& f) {
        const Place3 p = f[a].at(P), q = f[b].at(Q), d = q - p;
        const Real k = length_of(exact(C) - exact(P)), l = length_of(exact(C) - exact(Q)), square = dot(d, d);
        const Real along = (square + k * k - l * l) / (2 * square), high = k * k / square - along * along;
        const Real side = sign_of(area(exact(Q) - exact(P), exact(C) - exact(P)));
        if (!(high.value > 0)) return 0.0;
        const Place3 c = p + along * d + (side * sqrt(high)) * left(d);
        f[K] = through(P, p, C, c), f[L] = through(Q, q, C, c);
        return std::abs(number(area(c - p, c - q) / (k * l)));
      },
      0.3);
}

bool add_rrp(JointMechanism& m, std::size_t a, std::size_t b) {
  const Triple P = m.spot(), C = m.spot(), axis = m.direction();
  const std::size_t K = m.body(), L = m.body();
  m.connect('R', a, K, P), m.connect('R', K, L, C), m.connect('P', L, b, m.spot(), axis);
  return m.keep(
      [=](long double, Frames& f) {
        const Place3 p = f[a].at(P), d = f[b].at(C) - p, u = f[b].turn(references::unit(exact(axis)));
        const Real k = length_of(exact(C) - exact(P)), along = dot(d, u), inside = along * along - dot(d, d) + k * k;
        if (!(inside.value > 0)) return 0.0;
        const Real side = sign_of(dot(exact(C) - exact(P), exact(axis)));
        const Place3 way = (side * sqrt(inside) - along) * u;
        f[L] = f[b];
        f[L].o = f[b].o + way;
        f[K] = through(P, p, C, f[L].at(C));
        return std::abs(number(dot(f[L].at(C) - p, u) / k));
      },
      0.3);
}

bool add_rpr(JointMechanism& m, std::size_t a, std::size_t b) {
  const Triple P = m.spot(), Q = m.spot(), axis = m.direction();
  const std::size_t K = m.body(), L = m.body();
  m.connect('R', a, K, P), m.connect('P', K, L, m.spot(), axis), m.connect('R', L, b, Q);
  return m.keep(
      [=, &m](long double, Frames& f) {
        const Place3 p = f[a].at(P), q = f[b].at(Q), d = q - p;
        const Place3 u = references::unit(exact(axis)), before = exact(Q) - exact(P);
        const Real off = area(u, before), inside = dot(d, d) - off * off;
        if (!(inside.value > 0)) return 0.0;
        const Real along = sign_of(dot(u, before)) * sqrt(inside);
        // The links turn by the angle from along u + off left(u) to d.
        f[K] = f[L] = aligned(along * u + off * left(u), d);
        f[K].put(exact(P), p), f[L].put(exact(Q), q);
        return std::min(std::abs(number(along / length_of(d))), number(length_of(d) / m.size()));
      },
      0.3);
}

bool add_prp(JointMechanism& m, std::size_t a, std::size_t b) {
  const Triple C = m.spot(), first = m.direction(), second = m.direction();
  const std::size_t K = m.body(), L = m.body();
  m.connect('P', a, K, m.spot(), first), m.connect('R', K, L, C), m.connect('P', L, b, m.spot(), second);
  return m.keep(
      [=](long double, Frames& f) {
        const Place3 u = f[a].turn(references::unit(exact(first))), v = f[b].turn(references::unit(exact(second)));
        const Real sine = area(u, v);
        const Place3 c = f[a].at(C) + (area(f[b].at(C) - f[a].at(C), v) / sine) * u;
        f[K] = f[a], f[L] = f[b];
        f[K].put(exact(C), c), f[L].put(exact(C), c);
        return std::abs(number(sine));
      },
      0.3);
}

bool add_rpp(JointMechanism& m, std::size_t a, std::size_t b) {
  const Triple P = m.spot(), first = m.direction(), second = m.direction();
  const std::size_t K = m.body(), L = m.body();
  m.connect('R', a, K, P), m.connect('P', K, L, m.spot(), first), m.connect('P', L, b, m.spot(), second);
  return m.keep(
      [=](long double, Frames& f) {
        const Place3 v = f[b].turn(references::unit(exact(first))), u = f[b].turn(references::unit(exact(second)));
        f[K] = f[L] = f[b];
        f[K].put(exact(P), f[a].at(P));
        const Real sine = area(v, u);
        f[L].o = f[b].o + (area(f[b].o - f[K].o, v) / sine) * u;
        return std::abs(number(sine));
      },
      0.3);
}

// ---- triads: a body T on three links, each on a body of `on`

using Three = std::array<std::size_t, 3>;

// cos and sin with c alpha + s beta = gamma, on the branch of c = 1, s = 0 as written. Returns the sine of the angle
// between the lines that touch.
double solve_angle(const Real& alpha, const Real& beta, const Real& gamma, bool beta_was_positive, Real& c, Real& s) {
  const Real square = alpha * alpha + beta * beta, inside = square - gamma * gamma;
  if (!(inside.value > 0)) return 0;
  const Real root = (beta_was_positive ? Real{1} : Real{-1}) * sqrt(inside);
  c = (alpha * gamma + beta * root) / square, s = (beta * gamma - alpha * root) / square;
  return std::abs(number(root / sqrt(square)));
}

// Points of T slide on lines of the bodies, or lines of T on points of the bodies. Both are linear in the position and
// in the cosine and sine of T.
bool add_sliding_triad(JointMechanism& m, const Three& on, bool lines_on_triangle) {
  std::array<Triple, 3> P, axis;
  for (std::size_t i = 0; i < 3; ++i) P[i] = m.spot(), axis[i] = m.direction();
  const std::size_t T = m.body();
  Three K{};
  for (std::size_t i = 0; i < 3; ++i) {
    K[i] = m.body();
    m.connect(lines_on_triangle ? 'R' : 'P', on[i], K[i], P[i], axis[i]);
    m.connect(lines_on_triangle ? 'P' : 'R', K[i], T, P[i], axis[i]);
  }
  const Triple centre = P[0];
  return m.keep(
      [=, &m](long double, Frames& f) {
        std::array<Place3, 3> n, at;  // normals of the lines, pins
        std::array<Real, 3> w;
        for (std::size_t i = 0; i < 3; ++i) {
          const Place3 u = references::unit(exact(axis[i]));
          n[i] = left(lines_on_triangle ? u : f[on[i]].turn(u));
          at[i] = f[on[i]].at(P[i]) - exact(centre);
        }
        for (std::size_t i = 0; i < 3; ++i) w[i] = area(n[(i + 1) % 3], n[(i + 2) % 3]);
        Real alpha{}, beta{}, gamma{}, beta0{};
        for (std::size_t i = 0; i < 3; ++i) {
          const Place3 p = exact(P[i]) - exact(centre);
          alpha += w[i] * dot(n[i], lines_on_triangle ? at[i] : p);
          beta += w[i] * dot(n[i], lines_on_triangle ? Real{-1} * left(at[i]) : left(p));
          gamma += w[i] * dot(n[i], lines_on_triangle ? p : at[i]);
        }
        // The root has its sign as written: at c = 1, s = 0 it is -s alpha + c beta.
        {
          std::array<Place3, 3> n0;
          for (std::size_t i = 0; i < 3; ++i) n0[i] = left(references::unit(exact(axis[i])));
          for (std::size_t i = 0; i < 3; ++i) {
            const Place3 p = exact(P[i]) - exact(centre);
            const Real w0 = area(n0[(i + 1) % 3], n0[(i + 2) % 3]);
            beta0 += w0 * dot(n0[i], lines_on_triangle ? Real{-1} * left(p) : left(p));
          }
        }
        Real c{1}, s{};
        const double margin = solve_angle(alpha, beta, gamma, beta0.value > 0, c, s);
        if (margin == 0) return 0.0;
        // n0 . x = h0, n1 . x = h1
        const auto shift = [&](std::size_t i) {
          const Place3 p = exact(P[i]) - exact(centre);
          return lines_on_triangle ? dot(n[i], c * at[i] - s * left(at[i])) - dot(n[i], p)
                                   : dot(n[i], at[i]) - dot(n[i], c * p + s * left(p));
        };
        std::size_t i = 0;
        for (std::size_t k = 1; k < 3; ++k) i = std::abs(w[k].value) > std::abs(w[i].value) ? k : i;
        const std::size_t k = (i + 1) % 3, l = (i + 2) % 3;
        const Real a = shift(k), b = shift(l);
        const Place3 x = {(a * n[l][1] - b * n[k][1]) / w[i], (b * n[k][0] - a * n[l][0]) / w[i], Real{}};
        f[T] = turned(c, s);
        const Place3 o = lines_on_triangle ? f[T].turn(x) : x;
        f[T].put(exact(centre), exact(centre) + o);
        for (std::size_t j = 0; j < 3; ++j) {
          f[K[j]] = lines_on_triangle ? f[T] : f[on[j]];
          f[K[j]].put(exact(P[j]), lines_on_triangle ? f[on[j]].at(P[j]) : f[T].at(P[j]));
        }
        const double size = number(sqrt(alpha * alpha + beta * beta)) / m.size();
        return std::min({margin, size, std::abs(number(w[i]))});
      },
      0.3);
}

// Two equal bars on one body keep T parallel to it; the third bar leads to another body.
bool add_parallelogram(JointMechanism& m, std::size_t a, std::size_t b) {
  const Triple A = m.spot(), B = m.spot(), P = m.spot(), C = m.spot(), Q = m.spot();
  const Triple bar = triple::subtract(P, A);
  const std::size_t T = m.body(), K = m.body(), L = m.body(), N = m.body();
  m.connect('R', a, K, A), m.connect('R', K, T, P);
  m.connect('R', a, L, B), m.connect('R', L, T, triple::add(B, bar));
  m.connect('R', b, N, Q), m.connect('R', N, T, C);
  return m.keep(
      [=](long double, Frames& f) {
        const Place3 p = f[a].at(A), q = f[b].at(Q) - f[a].turn(exact(C) - exact(P)), d = q - p;
        const Real k = length_of(exact(P) - exact(A)), l = length_of(exact(C) - exact(Q)), square = dot(d, d);
        const Real along = (square + k * k - l * l) / (2 * square), high = k * k / square - along * along;
        if (!(high.value > 0)) return 0.0;
        const Place3 d0 = exact(Q) - exact(C) + exact(P) - exact(A);
        const Real side = sign_of(area(d0, exact(P) - exact(A)));
        const Place3 c = p + along * d + (side * sqrt(high)) * left(d), way = c - p;
        f[T] = f[a];
        f[T].put(exact(P), c);
        f[K] = f[L] = aligned(exact(bar), way);
        f[K].put(exact(A), p), f[L].put(exact(B), f[a].at(B));
        f[N] = through(Q, f[b].at(Q), C, f[T].at(C));
        const Place3 base = f[a].turn(exact(B) - exact(A));
        return std::min(std::abs(number(area(c - p, c - q) / (k * l))),
                        std::abs(number(area(base, way) / (length_of(base) * k))));
      },
      0.3);
}

// T moves as chosen; the lengths of three legs follow (3-RPR).
bool add_driven_triad(JointMechanism& m, const Three& on) {
  std::array<Triple, 3> P, A;
  for (std::size_t i = 0; i < 3; ++i) P[i] = m.spot(), A[i] = m.spot();
  const std::size_t T = m.body();
  const std::array q = {m.curve(m.shift()), m.curve(m.shift()), m.curve(m.swinging(0.4))};
  Three K{}, L{};
  for (std::size_t i = 0; i < 3; ++i) {
    K[i] = m.body(), L[i] = m.body();
    m.connect('R', on[i], K[i], A[i]);
    m.follow(m.connect('P', K[i], L[i], A[i], triple::subtract(P[i], A[i])));
    m.connect('R', L[i], T, P[i]);
  }
  return m.keep(
      [=, &m](long double t, Frames& f) {
        f[T] = test::turned(P[0], {0, 0, 1}, m.value(q[2], t));
        f[T].o = f[T].o + Place3{m.value(q[0], t), m.value(q[1], t), Real{}};
        Triple lines[3];
        double shortest = 1;
        for (std::size_t i = 0; i < 3; ++i) {
          const Place3 a = f[on[i]].at(A[i]), p = f[T].at(P[i]), d = p - a;
          f[K[i]] = f[L[i]] = aligned(exact(P[i]) - exact(A[i]), d);
          f[K[i]].put(exact(A[i]), a), f[L[i]].put(exact(P[i]), p);
          const Place3 u = references::unit(d);
          lines[i] = {number(u[0]), number(u[1]), number(area(p - f[T].at(P[0]), u)) / m.size()};
          shortest = std::min(shortest, number(length_of(d)) / m.size());
        }
        return std::min(shortest, std::abs(triple::dot(lines[0], triple::cross(lines[1], lines[2]))));
      },
      0.25);
}

const TimeGrid kGrid{0, 1, 1.0 / 200};

struct Tree {
  std::shared_ptr<JointMechanism> mechanism;
  std::vector<std::string> kinds;  // of units
  bool regular = false;
};

Tree random_tree(Draw& draw) {
  Tree tree{std::make_shared<JointMechanism>(draw, 2), {}};
  JointMechanism& m = *tree.mechanism;
  const auto earlier = [&] { return draw.below(m.solids()); };
  const auto moving = [&] { return 1 + draw.below(m.solids() - 1); };
  for (std::size_t i = 0, drivers = 1 + draw.below(3); i < drivers; ++i) {
    const std::size_t on = draw.below(3) == 0 ? earlier() : 0;
    const bool turns = i == 0 || draw.below(3) > 0;
    if (turns) {
      add_crank(m, on);
    } else {
      add_slider(m, on);
    }
    tree.kinds.emplace_back(turns ? "crank" : "slider");
  }
  for (std::size_t i = 0, units = 1 + draw.below(4); i < units;) {
    const std::size_t a = moving();
    std::size_t b = earlier();
    while (a == b) b = earlier();
    const bool swap = draw.maybe();
    const std::size_t c = swap ? b : a, d = swap ? a : b;
    const Three on = {a, b, earlier()};
    using Unit = std::pair<std::string, std::function<bool()>>;
    const std::vector<Unit> all = {{"RRR", [&] { return add_rrr(m, c, d); }},
                                   {"RRP", [&] { return add_rrp(m, c, d); }},
                                   {"RPR", [&] { return add_rpr(m, c, d); }},
                                   {"PRP", [&] { return add_prp(m, c, d); }},
                                   {"RPP", [&] { return add_rpp(m, c, d); }},
                                   {"pins on lines", [&] { return add_sliding_triad(m, on, false); }},
                                   {"lines on pins", [&] { return add_sliding_triad(m, on, true); }},
                                   {"parallelogram", [&] { return add_parallelogram(m, c, d); }},
                                   {"3-RPR", [&] { return add_driven_triad(m, on); }}};
    const auto& [name, add] = draw.of(all);
    if (!add()) continue;
    tree.kinds.push_back(name);
    ++i;
  }
  tree.regular = m.calm(0.15, kGrid);
  return tree;
}

TEST(RandomJoints, TreesInThePlaneMoveInClosedForm) {
  const int all = test::random_count(100);
  int found = 0;
  for (std::uint64_t seed = 1; found < all; ++seed) {
    Draw draw(seed);
    const Tree tree = random_tree(draw);
    if (!tree.regular) continue;
    ++found;
    std::string kinds;
    for (const std::string& k : tree.kinds) kinds += " " + k;
    SCOPED_TRACE("seed " + std::to_string(seed) + ":" + kinds);
    try {
      const Scene scene = tree.mechanism->write(kGrid);
      const GroupedSystem s = group_equations(scene.with_outputs({"all"}));
      EXPECT_EQ(s.cannot_assemble, "");
      EXPECT_TRUE(s.undetermined.empty());
      for (const Redundancy& r : s.redundant) ADD_FAILURE() << "not redundant: " << r.dropped;
      EXPECT_TRUE(s.redundant.empty());
      const std::vector<int> groups = tree.mechanism->groups_of_units(s);
      for (std::size_t u = 0; u < groups.size(); ++u) {
        // A slider's coordinates have no equations in common; the first link of RPP turns with the second body.
        const std::string& kind = tree.kinds[u];
        const bool driver = kind == "crank" || kind == "slider";
        EXPECT_GE(groups[u], driver ? 0 : 1) << kind << ' ' << u;
        EXPECT_LE(groups[u], kind == "slider" || kind == "RPP" ? 2 : 1) << kind << ' ' << u;
      }
      tree.mechanism->expect_motion(scene);
      (void)test::expect_same_by_code(scene, seed % 2 != 0 ? "irreducible/lanes" : "irreducible/lanes:4");
    } catch (const std::exception& e) {
      ADD_FAILURE() << e.what();
    }
  }
}

}  // namespace
}  // namespace assur
