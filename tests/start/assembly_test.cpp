// The start posture from a poor guess.
#include "start/assembly.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "assur/plan.hpp"
#include "equations/dense_block.hpp"
#include "references/perturb.hpp"
#include "start/closest.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using enum Formulation;
using look::structure;

struct Poor {
  const char* sample;
  double size;  // size of the perturbation, m
};
class PoorGuess : public testing::TestWithParam<Poor> {};

// Errors of 20 to 50 % of the typical length in every coordinate; these samples have explicit lengths.
TEST_P(PoorGuess, LeadsToAPosture) {
  const auto [name, size] = GetParam();
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Scene scene = references::perturbed(sample(name), size, seed);
    for (const Formulation f : {groups, irreducible}) {
      const GroupedSystem s = structure(scene, f);
      EXPECT_EQ(s.cannot_assemble, "") << "seed " << seed;
      EXPECT_LE(look::start_residual(s), 1e-14) << "seed " << seed;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Samples, PoorGuess,
                         testing::Values(Poor{"four_bar", 0.4}, Poor{"four_bar:5", 0.5}, Poor{"slider_crank", 0.05},
                                         Poor{"andrews", 0.01}, Poor{"stewart", 0.15}),
                         [](const auto& poor) {
                           std::string name = poor.param.sample;
                           std::erase(name, ':');
                           return name;
                         });

// ---- the mode of the guess

Scene dyad(const Triple& guess) {
  return SceneBuilder("dyad", 2)
      .fixed_point("A", {0, 0, 0})
      .fixed_point("B", {2, 0, 0})
      .point("P", guess)
      .constrain("PA", Distance{"P", "A", 1.5})
      .constrain("PB", Distance{"P", "B", 1.2})
      .time(0, 1, 0.1)
      .build();
}
constexpr const char* kOther = "was assembled in another mode than its guess";
constexpr const char* kUndecidable = "is not decidable";

// A dyad has one mode on each side of AB. Damping keeps the side of the guess.
TEST(AssemblyMode, ADyadStaysOnItsSide) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(-1, 3), y(-2, 2);
  for (int i = 0; i < 2000; ++i) {
    const Triple guess = {x(random), y(random), 0};
    const GroupedSystem s = structure(dyad(guess), groups);
    ASSERT_EQ(s.cannot_assemble, "");
    EXPECT_GT(look::start(s, "P.y") * guess[1], 0) << guess[0] << ", " << guess[1];
    const double moved = std::hypot(look::start(s, "P.x") - guess[0], look::start(s, "P.y") - guess[1]);
    EXPECT_EQ(look::notes(s).find("the start posture is far from the guess: P moved most") == 0, moved > 0.75);
    EXPECT_EQ(look::notes(s).empty(), moved <= 0.75) << look::notes(s);
  }
}

// Sign of the determinant of all equations in all unknowns.
int sign(const System& s, const std::vector<double>& q) {
  std::vector<Index> equations(s.equations.size()), unknowns, column(s.coordinates.size(), -1);
  std::iota(equations.begin(), equations.end(), 0);
  for (std::size_t c = 0; c < s.coordinates.size(); ++c) {
    if (s.coordinates[c].role == Role::unknown) unknowns.push_back(static_cast<Index>(c));
  }
  return DenseBlock(s, equations, unknowns, column).jacobian(q).determinant() < 0 ? -1 : 1;
}

// From a bad guess, a Stewart-Gough platform is often assembled in another mode.
TEST(AssemblyMode, IsReportedExactlyWhenTheDeterminantChangesSign) {
  int crossed = 0, assembled = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const GroupedSystem s = structure(references::perturbed(sample("gough:posture=10"), 0.4, seed), groups);
    if (!s.cannot_assemble.empty()) continue;  // some guesses that are off by 40 % lead to no posture
    ++assembled;
    const bool other = sign(*s.system, s.system->guess) != sign(*s.system, s.start);
    crossed += other;
    // Least squares of all equations leave the mode open, and the note reports the search.
    const bool is_told = look::notes(s).find(kOther) != std::string::npos;
    const bool is_searched = look::notes(s).find("a search with the drivers held") != std::string::npos;
    EXPECT_TRUE(is_told == other || (other && is_searched)) << "seed " << seed << ": " << look::notes(s);
  }
  EXPECT_GT(assembled, 50);
  EXPECT_GT(crossed, 0);  // else nothing was tested
  EXPECT_LT(crossed, assembled);
}

TEST(AssemblyMode, IsUndecidableOnTheLine) {
  for (const double x : {0.5, 1.0, 1.4, 3.0}) {
    const GroupedSystem s = structure(dyad({x, 0, 0}), groups);
    ASSERT_EQ(s.cannot_assemble, "");
    EXPECT_NE(look::notes(s).find("group P: "), std::string::npos) << look::notes(s);
    EXPECT_NE(look::notes(s).find(kUndecidable), std::string::npos) << x;
  }
}

TEST(AssemblyMode, AGoodGuessGivesNoNote) {
  for (const char* name : {"four_bar:10", "andrews", "slider_crank", "stewart", "gough", "hexapod",
                           "rings:legs=2,n=60,terminal=24", "n_four_bar:20"}) {
    for (const Formulation f : {global, groups, irreducible}) EXPECT_EQ(look::notes(structure(sample(name), f)), "");
  }
}

// A leg of the Stewart platform has a mode for each sign of d. The guess decides the sign; the rest of the leg is equal
// in both modes.
TEST(AssemblyMode, TheGuessDecidesTheSignOfD) {
  const Scene scene = sample("stewart");
  const double before = look::start(structure(scene, groups), "B1.x");
  SceneBuilder b("stewart", 3);
  for (Point x : scene.points()) b.add(x);
  for (Vector x : scene.vectors()) {
    if (x.name == "d1") x.at = {-x.at[0], -x.at[1], -x.at[2]};
    b.add(x);
  }
  for (const Body& x : scene.bodies()) b.add(x);
  for (const Constraint& x : scene.constraints()) b.add(x);
  for (const Driver& x : scene.drivers()) b.add(x);
  b.time(0, 1, 0.01);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_EQ(look::notes(s), "");
  EXPECT_NEAR(look::start(s, "d1.x"), -look::start(structure(scene, groups), "d1.x"), 1e-14);
  EXPECT_EQ(look::start(s, "B1.x"), before);
}

// The other point of intersection of the dyad has x = (1.5^2 - 1.2^2 + 2^2) / 4.
TEST(StartNotes, ReportAPostureFarFromTheGuess) {
  const GroupedSystem s = structure(dyad({-1, 0.1, 0}), groups);
  ASSERT_EQ(s.notes.size(), 1u);
  EXPECT_EQ(s.notes[0].where, "/points/P");
  EXPECT_EQ(s.notes[0].what,
            "the start posture is far from the guess: P moved most, by 2.34 m, from (-1, 0.1) m to (1.2025, "
            "0.896657) m");
}

// With e . a = 0.8, both guesses lead to e = (0.8, 0.6); the angles between guess and e are acos(-0.28) and 0.33.
TEST(StartNotes, ReportATurnedVector) {
  const auto notes = [](Triple guess) {
    return structure(SceneBuilder("turned", 2)
                         .fixed_vector("a", {1, 0, 0})
                         .vector("e", guess)
                         .constrain("ea", Dot{"e", "a", 0.8})
                         .time(0, 1, 0.1)
                         .build(),
                     groups)
        .notes;
  };
  const auto turned = notes({-0.8, 0.6, 0});
  ASSERT_EQ(turned.size(), 1u);
  EXPECT_EQ(turned[0].where, "/vectors/e");
  EXPECT_EQ(turned[0].what, "the start posture is far from the guess: e turned most, by 1.85 rad");
  EXPECT_EQ(notes({0.6, 0.8, 0}).size(), 0u);
}

// B is 1 m from A. One note for each driver reports that its law disagrees with `at`.
TEST(StartNotes, ReportLawsThatDisagreeWithThePosture) {
  struct Case {
    const char* text;
    decltype(Driver::kind) kind;
    bool keeps_y, keeps_length;
  };
  const Law angle = Law::constant(0.5), length = Law::constant(1.2);
  const Case cases[] = {
      {"its angle is 0.5 rad by the law and 0 rad by `at`", PointAngle{"A", "B", "", angle}, false, false},
      {"its angle is 0.5 rad by the law and 0 rad by `at`", RelativeAngle{{"A", "X"}, {"A", "B"}, "", angle}, false,
       true},
      {"its distance is 1.2 m by the law and 1 m by `at`", DrivenDistance{"A", "B", length}, true, false},
      {"its coordinate is 1.2 m by the law and 1 m by `at`", DrivenCoordinate{"B.x", length}, true, false},
      {"its x is 1.2 m by the law and 1 m by `at`", Pose{"body", {length, Law()}, {Law()}}, false, false},
      {"its angle is 0.5 rad by the law and 0 rad by `at`", Pose{"body", {Law::constant(1), Law()}, {angle}}, false,
       false},
  };
  for (const Case& c : cases) {
    const bool posed = std::holds_alternative<Pose>(c.kind);
    for (const bool declared : {false, true}) {
      if (declared && c.keeps_length) continue;  // the group would separate items that the driver adds
      SceneBuilder b("drivers", 2);
      b.fixed_point("A", {0, 0}).fixed_point("X", {2, 0}).point("B", {1, 0});
      if (c.keeps_y) b.constrain("y", FixedCoordinate{"B.y", 0});
      if (c.keeps_length) b.constrain("length", Distance{"A", "B", 1.0});
      if (posed) b.point("C", {2, 0}).add(Body{"body", "", {}, {"B", "C"}, {}, {}});
      std::vector<std::string> group = {"B"};
      if (posed) group.push_back("C");
      if (declared) b.add(DeclaredGroup{"G", group, false});
      b.drive("motor", c.kind).time(0, 1, 0.1);
      const GroupedSystem s = structure(b.build(), groups);
      EXPECT_EQ(s.cannot_assemble, "");
      ASSERT_FALSE(s.notes.empty()) << c.text;
      EXPECT_EQ(s.notes[0].where, "/drivers/motor");
      EXPECT_EQ(s.notes[0].what,
                std::string("the law's value at the start and `at` disagree: ") + c.text + "; the law wins");
      EXPECT_EQ(s.notes.size(), 1u) << s.notes[1].what;
    }
  }
}

// A distance constraint between two joints of a coupler with a third point.
TEST(StartNotes, NameADistanceThatReshapesABody) {
  const auto notes = [](double length) {
    SceneBuilder b("coupler", 2);
    b.add(Body{.name = "a"}).add(Body{.name = "c", .points = {{.name = "M", .local = {1.2, 1.8}, .in_ground = true}}});
    b.add(Body{.name = "r"});
    b.joint("A", Revolute{"ground", "a", Triple{0, 0}}).joint("B", Revolute{"a", "c", Triple{0.5, 0.3}});
    b.joint("C", Revolute{"c", "r", Triple{2, 1.4}}).joint("D", Revolute{"ground", "r", Triple{2.4, 0}});
    b.constrain("k", Distance{"B", "C", length}).output("M");
    b.drive("m", DrivenCoordinate{"A.angle", Law::polynomial({0, 0.5})}).time(0, 1, 0.1);
    return structure(b.build(), Formulation::irreducible).notes;
  };
  EXPECT_TRUE(notes(std::hypot(1.5, 1.1)).empty());
  const std::vector<Diagnostic> found = notes(2);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].where, "/constraints/k");
  EXPECT_EQ(found[0].what,
            "the distance and `at` disagree: 'B' and 'C' of body 'c' are 1.86011 m apart by `at` and 2 m by the "
            "constraint; the constraint wins, and the body has another shape");
}

// A coordinate that another program computed as 0 has the value of its rounding.
TEST(StartNotes, DoNotReportRounding) {
  const auto notes = [](double y) {
    return structure(SceneBuilder("slide", 2)
                         .fixed_point("A", {-3, 0})
                         .point("B", {1, y})
                         .constrain("x", FixedCoordinate{"B.x", 1})
                         .drive("motor", DrivenCoordinate{"B.y", Law::constant(0)})
                         .time(0, 1, 0.1)
                         .build(),
                     groups)
        .notes;
  };
  EXPECT_EQ(notes(-2e-17).size(), 0u);
  EXPECT_EQ(notes(1e-12).size(), 1u);
}

// Two rods are too short. The closest P is between A and B, and both rods are violated equally.
TEST(ClosestPosture, SharesTheViolationAmongTheConstraints) {
  const Scene scene = SceneBuilder("short", 2)
                          .fixed_point("A", {0, 0})
                          .fixed_point("B", {4, 0})
                          .point("P", {1, 1})
                          .constrain("PA", Distance{"P", "A", 1.5})
                          .constrain("PB", Distance{"P", "B", 1.5})
                          .time(0, 1, 0.1)
                          .build();
  const GroupedSystem s = structure(scene, groups);
  ASSERT_NE(s.cannot_assemble, "");
  const ClosestPosture closest = closest_posture(*s.system);
  ASSERT_EQ(closest.violated.size(), 2u);
  for (const ViolatedConstraint& v : closest.violated) {
    EXPECT_TRUE(v.is_length);
    EXPECT_NEAR(v.by, (4 - 2.25) / 4, 1e-6);  // (|P-A|^2 - 1.5^2) / (2 |P-A|) with |P-A| = 2
  }
}

// If two axes of a frame are fixed, the third one is their product, whichever it is.
TEST(Assembly, AFrameWithTwoFixedAxesHasTheThird) {
  const Triple axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int free = 0; free < 3; ++free) {
    SceneBuilder b("frame", 3);
    b.fixed_point("O", {0, 0, 0});
    const std::vector<std::string> names = {"u", "v", "w"};
    for (int j = 0; j < 3; ++j) {
      const Triple& a = axes[j];
      if (j == free) {
        b.vector(names[static_cast<std::size_t>(j)], {a[0] + 0.3, a[1] - 0.2, a[2] + 0.1});
      } else {
        b.fixed_vector(names[static_cast<std::size_t>(j)], a);
      }
    }
    b.add(Body{"body", "O", names, {}, {}, {}});
    const GroupedSystem s = structure(b.time(0, 1, 0.1).build(), groups);
    EXPECT_EQ(s.cannot_assemble, "");
    EXPECT_TRUE(s.undetermined.empty());
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(look::start(s, names[static_cast<std::size_t>(free)] + "." + "xyz"[k]),
                  axes[free][static_cast<std::size_t>(k)], 1e-15);
    }
  }
}

// ---- impossible

// Reads m from the end of a message, "... violated most, by NUMBER m"; -1 if the message has no number in metres.
double violation(const std::string& message) {
  const std::string before = "violated most, by ";
  const std::size_t at = message.find(before);
  if (at == std::string::npos) return -1;
  const std::string number = message.substr(at + before.size());
  std::size_t length = 0;
  const double metres = std::stod(number, &length);
  return number.substr(length) == " m" ? metres : -1;
}

TEST(AssemblyRefused, RefusesAndrewsWithTheMisprint) {
  const Scene scene = sample("andrews:xb=0.03635");
  const std::string what = look::error(Error::Kind::numerical, [&] { (void)prepare(scene); });
  const bool g = what.rfind("group G cannot be assembled: 'G", 0) == 0,
             h = what.rfind("group H cannot be assembled: 'H", 0) == 0;
  EXPECT_TRUE(g || h) << what;
  // E is determined by its own dyad. GE + GA (or HE + HA) = 0.06 is too short for EA, so the worst rod takes at least a
  // third of the gap.
  const Triple F = {0.007, 0, 0}, B = {0.03635, 0.03273, 0}, A = {-0.06934, -0.00227, 0};
  const double bf = std::hypot(B[0] - F[0], B[1] - F[1]), along = (bf * bf + 0.028 * 0.028 - 0.035 * 0.035) / (2 * bf);
  const double across = std::sqrt(0.028 * 0.028 - along * along);
  const double ux = (B[0] - F[0]) / bf, uy = (B[1] - F[1]) / bf;
  double least = 1, most = 0;
  for (const int side : {-1, 1}) {
    const double gap =
        std::hypot(F[0] + along * ux - side * across * uy - A[0], F[1] + along * uy + side * across * ux - A[1]) - 0.06;
    least = std::min(least, gap);
    most = std::max(most, gap);
  }
  ASSERT_GT(least, 0);
  EXPECT_GE(violation(what), least / 3) << what;
  EXPECT_LE(violation(what), most) << what;
}

TEST(AssemblyRefused, RefusesATenthOfAPercent) {
  SceneBuilder b("short", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).point("P", {1, 0.3, 0});
  b.constrain("left", Distance{"P", "A", 0.999}).constrain("right", Distance{"P", "B", 0.999}).time(0, 1, 0.1);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_EQ(s.cannot_assemble.rfind("group P cannot be assembled: '", 0), 0u) << s.cannot_assemble;
  EXPECT_NEAR(violation(s.cannot_assemble), 0.001, 1e-6);  // half of the gap of 0.002, by symmetry, to first order
}

// Whatever the internal unit is, the violation of a length is in metres. A declared group is named as declared.
TEST(AssemblyRefused, NamesDeclaredGroupAndMetres) {
  for (const double scale : {1e-3, 1.0, 1e4}) {
    SceneBuilder b("short", 2);
    b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2 * scale, 0, 0}).point("P", {scale, 0.3 * scale, 0});
    b.constrain("left", Distance{"P", "A", 0.9 * scale}).constrain("right", Distance{"P", "B", 0.9 * scale});
    b.add(DeclaredGroup{"dyad", {"P"}}).time(0, 1, 0.1);
    const GroupedSystem s = structure(b.build(), groups);
    EXPECT_EQ(s.cannot_assemble.rfind("group dyad cannot be assembled: '", 0), 0u) << s.cannot_assemble;
    // The least-squares solution is (1, 0) with |Phi| / |grad Phi| = (1 - 0.9^2) / 2, printed with three digits.
    EXPECT_NEAR(violation(s.cannot_assemble), 0.095 * scale, 1e-4 * scale) << s.cannot_assemble;
  }
}

// u cannot be a unit vector with two components of 0.9. The violation has no unit, because it is not a length.
TEST(AssemblyRefused, ADirectionHasNoMetres) {
  SceneBuilder b("turned", 3);
  b.fixed_vector("x", {1, 0, 0}).fixed_vector("y", {0, 1, 0}).vector("u", {0.6, 0.6, 0.5});
  b.constrain("to_x", Dot{"u", "x", 0.9}).constrain("to_y", Dot{"u", "y", 0.9}).time(0, 1, 0.1);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_EQ(s.cannot_assemble.rfind("group u cannot be assembled: '", 0), 0u) << s.cannot_assemble;
  EXPECT_EQ(violation(s.cannot_assemble), -1) << s.cannot_assemble;
}

// These guesses lie on a line of symmetry, where the least-squares iteration stagnates.
TEST(Assembly, StartsFromALineOfSymmetry) {
  for (const double x : {-1.0, 0.5, 1.0, 1.4, 3.0}) {
    const GroupedSystem s = structure(dyad({x, 0, 0}), groups);
    EXPECT_EQ(s.cannot_assemble, "") << x;
    EXPECT_LE(look::start_residual(s), 1e-15) << x;
  }
}

// The gradient of a distance vanishes if its points coincide.
TEST(Assembly, StartsFromCoincidentPoints) {
  SceneBuilder b("dyad", 2);
  b.fixed_point("A", {0, 0, 0}).fixed_point("B", {2, 0, 0}).point("P", {0, 0, 0});
  b.constrain("PA", Distance{"P", "A", 1.5}).constrain("PB", Distance{"P", "B", 1.2}).time(0, 1, 0.1);
  const GroupedSystem s = structure(b.build(), groups);
  EXPECT_EQ(s.cannot_assemble, "");
  EXPECT_LE(look::start_residual(s), 1e-15);
}

}  // namespace
}  // namespace assur
