// Start postures of random mechanisms whose laws do not begin at the drawing, compared with independent plain
// equations that are followed from the drawing along the same way. ASSUR_RANDOM_SCENES sets the number of mechanisms,
// ASSUR_RANDOM_SEED the first seed. A failure prints the seed, the fault and the scene.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "assur/plan.hpp"
#include "equations/system.hpp"
#include "lettered_joint.hpp"
#include "mechanisms/plain_motion.hpp"
#include "mechanisms/random_mechanism.hpp"
#include "properties/random_count.hpp"
#include "structure/grouped_system.hpp"

namespace assur::check {
namespace {

using mechanisms::PlainEquations;
using mechanisms::PlainMotion;
using mechanisms::Real;
using mechanisms::TimeJet;

constexpr int kParts = 1000;  // of the way that the plain equations are followed along

// A mechanism, drawn closed. The laws begin at `written` in one scene and away from it in the other one.
struct Away {
  Scene at_drawing, away;
  std::vector<double> written, change;  // of each law: absolute angle or distance
};

class Maker {
 public:
  explicit Maker(std::uint64_t seed) : random_(seed) {}

  Away make() {
    switch (random_() % 6) {
      case 0:
        return two_drivers();
      case 1:
        return flat_loop();
      case 2:
        return loop_in_space();
      default:
        return of_a_family();
    }
  }

 private:
  double uniform(double from, double to) { return from + (to - from) * static_cast<double>(random_() >> 11) * 0x1p-53; }
  double offset() { return (random_() % 2 == 0 ? 1 : -1) * uniform(0.1, 3); }
  double stroke() { return (random_() % 2 == 0 ? 1 : -1) * uniform(0.1, 1); }
  Triple place() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  Triple flat() { return {uniform(-1, 1), uniform(-1, 1), 0}; }
  Triple direction() {
    for (;;) {
      Triple d = place();
      const double n = std::hypot(d[0], d[1], d[2]);
      if (n < 0.2 || n > 1) continue;
      for (Number& x : d) x /= n;
      return d;
    }
  }

  template <class Make>
  Away twice(const Make& make, std::vector<double> written, std::vector<double> change) {
    return {make(false), make(true), std::move(written), std::move(change)};
  }

  // A mechanism of a random family, without a driven pose; its laws begin where they would end. Bennett's linkage and
  // the delta robot with six rods are left out: the way of the first ends where other redundant equations would have to
  // be chosen, which motions do and ways to the start do not; why that of the second ends was not looked for.
  Away of_a_family() {
    for (;;) {
      const mechanisms::RandomMechanism m = mechanisms::random_mechanism(random_());
      const Scene scene = parse_scene(m.exact, m.family);
      const auto poses = [](const Driver& d) { return std::holds_alternative<Pose>(d.kind); };
      if (m.family == "bennett" || m.family == "delta") continue;
      if (std::any_of(scene.drivers().begin(), scene.drivers().end(), poses)) continue;
      const TimeGrid time = scene.time();
      std::vector<double> written, change;
      const auto at = [&](double share) {
        return scene.with_laws([&](const std::string& name, const Law& law) {
          const double from = law(time.start).value, by = law(time.end).value - from;
          if (share == 0) written.push_back(from);
          if (share == 0) change.push_back(name.starts_with("motor") ? std::remainder(by, kTurn) : by);
          return Law::constant(from + share * by);
        });
      };
      Scene drawn = at(0), away = at(1);
      return {std::move(drawn), std::move(away), written, change};
    }
  }

  // A five-bar with two cranks, or a crank and a cylinder.
  Away two_drivers() {
    const Triple a = flat(), b = flat(), c = flat(), d = flat(), e = flat();
    const bool has_cylinder = random_() % 2 == 0;
    const double from = std::atan2(b[1] - a[1], b[0] - a[0]), by = offset();
    const double other = has_cylinder ? std::hypot(d[0] - e[0], d[1] - e[1]) : std::atan2(d[1] - e[1], d[0] - e[0]);
    const double other_by = has_cylinder ? std::max(stroke(), 0.1 - other) : offset();
    const auto make = [&](bool away) {
      SceneBuilder s("five_bar", 2);
      s.fixed_point("A", a).fixed_point("E", e).point("B", b).point("C", c).point("D", d);
      s.constrain("one", Distance{"B", "C"}).constrain("two", Distance{"C", "D"});
      s.drive("m", PointAngle{"A", "B", "", Law::constant(from + (away ? by : 0))});
      const Law law = Law::constant(other + (away ? other_by : 0));
      if (has_cylinder) {
        s.fixed_point("G", {a[0] + 0.3, a[1] - 0.4, 0}).constrain("guide", Distance{"G", "D"});
        s.drive("n", DrivenDistance{"E", "D", law});
      } else {
        s.drive("n", PointAngle{"E", "D", "", law});
      }
      return s.time(0, 1, 1).build();
    };
    return twice(make, {from, other},
                 {std::remainder(by, kTurn), has_cylinder ? other_by : std::remainder(other_by, kTurn)});
  }

  // A loop of bodies; its first joint, between the ground and a body, is driven.
  Away loop(int dimension, const std::vector<test::LetteredJoint>& joints) {
    const bool slides = joints[0].letter == 'P';
    const double by = slides ? stroke() : offset();
    const auto make = [&](bool away) {
      SceneBuilder s("loop", dimension);
      const std::size_t n = joints.size();
      const auto body = [&](std::size_t i) { return i % n == 0 ? std::string("ground") : "b" + std::to_string(i); };
      for (std::size_t i = 1; i < n; ++i)
        s.add(Body{.name = body(i), .points = {Member{"M" + std::to_string(i), joints[i].at, true}}});
      for (std::size_t i = 0; i < n; ++i) {
        test::LetteredJoint j = joints[i];
        j.name = "J" + std::to_string(i), j.a = body(i), j.b = body(i + 1);
        test::add(s, j, dimension);
      }
      s.drive("m", DrivenCoordinate{slides ? "J0.displacement" : "J0.angle", Law::constant(away ? by : 0)});
      return s.time(0, 1, 1).build();
    };
    return twice(make, {}, {by});
  }

  Away flat_loop() {
    std::vector<test::LetteredJoint> joints;
    for (int i = 0; i < 4; ++i) {
      Triple axis = direction();
      axis[2] = 0;
      const double n = std::hypot(axis[0], axis[1]);
      for (Number& x : axis) x /= n;
      const char letter = random_() % 4 == 0 ? 'P' : 'R';
      joints.push_back({.letter = letter, .at = flat(), .axis = axis});
    }
    joints[1].letter = joints[2].letter = 'R';
    return loop(2, joints);
  }

  // Seven freedoms in the joints, one of them driven.
  Away loop_in_space() {
    static const std::vector<std::string> loops = {"RSUR", "RUSR", "RSUP", "PUSR", "RUUU", "RRSU", "RRRRS", "PRRSR"};
    std::vector<test::LetteredJoint> joints;
    for (const char letter : loops[random_() % loops.size()]) {
      const Triple axis = direction(), d = direction();
      // At right angles to the axis.
      const double along = axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
      Triple other = {d[0] - along * axis[0], d[1] - along * axis[1], d[2] - along * axis[2]};
      const double n = std::hypot(other[0], other[1], other[2]);
      for (Number& x : other) x /= n;
      joints.push_back({.letter = letter, .at = place(), .axis = axis, .second = other});
    }
    return loop(3, joints);
  }

  static constexpr double kTurn = 6.283185307179586477;
  std::mt19937_64 random_;
};

// All points, vectors and scalars of a start posture, in SI units.
struct Row {
  std::vector<std::string> columns;
  std::vector<double> values;
};

Row row_of(const GroupedSystem& s) {
  Row row;
  for (const Item& item : s.system->items) {
    if (item.hidden) continue;
    for (int k = 0; k < item.components; ++k) {
      row.columns.push_back(item.components == 1 ? item.name : item.name + "." + "xyz"[k]);
      row.values.push_back(form_value<double>(*s.system, item.form[k], s.start) * s.system->unit(item.dimension));
    }
  }
  return row;
}

// The absolute angle of a joint's driver in the drawing: that of the arm in the plane, else 0.
double written_angle(const Scene& scene) {
  const auto* arm = std::get_if<PointAngle>(&scene.drivers()[0].kind);
  if (arm == nullptr || scene.dimension() == 3) return 0;
  const auto at = [&](const std::string& name) {
    for (const Point& p : scene.points()) {
      if (p.name == name) return p.at;
    }
    return Triple{};
  };
  const Triple a = at(arm->a), b = at(arm->b);
  return std::atan2(b[1] - a[1], b[0] - a[0]);
}

struct Outcome {
  std::string verdict, what;
};

Outcome compare(Away away) {
  const GroupedSystem drawn = group_equations(away.at_drawing);
  if (!drawn.cannot_assemble.empty() || !drawn.undetermined.empty()) return {"skipped", drawn.cannot_assemble};
  if (away.written.empty()) away.written = {written_angle(away.at_drawing)};
  const auto laws = [&](Real s) {
    std::vector<TimeJet<Real>> all;
    for (std::size_t k = 0; k < away.change.size(); ++k) {
      all.emplace_back(Real(away.written[k]) + s * Real(away.change[k]), Real(away.change[k]) / kParts, Real(0));
    }
    return all;
  };
  PlainMotion plain(away.at_drawing);
  const Row from = row_of(drawn);
  double figure = 0;
  if (plain.start(from.columns, from.values, laws(0), figure) != PlainMotion::Start::right) {
    return {"skipped", "the drawing is singular: " + std::to_string(figure)};
  }
  Real share = 1;
  for (int k = 0; k < kParts && share == 1; ++k) {
    const Real came = plain.advance([&](Real s) { return laws((Real(k) + s) / kParts); });
    if (came < 1) share = (Real(k) + came) / kParts;
  }
  const GroupedSystem found = group_equations(away.away);
  const bool refused = !found.cannot_assemble.empty() || !found.undetermined.empty();
  if (refused) {
    const std::string& why = found.cannot_assemble;
    const std::size_t at = why.find(": at ");
    if (at == std::string::npos) return {"refused without a share", why};
    const double told = std::stod(why.substr(at + 5)) / 100;
    if (share == 1) return {"refused needlessly", why};
    if (std::abs(told - double(share)) > 0.01)
      return {"another fold", why + "; plain: " + std::to_string(double(share))};
    return {"same fold", ""};
  }
  if (share < 1) return {"passes a singularity", "plain: " + std::to_string(double(share))};
  if (!plain.settle(laws(1))) return {"undecided", "the end is singular"};
  const Row to = row_of(found);
  double worst = 0, size = 1;
  std::string where;
  for (std::size_t k = 0; k < to.columns.size(); ++k) {
    const PlainEquations::Column column = plain.equations().column(to.columns[k]);
    if (!column.known) continue;  // not an unknown of the plain equations
    size = std::max(size, std::abs(to.values[k]));
    const double off = std::abs(to.values[k] - double(plain.show({&column, 1})[0].value));
    if (off > worst) worst = off, where = to.columns[k];
  }
  // Both hold the equations to rounding, which the condition amplifies. `size`: of the numbers, at least 1.
  if (worst <= (1e-13 * plain.condition() * plain.condition() + 1e-11) * size) return {"same", ""};
  return {"wrong", where + " is off by " + std::to_string(worst) + ", condition " + std::to_string(plain.condition())};
}

TEST(RandomStarts, AreTheEndsOfTheirWays) {
  const std::uint64_t first = test::first_seed();
  const int count = test::random_count(60);
  std::map<std::string, int> verdicts;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(count); ++seed) {
    const Away away = Maker(seed).make();
    const Outcome out = compare(away);
    ++verdicts[out.verdict];
    const bool agrees =
        out.verdict == "same" || out.verdict == "same fold" || out.verdict == "skipped" || out.verdict == "undecided";
    EXPECT_TRUE(agrees) << "seed " << seed << ", " << away.away.name() << ": " << out.verdict << ": " << out.what
                        << "\n"
                        << write_scene(away.away);
  }
  for (const auto& [verdict, n] : verdicts) std::cout << verdict << ": " << n << '\n';
  EXPECT_GE(verdicts["same"], count / 4);
}

}  // namespace
}  // namespace assur::check
