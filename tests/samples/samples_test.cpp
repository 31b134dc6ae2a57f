// The samples: their texts, start postures and geometry.
#include "samples/samples.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "decompositions.hpp"
#include "references/posture.hpp"
#include "references/stewart.hpp"
#include "references/tables.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using namespace references;  // NOLINT: the whole file is about them

std::string message(std::string_view text, const Parameters& set = {}) {
  try {
    (void)sample(text, set);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "no error";
}

void expect_satisfied(const Equations<double>& equations, double tolerance) {
  EXPECT_FALSE(equations.left().empty());
  for (const Left<double>& left : equations.left()) EXPECT_LE(std::abs(left.value), tolerance) << left.equation;
}

Equations<double> guess_of(const Scene& scene) {
  Equations<double> equations(scene, at_guess<double>(scene));
  equations.drive([&scene](const Law& law) { return law(scene.time().start).value; });
  return equations;
}

// ---- texts

TEST(SampleText, NamesAreSortedAndKnown) {
  std::string_view last;
  for (const samples::SampleMechanism& row : samples::table()) {
    EXPECT_LT(last, row.name);
    last = row.name;
    EXPECT_TRUE(is_sample(row.name));
    EXPECT_TRUE(is_sample(std::string(row.name) + ":anything"));
    const Scene scene = sample(row.name);
    EXPECT_EQ(scene.name(), row.name);
    const bool is_walker_or_lift = row.name == "jansen" || row.name == "scissor";  // files give their outputs
    EXPECT_EQ(scene.outputs().empty(), !is_walker_or_lift) << row.name;
    EXPECT_TRUE(scene.warnings().empty());
  }
  last = {};
  for (const samples::SceneFile& file : samples::scene_files()) {
    EXPECT_LT(last, file.name);
    last = file.name;
    EXPECT_GT(file.summary().size(), 10U) << file.name;
    EXPECT_EQ(sample(file.name).name(), file.name);
  }
  EXPECT_FALSE(is_sample("stewart2"));
  EXPECT_FALSE(is_sample("scenes/stewart.json"));
  EXPECT_FALSE(is_sample(""));
}

TEST(SampleText, OptionsAreReadFromTextAndParameters) {
  EXPECT_EQ(sample("four_bar:64").points().size(), 2u * 65);
  EXPECT_EQ(sample("four_bar:loops=64").points().size(), 2u * 65);
  EXPECT_EQ(sample("four_bar", {{"loops", 64}}).points().size(), 2u * 65);
  EXPECT_EQ(sample("rings:terminal=12,legs=2,n=18").groups().size(), 3u);
  EXPECT_EQ(sample("stewart:step=0.002").time().step, 0.002);
  EXPECT_EQ(sample("stewart:step=0.002", {{"step", 0.004}}).time().step, 0.004);
  EXPECT_EQ(sample("hexapod:drive=legs").drivers().size(), 6u);
  EXPECT_EQ(sample("hexapod:drive=pose").drivers().size(), 1u);
}

TEST(SampleText, OptionsOfAFileAreItsParameters) {
  const auto law = [](const Scene& scene) {
    return std::visit(
        [](const auto& kind) {
          if constexpr (requires { kind.law; }) return kind.law;
          return Law();
        },
        scene.drivers().front().kind);
  };
  const std::string file = ASSUR_SOURCE_DIR "/scenes/bricard_joints.json";
  EXPECT_EQ(law(sample("bricard_joints")), law(read_scene(file)));
  EXPECT_EQ(law(sample("bricard_joints:low=-20,high=3")), law(read_scene(file, {{"low", -20}, {"high", 3}})));
  EXPECT_EQ(law(sample("bricard_joints:low=-20", {{"low", -10}})), law(read_scene(file, {{"low", -10}})));
  EXPECT_EQ(message("bricard_joints:low=x"), "sample 'bricard_joints': 'low' should be a number, not 'x'");
  EXPECT_EQ(message("bricard_joints:low"), "sample 'bricard_joints': 'low' should be option=value");
  EXPECT_EQ(message("bricard_joints:"), "sample 'bricard_joints': '' should be option=value");
  EXPECT_NE(message("bricard_joints:lo=1").find("'lo'"), std::string::npos);
}

TEST(SampleText, RefusesUnknownSamples) {
  const std::string all =
      "almost_parallelogram, andrews, bennett, bricard, bricard_joints, delta, double_wishbone, excavator, four_bar, "
      "geared_five_bar, goldberg, gough, hexa, hexapod, jansen, klann, n_four_bar, parallelograms, peaucellier, rings, "
      "sarrus, "
      "scissor, slider_crank, stewart, three_rps, watt, whitworth or whitworth_joints";
  EXPECT_EQ(message("stwart:legs=8"), "there is no sample 'stwart'; did you mean 'stewart'? It should be " + all);
  EXPECT_EQ(message("bicycle"), "there is no sample 'bicycle'; it should be " + all);
}

TEST(SampleText, RefusesBadOptions) {
  const std::string write =
      " Write four_bar:N for loops=N, or four_bar:loops=1,omega=6.283185307179586,step=0.001,"
      "steps=1000 or some of these options";
  EXPECT_EQ(message("four_bar:speed=2"), "sample 'four_bar': it has no option 'speed'." + write);
  EXPECT_EQ(message("four_bar:loop=2"), "sample 'four_bar': it has no option 'loop'; did you mean 'loops'?" + write);
  EXPECT_EQ(message("four_bar:loops=2,loops=3"), "sample 'four_bar': 'loops' is set twice." + write);
  EXPECT_EQ(message("four_bar:loops=2,3"), "sample 'four_bar': '3' should be option=value." + write);
  EXPECT_EQ(message("four_bar", {{"crank", 1}}), "sample 'four_bar': it has no option 'crank'." + write);
  const std::string loops =
      "sample 'four_bar': option 'loops' (number of four-bars) should be a whole number from 1 to "
      "1e+07, not '";
  for (const std::string bad : {"", "0", "-1", "1.5", "nan", "inf", "many", "4x", "1e99"}) {
    EXPECT_EQ(message("four_bar:" + bad), loops + bad + "'." + write);
  }
  EXPECT_EQ(message("four_bar", {{"loops", 2.5}}), loops + "2.5'." + write);
}

TEST(SampleText, RefusesContradictoryOptions) {
  EXPECT_EQ(
      message("bricard:middle=-2,swing=1"),
      "sample 'bricard': option 'middle' should not be larger than 'swing', because the motion starts at the cube");
}

TEST(SampleText, RefusesBadWordsAndMultiples) {
  const std::string hexapod = " Write hexapod:drive=pose,omega=1,step=0.01,steps=1000 or some of these options";
  const std::string drive =
      "sample 'hexapod': option 'drive' (driven part; if the legs are driven, the pose is undetermined) should be pose "
      "or legs, not '";
  EXPECT_EQ(message("hexapod:drive=arms"), drive + "arms'." + hexapod);
  EXPECT_EQ(message("hexapod", {{"drive", 1}}), drive + "1'." + hexapod);
  EXPECT_EQ(message("hexapod:legs"), "sample 'hexapod': 'legs' should be option=value." + hexapod);
  EXPECT_EQ(message("rings:n=15").substr(0, 101),
            "sample 'rings': option 'n' (unknowns of each leg) should be a multiple of 2 from 12 to 1e+07, not '15");
}

// ---- start postures

TEST(SampleGuess, SatisfiesItsOwnEquations) {
  // These circles intersect far from tangency, so errors are a few roundings. Lengths are checked relative to
  // themselves.
  for (const std::string text : {"almost_parallelogram",
                                 "almost_parallelogram:delta=1e-12",
                                 "almost_parallelogram:delta=0.75",
                                 "almost_parallelogram:delta=-0.75",
                                 "andrews",
                                 "bricard",
                                 "bricard:middle=-0.4,swing=0.5",
                                 "four_bar",
                                 "four_bar:300",
                                 "hexapod",
                                 "hexapod:drive=legs",
                                 "n_four_bar",
                                 "parallelograms:20",
                                 "rings:n=30",
                                 "rings:legs=2,n=720,terminal=96",
                                 "slider_crank",
                                 "slider_crank:offset=0.19",
                                 "slider_crank:offset=-0.19",
                                 "slider_crank:crank_length=3,rod_length=2,offset=0.1",
                                 "stewart",
                                 "stewart:legs=3",
                                 "stewart:legs=7",
                                 "stewart:legs=22",
                                 "stewart:platforms=5",
                                 "stewart:legs=16,platforms=3",
                                 "whitworth",
                                 "whitworth:pivot=0.2,hinge=stated"}) {
    SCOPED_TRACE(text);
    expect_satisfied(guess_of(sample(text)), 1e-12);
  }
}

TEST(SampleGuess, GoughAgreesWithItsTableWithinRounding) {
  // The table has six decimals, so each of nine numbers has an error of 5e-7. Points of the platform are at most 1.6
  // from its origin.
  const std::vector<GoughRow> rows = read_gough();
  ASSERT_EQ(rows.size(), 40u);
  for (const GoughRow& row : rows) {
    SCOPED_TRACE(row.posture);
    const Scene scene = sample("gough:" + std::to_string(row.posture));
    expect_satisfied(guess_of(scene), 2e-5);
    const Posture<double> guess = at_guess<double>(scene);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(guess.at("B1")[i], static_cast<double>(row.n[i]), 6e-7);
      EXPECT_NEAR(guess.at("u")[i], static_cast<double>(row.u[i]), 2e-6);  // normalised
      EXPECT_NEAR(guess.at("v")[i], static_cast<double>(row.v[i]), 2e-6);
    }
  }
}

// ---- geometry

double azimuth(const Vec<double>& a) { return std::atan2(a[1], a[0]); }
double radius(const Vec<double>& a) { return std::hypot(a[0], a[1]); }

// Difference of two angles, in (-pi, pi].
double turn(double a, double b) { return std::remainder(a - b, 2 * std::numbers::pi); }

TEST(Stewart, HasTheGeometryOfThePaper) {
  const Scene scene = sample("stewart");
  const Equations<double> at = guess_of(scene);
  const double third = 2 * std::numbers::pi / 3, quarter = std::numbers::pi / 2;
  std::unordered_map<std::string, Vec<double>> local;
  for (const Member& m : scene.bodies().at(0).points) local[m.name] = values(m.local);
  for (const Member& m : scene.bodies().at(0).vectors) local[m.name] = values(m.local);

  for (int k = 1; k <= 6; ++k) {
    SCOPED_TRACE(k);
    const std::string leg = std::to_string(k);
    const int j = (k - 1) / 2;
    const double side = k % 2 == 1 ? -1 : 1;
    const Vec<double>&A = at.at("A" + leg), &a = at.at("a" + leg);
    EXPECT_NEAR(radius(A), 0.5, 1e-15);
    EXPECT_NEAR(turn(azimuth(A), third * j + 0.35 * side), 0, 1e-15);
    EXPECT_EQ(A[2], 0);
    EXPECT_NEAR(turn(azimuth(a), azimuth(A) + quarter + 0.2), 0, 2e-15);
    EXPECT_NEAR(std::asin(a[2]), 0.1, 1e-15);
    EXPECT_NEAR(radius(local.at("P" + leg)), 0.3, 1e-15);
    EXPECT_NEAR(turn(azimuth(local.at("P" + leg)), third * j + 0.7 * side), 0, 1e-15);
    EXPECT_NEAR(dot(local.at("t" + leg), local.at("P" + leg)), 0, 1e-16);
    EXPECT_EQ(local.at("t" + leg)[2], 0);
    const Vec<double> AB = at.at("B" + leg) - A, AP = at.at("P" + leg) - A, BP = at.at("P" + leg) - at.at("B" + leg);
    EXPECT_NEAR(std::sqrt(dot(AB, AB)), 0.2, 1e-15);
    EXPECT_NEAR(std::sqrt(dot(BP, BP)), 0.55, 1e-15);
    EXPECT_GT(dot(AB, cross(a, AP)), 0);  // B is on the side of a x AP
    const Vec<double>& inward = at.at("inward" + leg);
    EXPECT_NEAR(dot(inward, a), 0, 5e-16);  // unit vectors: two roundings of each
    EXPECT_EQ(inward[2], 0);
  }
}

TEST(Stewart, MovesAsInThePaper) {
  const Scene scene = sample("stewart", {{"omega", 2}});
  const auto& pose = std::get<Pose>(scene.drivers().at(0).kind);
  for (const double t : {0.0, 0.3, 7.1}) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto phase = static_cast<double>(i);
      EXPECT_NEAR(pose.translation[i](t).value, (i == 2 ? 0.55 : 0) + 0.05 * std::sin(2 * t + phase), 1e-15);
      EXPECT_NEAR(pose.rotation[i](t).value, 0.15 * std::sin(2 * t + phase + 0.5), 1e-15);
    }
  }
  EXPECT_EQ(sample("stewart").time().end, 10);
  EXPECT_EQ(sample("stewart").time().step, 0.01);
}

TEST(Stewart, GroupsAreDeclared) {
  const Scene scene = sample("stewart");
  ASSERT_EQ(scene.groups().size(), 7u);
  EXPECT_EQ(scene.groups()[0].name, "SG_T");
  EXPECT_EQ(scene.groups()[0].unknowns, (std::vector<std::string>{"O", "u", "v", "w"}));
  EXPECT_EQ(scene.groups()[6].name, "SG_HS6");
  EXPECT_EQ(scene.groups()[6].unknowns, (std::vector<std::string>{"B6", "e6", "r6", "c6", "d6"}));
  EXPECT_EQ(scene.measures().size(), 6u);
  EXPECT_EQ(sample("stewart:platforms=3").groups().back().name, "SG_HS6_3");
}

TEST(Stewart, PlatformsDiffer) {
  const Scene scene = sample("stewart:platforms=4");
  const Equations<double> at = guess_of(scene);
  for (int i = 1; i <= 4; ++i) {
    for (int j = 1; j < i; ++j) {
      const Vec<double> d = at.at("O_" + std::to_string(i)) - at.at("O_" + std::to_string(j));
      EXPECT_GT(std::sqrt(dot(d, d)), 0.01);
    }
  }
}

// Jacobian of one leg in the unknowns B, e, r, c, d, from its 15 equations in the references.
Eigen::Matrix<double, 15, 15> leg_jacobian(const Equations<double>& at, const std::string& k) {
  const auto row = [&](const std::string& name) {
    const Vec<double>& v = at.at(name + k);
    return Eigen::RowVector3d(v[0], v[1], v[2]);
  };
  Eigen::Matrix<double, 15, 15> J = Eigen::Matrix<double, 15, 15>::Zero();
  enum { B = 0, e = 3, r = 6, c = 9, d = 12 };
  J.block<3, 3>(0, B).setIdentity();
  J.block<3, 3>(0, e) = -0.2 * Eigen::Matrix3d::Identity();
  J.block<1, 3>(3, e) = 2 * row("e");
  J.block<1, 3>(4, e) = row("a");
  J.block<3, 3>(5, B) = -Eigen::Matrix3d::Identity();
  J.block<3, 3>(5, r) = -0.55 * Eigen::Matrix3d::Identity();
  J.block<1, 3>(8, r) = 2 * row("r");
  J.block<1, 3>(9, c) = 2 * row("c");
  J.block<1, 3>(10, c) = row("r");
  J.block<1, 3>(10, r) = row("c");
  J.block<1, 3>(11, c) = row("t");
  J.block<1, 3>(12, d) = 2 * row("d");
  J.block<1, 3>(13, d) = row("r");
  J.block<1, 3>(13, r) = row("d");
  J.block<1, 3>(14, d) = row("c");
  J.block<1, 3>(14, c) = row("d");
  return J;
}

double condition(const Eigen::MatrixXd& J) {
  const Eigen::VectorXd sigma = Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues();
  return sigma[0] / sigma[sigma.size() - 1];
}

double worst_leg_condition(int legs) {
  const Scene scene = sample("stewart:legs=" + std::to_string(legs));
  double worst = 0;
  for (double t = 0; t < 2 * std::numbers::pi; t += 0.2) {
    Posture<double> posture = at_guess<double>(scene);
    for (const auto& [name, at] : stewart(scene, t)) {
      for (std::size_t i = 0; i < 3; ++i) posture[name][i] = static_cast<double>(at[i].value);
    }
    const Equations<double> at(scene, posture);
    for (int k = 1; k <= legs; ++k) worst = std::max(worst, condition(leg_jacobian(at, std::to_string(k))));
  }
  return worst;
}

TEST(Stewart, LegsStayRegular) {
  EXPECT_NEAR(worst_leg_condition(6), 23, 0.5);  // known to two digits for this geometry
}

TEST(Stewart, EvenLegsStayRegular) {
  for (const int legs : {3, 4, 5, 7, 16, 22}) EXPECT_LE(worst_leg_condition(legs), 23) << legs;
}

// Jacobian of the ring with the points NAME0, NAME1, ... for squared lengths.
Eigen::MatrixXd ring_jacobian(const Equations<double>& at, const std::string& name, int m) {
  const auto point = [&](const std::string& kind, int i) {
    const Vec<double>& v = at.at(name + kind + std::to_string(i));
    return Eigen::RowVector2d(v[0], v[1]);
  };
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2 * m, 2 * m);
  for (int i = 0; i < m; ++i) {
    const int next = (i + 1) % m;
    const Eigen::RowVector2d rod = point("", i) - point("A", i), link = point("", i) - point("", next);
    EXPECT_NEAR(rod.norm(), 1, 1e-13);
    J.block<1, 2>(2 * i, 2 * i) = 2 * rod;
    J.block<1, 2>(2 * i + 1, 2 * i) = 2 * link;
    J.block<1, 2>(2 * i + 1, 2 * next) = -2 * link;
  }
  return J;
}

TEST(Rings, ConditionIsBetween5And16) {
  for (const int n : {12, 14, 16, 18, 24, 30, 36, 60, 90, 120, 150, 240, 720}) {
    const Scene scene = sample("rings:legs=1,n=" + std::to_string(n) + ",terminal=12");
    const double kappa = condition(ring_jacobian(guess_of(scene), "L1_", n / 2));
    EXPECT_GE(kappa, 5) << n;
    EXPECT_LE(kappa, 16) << n;
  }
}

TEST(Rings, HaveThreeNonzerosInARow) {
  const Scene scene = sample("rings:legs=3,n=40,terminal=16");
  ASSERT_EQ(scene.groups().size(), 4u);
  for (const DeclaredGroup& group : scene.groups()) {
    const std::set<std::string> unknowns(group.unknowns.begin(), group.unknowns.end());
    std::size_t equations = 0, nonzeros = 0;
    for (const Constraint& c : scene.constraints()) {
      const auto& distance = *c.as<Distance>();
      const std::size_t ends = unknowns.count(distance.p) + unknowns.count(distance.q);
      nonzeros += 2 * ends;
      if (ends > 0) ++equations;
    }
    EXPECT_EQ(equations, 2 * unknowns.size());  // square: as many as there are coordinates
    EXPECT_EQ(nonzeros, 3 * equations);
  }
  EXPECT_EQ(scene.groups()[0].unknowns.size(), 8u);
  EXPECT_EQ(scene.groups()[3].unknowns.size(), 20u);
}

TEST(Andrews, GuessIsTheFirstRowOfTheReference) {
  const std::vector<AndrewsRow> rows = read_andrews();
  ASSERT_EQ(rows.size(), 72u);
  const Posture<double> guess = at_guess<double>(sample("andrews"));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(guess.at("E")[i], static_cast<double>(rows[0].E[i].value), 1e-15);
    EXPECT_NEAR(guess.at("G")[i], static_cast<double>(rows[0].G[i].value), 1e-15);
    EXPECT_NEAR(guess.at("H")[i], static_cast<double>(rows[0].H[i].value), 1e-15);
  }
}

TEST(Andrews, MeetsTheTimesOfTheReference) {
  const Scene scene = sample("andrews");
  const std::vector<AndrewsRow> rows = read_andrews();
  EXPECT_EQ(scene.time().steps(), 72);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    EXPECT_NEAR(scene.time().time(static_cast<std::int64_t>(k)), static_cast<double>(rows[k].beta), 1e-15 * 2 * 3.2);
  }
}

TEST(Andrews, TheMisprintChangesOnlyThePoint) {
  const Triple misprinted = {0.03635, 0.03273, 0};
  const Scene right = sample("andrews"), wrong = sample("andrews", {{"xb", 0.03635}});
  for (std::size_t i = 0; i < right.points().size(); ++i) {
    const Point &a = right.points()[i], &b = wrong.points()[i];
    EXPECT_EQ(b.at, a.name == "B" ? misprinted : a.at) << a.name;
  }
}

// ---- size

TEST(SampleSize, BuildsLargeSamples) {
  const Scene chain = sample("four_bar:30000");
  EXPECT_EQ(chain.points().size(), 60002u);
  EXPECT_EQ(chain.constraints().size(), 60001u);
  const Scene fleet = sample("stewart:platforms=3000");
  EXPECT_EQ(fleet.groups().size(), 21000u);
  EXPECT_EQ(fleet.bodies().size(), 3000u);
}

}  // namespace
}  // namespace assur
