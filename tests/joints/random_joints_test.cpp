// Random trees of units, written with joints: their groups, and their motion against plain equations. In the plane the
// units are driven bodies, dyads and triads; in space driven bodies, platforms with driven poses, and closed chains and
// legs between them. The names, the order of all parts and the order of the bodies of a joint are random.
#include <gtest/gtest.h>

#include "joints/random_joints.hpp"
#include "properties/random_count.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

using test::Draw;
using test::JointMechanism;
using Six = std::array<std::size_t, 6>;

// A body on a driven joint.
bool add_driven(JointMechanism& m, std::size_t on, char letter, const std::string& kind) {
  const Triple at = m.spot(), axis = m.direction();
  const std::size_t b = m.body(), j = m.connect(letter, on, b, at, axis);
  if (letter != 'P') m.drive(j, b, true, m.angle());
  if (letter != 'R') m.drive(j, b, false, m.shift());
  return m.keep(kind);
}

// A chain of bodies between body a and body b; the letters are those of its joints.
bool add_chain(JointMechanism& m, std::size_t a, std::size_t b, const std::string& joints, const char* kind = "") {
  std::size_t last = a;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const std::size_t next = i + 1 < joints.size() ? m.body() : b;
    m.connect(joints[i], last, next, m.spot());
    last = next;
  }
  return m.keep(kind + joints);
}

// ---- in the plane: a body T on three links, each on another body

// Points of T slide on lines of the bodies, or lines of T on points of the bodies.
bool add_sliding_triad(JointMechanism& m, const Six& on, bool lines_on_triangle) {
  const std::size_t T = m.body();
  for (std::size_t i = 0; i < 3; ++i) {
    const Triple P = m.spot(), axis = m.direction();
    const std::size_t K = m.body();
    m.connect(lines_on_triangle ? 'R' : 'P', on[i], K, P, axis);
    m.connect(lines_on_triangle ? 'P' : 'R', K, T, P, axis);
  }
  return m.keep(lines_on_triangle ? "lines on pins" : "pins on lines");
}

// Two equal bars on one body keep T parallel to it; the third bar leads to another body.
bool add_parallelogram(JointMechanism& m, std::size_t a, std::size_t b) {
  const Triple A = m.spot(), B = m.spot(), P = m.spot(), bar = triple::subtract(P, A);
  const std::size_t T = m.body(), K = m.body(), L = m.body(), N = m.body();
  m.connect('R', a, K, A), m.connect('R', K, T, P);
  m.connect('R', a, L, B), m.connect('R', L, T, triple::add(B, bar));
  m.connect('R', b, N, m.spot()), m.connect('R', N, T, m.spot());
  return m.keep("parallelogram");
}

// Three driven legs (3-RPR).
bool add_driven_triad(JointMechanism& m, const Six& on) {
  const std::size_t T = m.body();
  for (std::size_t i = 0; i < 3; ++i) {
    const Triple P = m.spot(), A = m.spot();
    const std::size_t K = m.body(), L = m.body();
    m.connect('R', on[i], K, A);
    m.drive(m.connect('P', K, L, A, triple::subtract(P, A)), L, false, m.shift());
    m.connect('R', L, T, P);
  }
  return m.keep("3-RPR");
}

// ---- in space

// Joints with this many freedoms in total.
std::string random_joints(Draw& draw, int freedoms_of_all) {
  std::string joints;
  for (int left = freedoms_of_all; left > 0;) {
    static constexpr std::pair<char, int> kFreedoms[] = {{'R', 1}, {'P', 1}, {'C', 2}, {'U', 2}, {'S', 3}, {'E', 3}};
    const auto [letter, freedoms] = kFreedoms[draw.below(6)];
    if (freedoms > left) continue;
    joints += letter;
    left -= freedoms;
  }
  return joints;
}

// A platform with a driven pose, at the end of a chain of joints with six freedoms.
bool add_platform(JointMechanism& m, std::size_t on) {
  const std::size_t T = m.platform();
  m.drive_pose(T);
  return add_chain(m, on, T, random_joints(m.draw(), 6), "platform ");
}

// A rod from C to Q. At C it has a spherical joint, and may turn about itself, or a universal joint.
struct Rod {
  bool spins;
  Triple C, Q;

  explicit Rod(JointMechanism& m) : spins(m.draw().maybe()), C(m.spot()), Q(m.spot()) {}
  [[nodiscard]] Triple way() const { return triple::subtract(Q, C); }
  // A body of the rod, or of a part of it; its tracer is on the rod at this share of its length if it spins.
  [[nodiscard]] std::size_t body(JointMechanism& m, double share) const {
    return spins ? m.rod(triple::add(C, triple::scale(share, way()))) : m.body();
  }
  void joint_at_C(JointMechanism& m, std::size_t on, std::size_t rod) const {
    const Triple first = spins ? m.square_to(way()) : m.direction();
    m.connect(spins ? 'S' : 'U', on, rod, C, first, spins ? triple::cross(way(), first) : m.square_to(first), spins);
  }
};

// A crank or slider on a, and a rod from it to b.
bool add_rod(JointMechanism& m, std::size_t a, std::size_t b) {
  const Rod rod(m);
  const std::size_t K = m.body(), L = rod.body(m, 0.3);
  m.connect(m.draw().maybe() ? 'R' : 'P', a, K, m.spot());
  rod.joint_at_C(m, K, L), m.connect('S', L, b, rod.Q);
  return m.keep("rod");
}

// A cylinder on a with a rod to b; its displacement may be driven.
void connect_strut(JointMechanism& m, std::size_t a, std::size_t b, bool driven) {
  const Rod rod(m);
  const std::size_t K = rod.body(m, 0.2), L = rod.body(m, 0.7);
  rod.joint_at_C(m, a, K);
  const std::size_t slide = m.connect('P', K, L, rod.C, rod.way());
  m.connect('S', L, b, rod.Q);
  if (driven) m.drive(slide, L, false, m.shift());
}
bool add_strut(JointMechanism& m, std::size_t a, std::size_t b) {
  connect_strut(m, a, b, false);
  return m.keep("strut");
}

bool add_hexapod(JointMechanism& m, const Six& on) {
  const std::size_t T = m.body();
  for (const std::size_t a : on) connect_strut(m, a, T, true);
  return m.keep("hexapod");
}

// A driven crank K on a, a cylinder on a ball at its end, and a rocker on b with the line of the cylinder: RSCR.
bool add_rscr(JointMechanism& m, std::size_t a, std::size_t b) {
  const std::size_t K = m.body();
  m.drive(m.connect('R', a, K, m.spot()), K, true, m.angle());
  return add_chain(m, K, b, "SCR", "crank ");
}

// ---- trees

std::size_t earlier(JointMechanism& m) {
  std::size_t s = m.draw().below(m.solids());
  while (m.solid(s).spins) s = m.draw().below(m.solids());
  return s;
}
std::size_t other(JointMechanism& m, std::size_t a) {
  std::size_t b = earlier(m);
  while (b == a) b = earlier(m);
  return b;
}

void add_units_in_the_plane(JointMechanism& m) {
  for (std::size_t i = 0, drivers = 1 + m.draw().below(3); i < drivers;) {
    const std::size_t on = m.draw().below(3) == 0 ? earlier(m) : 0;
    const bool turns = i == 0 || m.draw().below(3) > 0;
    i += add_driven(m, on, turns ? 'R' : 'P', turns ? "crank" : "slider");
  }
  for (std::size_t i = 0, units = 1 + m.draw().below(4); i < units;) {
    std::size_t a = other(m, 0), b = other(m, a);
    const Six on = {a, b, earlier(m)};
    if (m.draw().maybe()) std::swap(a, b);
    static constexpr const char* kDyads[] = {"RRR", "RRP", "RPR", "PRP", "RPP"};
    const std::size_t kind = m.draw().below(9);
    i += kind < 5    ? add_chain(m, a, b, kDyads[kind])
         : kind == 5 ? add_sliding_triad(m, on, false)
         : kind == 6 ? add_sliding_triad(m, on, true)
         : kind == 7 ? add_parallelogram(m, a, b)
                     : add_driven_triad(m, on);
  }
}

void add_units_in_space(JointMechanism& m) {
  for (std::size_t i = 0, drivers = 1 + m.draw().below(3); i < drivers;) {
    i += add_driven(m, i == 0 ? 0 : earlier(m), "RPC"[m.draw().below(3)], "driven");
  }
  for (std::size_t i = 0, units = 1 + m.draw().below(3); i < units;) {
    std::size_t a = other(m, 0), b = other(m, a);
    if (m.draw().maybe()) std::swap(a, b);
    Six on{};
    for (std::size_t& s : on) s = earlier(m);
    const std::size_t kind = m.draw().below(7);
    i += kind == 0   ? add_platform(m, on[0])
         : kind <= 2 ? add_rod(m, a, b)
         : kind == 3 ? add_strut(m, a, b)
         : kind == 4 ? add_rscr(m, a, b)
         : kind == 5 ? add_hexapod(m, on)
                     : add_chain(m, a, b, random_joints(m.draw(), 6));
  }
}

// Calls of(mechanism, groups) for this many mechanisms that are regular; groups: of each unit.
template <class Of>
void expect_motions(int dimension, int all, const TimeGrid& grid, const Of& of) {
  for (std::uint64_t seed = test::first_seed(), found = 0; found < static_cast<std::uint64_t>(all); ++seed) {
    Draw draw(seed);
    JointMechanism m(draw, dimension);
    dimension == 2 ? add_units_in_the_plane(m) : add_units_in_space(m);
    if (!m.calm(grid)) continue;
    ++found;
    std::string kinds;
    for (const std::string& k : m.kinds()) kinds += ", " + k;
    SCOPED_TRACE("seed " + std::to_string(seed) + kinds);
    try {
      const Scene scene = m.write(grid);
      const GroupedSystem s = group_equations(scene.with_outputs({"all"}));
      EXPECT_EQ(s.cannot_assemble, "");
      EXPECT_TRUE(s.undetermined.empty());
      for (const Redundancy& r : s.redundant) ADD_FAILURE() << "not redundant: " << r.dropped;
      of(m, m.groups_of_units(s));
      m.expect_motion(scene);
      (void)test::expect_same_by_code(scene, seed % 2 != 0 ? "irreducible/lanes" : "irreducible/lanes:4");
    } catch (const std::exception& e) {
      ADD_FAILURE() << e.what();
    }
  }
}

TEST(RandomJoints, TreesInThePlaneMoveByPlainEquations) {
  expect_motions(2, test::random_count(100), {0, 1, 1.0 / 200}, [](const JointMechanism& m, const auto& groups) {
    for (std::size_t u = 0; u < groups.size(); ++u) {
      // A slider's coordinates have no equations in common; the first link of RPP turns with the second body.
      const std::string& kind = m.kinds()[u];
      const bool needs_none = kind == "crank" || kind == "slider" || m.rests(static_cast<int>(u));
      EXPECT_GE(groups[u], needs_none ? 0 : 1) << kind << ' ' << u;
      EXPECT_LE(groups[u], kind == "slider" || kind == "RPP" ? 2 : 1) << kind << ' ' << u;
    }
  });
}

TEST(RandomJoints, ChainsAndLegsInSpaceMoveByPlainEquations) {
  const int all = test::random_count(40);
  int with_rscr = 0;
  expect_motions(3, all, {0, 1, 1.0 / 100}, [&](const JointMechanism& m, const auto&) {
    with_rscr += std::count(m.kinds().begin(), m.kinds().end(), "crank SCR") > 0 ? 1 : 0;
  });
  EXPECT_GE(with_rscr, all / 8);
}

}  // namespace
}  // namespace assur
