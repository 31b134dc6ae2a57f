// Jacobian matrices against differences of the reference in quadruple precision, and against rates of the motion.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "assur/eigen.hpp"
#include "backends/allocations.hpp"
#include "equations/outputs.hpp"
#include "outputs/output_program.hpp"
#include "plan/preparation.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"
#include "verification/reference_motion.hpp"

namespace assur {
namespace {

// Shift of a driver, SI units. Its square is far below 1e-8, and it is far above the rounding of quad; gears are
// functions in double.
double shift_for(const Scene& scene) {
  const auto is_gear = [](const Constraint& c) { return c.as<Gear>() != nullptr || c.as<Callback>() != nullptr; };
  return std::ranges::any_of(scene.constraints(), is_gear) ? 0x1p-18 : 0x1p-40;
}

// All mechanisms of scenes/, and all samples.
std::vector<Scene> shipped() {
  std::vector<Scene> out;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(ASSUR_SOURCE_DIR "/scenes")) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() == ".json" && file.filename() != "scene.schema.json") files.push_back(file);
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) out.push_back(read_scene(file));
  for (const char* text : {"four_bar:3", "rings:legs=3,n=18", "hexapod", "bricard", "whitworth"}) {
    if (is_sample(text)) out.push_back(sample(text));
  }
  return out;
}

std::vector<std::string> names_of_drivers(const Scene& scene) {
  std::vector<std::string> names;
  for (const Driver& d : scene.drivers()) names.push_back(d.name);
  return names;
}

// The values of the outputs at time t in quad, SI units, with the law of one driver shifted, in the order of
// OutputJacobian::outputs.
std::vector<Quad> outputs_of_reference(const Scene& scene, const std::string& driver, double shift, double t) {
  const Scene shifted = scene.with_laws([&](const std::string& name, const Law& before) {
    return name == driver ? before + Law::constant(shift) : before;
  });
  ReferenceMotion motion(prepare(shifted, {.budget = ThreadBudget{1}}));
  motion.advance(t, 16);
  const System& s = motion.system();
  std::vector<Quad> out;
  std::map<std::string, std::size_t, std::less<>> row_of;
  for (const Output& o : wanted_outputs(s)) {
    row_of[std::string(o.name)] = out.size();
    if (o.sum != nullptr) {
      Quad sum = o.sum->constant.value();
      for (const auto& term : o.sum->terms)
        sum += term.factor.value() * out[row_of.at(s.measures[idx(term.measure)].name)];
      out.push_back(sum);
      continue;
    }
    for (const OutputPart& part : o.parts()) {
      Jet<Quad> forms[9];
      for (std::size_t f = 0; f < part.forms.size(); ++f) {
        const auto of = [&](std::size_t d) { return form_value<Quad>(s, part.forms[f], motion.state().q[d]); };
        forms[f] = {of(0), of(1), of(2)};
      }
      out.push_back(evaluate_measure<Quad>(part.kind, {forms, 9}, s.dimension).value * Quad(s.unit(part.dimension)));
    }
  }
  return out;
}

TEST(Jacobian, DifferencesOfTheReferenceOnEveryShippedMechanism) {
  std::size_t mechanisms = 0, entries = 0;
  double worst = 0;
  for (const Scene& scene : shipped()) {
    SCOPED_TRACE(scene.name());
    const double shift = shift_for(scene);
    const double t = scene.time().time(std::min<std::int64_t>(scene.time().steps(), 7));
    Simulator simulator = test::simulator(scene, "auto", {}, names_of_drivers(scene));
    ASSERT_TRUE(simulator.step(t).arrived());
    const OutputJacobian j = simulator.jacobian();
    ASSERT_TRUE(j.status.ok());
    ASSERT_EQ(j.drivers, simulator.drivers());
    ASSERT_FALSE(j.outputs.empty());
    for (std::size_t i = 0; i < j.drivers.size(); ++i) {
      const std::vector<Quad> more = outputs_of_reference(scene, j.drivers[i], shift, t);
      const std::vector<Quad> less = outputs_of_reference(scene, j.drivers[i], -shift, t);
      ASSERT_EQ(more.size(), j.outputs.size());
      for (std::size_t r = 0; r < j.outputs.size(); ++r) {
        const auto change = static_cast<double>(more[r] - less[r]);
        if (std::abs(change) > 6) continue;  // an angle at half a turn
        const double slope = change / (2 * shift), size = std::max(1.0, std::abs(slope));
        worst = std::max(worst, std::abs(j(r, i) - slope) / size);
        EXPECT_NEAR(j(r, i), slope, 1e-8 * size) << j.outputs[r] << " by " << j.drivers[i];
        ++entries;
      }
    }
    ++mechanisms;
  }
  EXPECT_GE(mechanisms, 22U);
  EXPECT_GT(entries, 500U);
  std::ostringstream figure;
  figure << worst;
  RecordProperty("worst", figure.str());
}

// x' = J u', with the rates of the laws as u'. Rows of rates alone, as those of angular velocities, are taken as they
// are.
TEST(Jacobian, TimesTheRatesOfTheDriversGivesTheRatesOfTheOutputs) {
  for (const Scene& scene : shipped()) {
    SCOPED_TRACE(scene.name());
    std::vector<std::string> outputs = {"all"};
    for (const Body& b : scene.bodies()) {
      if (b.name != "ground") outputs.push_back(b.name);
    }
    Scene with_bodies = scene;
    try {
      with_bodies = scene.with_outputs(outputs.size() > 1 ? std::vector(outputs.begin() + 1, outputs.end()) : outputs);
    } catch (const Error&) {  // a body that may turn about its line has no pose
    }
    Simulator simulator = test::simulator(with_bodies, "auto", {}, names_of_drivers(scene));
    ASSERT_TRUE(simulator.step(scene.time().time(3)).arrived());
    const OutputJacobian& j = simulator.jacobian();
    std::vector<double> rates;
    (void)with_bodies.with_laws([&](const std::string&, const Law& law) {
      rates.push_back(law(simulator.time()).rate);
      return law;
    });
    ASSERT_EQ(rates.size(), j.drivers.size());
    double largest = 1;
    for (const double x : simulator.outputs()) largest = std::max(largest, std::isnan(x) ? 0 : std::abs(x));
    std::size_t compared = 0;
    for (std::size_t r = 0; r < j.outputs.size(); ++r) {
      const std::string& name = j.outputs[r];
      const std::size_t dot = name.rfind('.');
      std::string rate = name + ".rate";
      const auto is_column = [&](const std::string& c) {
        return std::count(simulator.columns().begin(), simulator.columns().end(), c) > 0;
      };
      if (!is_column(rate) && dot != std::string::npos) rate = name.substr(0, dot + 1) + "v" + name.substr(dot + 1);
      if (!is_column(rate)) rate = name;  // an angular velocity
      if (rate == name && name.find(".w") == std::string::npos) continue;
      double sum = 0;
      for (std::size_t i = 0; i < rates.size(); ++i) sum += j(r, i) * rates[i];
      EXPECT_NEAR(sum, simulator.output(rate), 1e-10 * largest) << name;
      ++compared;
    }
    EXPECT_GT(compared, 0U);
  }
}

TEST(Jacobian, OfTheLegsOfAStewartPlatformHasSixIndependentColumns) {
  const Scene scene = sample("stewart");
  Simulator simulator = test::simulator(scene, "auto", {}, names_of_drivers(scene));
  const OutputJacobian& j = simulator.jacobian();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(as_matrix(j));
  EXPECT_NEAR(j.smallest_singular_value, svd.singularValues().minCoeff(), 1e-14 * svd.singularValues()[0]);
  EXPECT_GT(j.smallest_singular_value, 1e-3);
}

// A four-bar whose coupler and rocker are nearly in line: the rocker turns ever faster, and at the fold J is not
// unique.
TEST(Jacobian, SingularAndSingularValue) {
  SceneBuilder b("two_cranks", 2);
  b.fixed_point("A", {0, 0, 0}).point("B", {1, 0, 0}).point("C", {2, 0, 0});
  b.drive("first", PointAngle{"A", "B", "", Law::constant(0)});
  b.drive("second", PointAngle{"B", "C", "", Law::polynomial({0, 1})});
  b.output("C.position").time(0, 1, 0.1);
  Simulator simulator(prepare(b.build(), {.controlled = {"first", "second"}}));
  // Stretched out, both cranks move C along the same line.
  EXPECT_NEAR(simulator.jacobian().smallest_singular_value, 0, 1e-15);
  simulator.set("second", std::numbers::pi / 2);
  ASSERT_TRUE(simulator.step(1).ok());
  // C = (1, 1): columns (0, 1) for the first, as its angle alone moves B and carries no direction of BC, and (-1, 0).
  EXPECT_NEAR(simulator.jacobian().smallest_singular_value, 1, 1e-14);
}

// Derivatives that are asked for apart do not count again.
TEST(Jacobian, HasOneRowForEachComponent) {
  const Scene scene = sample("three_rps");
  const auto rows = [&](std::vector<std::string> outputs) {
    Simulator s = test::simulator(scene.with_outputs(std::move(outputs)), "auto", {}, names_of_drivers(scene));
    return s.jacobian().outputs;
  };
  const std::vector<std::string> all = rows({"plate"});
  EXPECT_EQ(all.size(), 10U);
  EXPECT_EQ(all.back(), "plate.wz");
  EXPECT_EQ(rows({"centre.velocity", "centre.position"}),
            (std::vector<std::string>{"centre.vx", "centre.vy", "centre.vz"}));
  EXPECT_EQ(rows({"plate.angular_acceleration"}).front(), "plate.alphax");
}

TEST(Jacobian, SecondCallAllocatesNothing) {
  for (const char* text : {"stewart", "four_bar:8", "hexapod"}) {
    const Scene scene = sample(text);
    Simulator simulator = test::simulator(scene, "auto", {}, names_of_drivers(scene));
    (void)simulator.jacobian();
    ASSERT_TRUE(simulator.step().arrived());
    const std::int64_t before = test::allocations();
    (void)simulator.jacobian();
    EXPECT_EQ(test::allocations(), before) << text;
  }
}

// A Jacobian in between changes no bit of the motion.
TEST(Jacobian, LeavesTheMotionAlone) {
  for (const std::string strategy : {"auto", "irreducible/lanes:4", "groups/eigen+once", "global/eigen"}) {
    const Scene scene = sample("stewart");
    Simulator with = test::simulator(scene, strategy, {}, names_of_drivers(scene));
    Simulator without = test::simulator(scene, strategy, {}, names_of_drivers(scene));
    for (int k = 1; k <= 20; ++k) {
      (void)with.jacobian();
      ASSERT_TRUE(with.step(0.01 * k).arrived());
      ASSERT_TRUE(without.step(0.01 * k).arrived());
      ASSERT_TRUE(std::ranges::equal(with.outputs(), without.outputs())) << strategy << " " << k;
    }
  }
}

TEST(ConstraintJacobian, OfAFourBarIsItsClosedForm) {
  const Scene scene = sample("four_bar:1").with_outputs({"all"});
  Simulator simulator = test::simulator(scene, "global/eigen");
  ASSERT_TRUE(simulator.step(0.1).ok());
  const ConstraintJacobian j = simulator.constraint_jacobian();
  const Eigen::MatrixXd matrix = as_matrix(j);
  const auto at = [&](const std::string& p, const char* axis) { return simulator.output(p + axis); };
  std::size_t found = 0;
  for (std::size_t r = 0; r < j.equations.size(); ++r) {
    for (std::size_t c = 0; c < j.unknowns.size(); ++c) {
      const double value = matrix(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
      const std::string axis = j.unknowns[c].substr(j.unknowns[c].size() - 2);
      if (j.unknowns[c].substr(0, 2) != "B1") continue;
      if (j.equations[r] == "coupler1") {
        EXPECT_NEAR(value, 2 * (at("B1", axis.c_str()) - at("B0", axis.c_str())), 1e-14);
      } else if (j.equations[r] == "rocker1") {
        EXPECT_NEAR(value, 2 * (at("B1", axis.c_str()) - (axis == ".x" ? 2 : 0)), 1e-14);
      } else {
        continue;
      }
      ++found;
    }
  }
  EXPECT_EQ(found, 4U);
}

TEST(ConstraintJacobian, GroupsAreDiagonalBlocksOfTheWhole) {
  for (const Scene& scene : shipped()) {
    SCOPED_TRACE(scene.name());
    Simulator simulator = test::simulator(scene);
    const ConstraintJacobian all = simulator.constraint_jacobian();
    const Eigen::MatrixXd whole = as_matrix(all);
    ASSERT_EQ(whole.rows(), whole.cols());
    Eigen::Index first = 0;
    for (std::size_t g = 0; g < preparation(simulator.prepared()).structure->groups.size(); ++g) {
      const ConstraintJacobian one = simulator.constraint_jacobian(static_cast<std::int32_t>(g));
      const Eigen::MatrixXd block = as_matrix(one);
      const Eigen::Index n = block.rows();
      EXPECT_EQ(whole.block(first, first, n, n), block);
      EXPECT_EQ(whole.block(first, first + n, n, whole.cols() - first - n).cwiseAbs().sum(), 0);
      EXPECT_TRUE(Eigen::FullPivLU<Eigen::MatrixXd>(block).isInvertible());
      first += n;
    }
    EXPECT_EQ(first, whole.rows());
  }
  EXPECT_THROW((void)test::simulator(sample("four_bar:1")).constraint_jacobian(99), Error);
}

}  // namespace
}  // namespace assur
