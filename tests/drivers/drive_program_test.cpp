// The flat program of the drivers compared with their definition in quad.
#include "drivers/drive_program.hpp"
#include "numbers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "equations/drive.hpp"
#include "equations/lowering.hpp"
#include "references/quad.hpp"

namespace assur {
namespace {

using references::Quad;

using State = std::array<std::vector<double>, 3>;

State at_rest(const System& s) {
  const std::vector<double> zero(s.coordinates.size(), 0.0);
  State x = {zero, zero, zero};
  x[0][kOne] = 1;
  return x;
}

State run(DriveProgram& program, const System& s, double t) {
  State x = at_rest(s);
  program.evaluate(t);
  program.place({x[0].data(), x[1].data(), x[2].data()});
  return x;
}

// Each coordinate is a product of up to three cosines and sines, or a sum of a few laws; its derivatives are sums of up
// to 12 such products. Tolerance: 32 roundings of numbers as large as the laws, their rates and accelerations.
void expect_as_defined(const System& s, double t) {
  const Driven driven = all_driven(s);
  const std::size_t n = s.coordinates.size();
  std::vector<Quad> exact[3] = {std::vector<Quad>(n), std::vector<Quad>(n), std::vector<Quad>(n)};
  exact[0][kOne] = 1;
  double size = 1, speed = 1;
  const auto law = [&](std::size_t input, int k) {
    const Jet<Quad> j = evaluate<Quad>(s.inputs[input].laws[static_cast<std::size_t>(k)], Quad(t));
    size = std::max(size, std::abs(static_cast<double>(j.value)));
    speed = std::max({speed, std::abs(static_cast<double>(j.rate)), std::sqrt(std::abs(double(j.acceleration)))});
    return j;
  };
  drive<Quad>(s, driven, law, exact[0].data(), exact[1].data(), exact[2].data());
  DriveProgram program(s, driven);
  const State x = run(program, s, t);
  EXPECT_TRUE(program.defined());
  double tolerance = 32 * kEps * size;
  for (std::size_t d = 0; d < 3; ++d, tolerance *= 2 * speed) {
    for (std::size_t c = 0; c < n; ++c) {
      ASSERT_NEAR(x[d][c], static_cast<double>(exact[d][c]), tolerance)
          << s.coordinate_name(static_cast<Index>(c)) << ", derivative " << d << ", t = " << t;
    }
  }
}

System system_of(const Scene& scene) { return lower(std::make_shared<const Scene>(scene), {}, false); }

TEST(DriveProgram, ComputesTheDriversOfTheSamples) {
  for (const char* text : {"stewart", "stewart:platforms=3", "four_bar:3", "andrews", "slider_crank", "rings:legs=3",
                           "gough:7", "hexapod", "hexapod:drive=legs"}) {
    SCOPED_TRACE(text);
    const System s = system_of(sample(text));
    ASSERT_FALSE(s.inputs.empty());
    for (const double t : {0.0, 0.01, 0.37}) expect_as_defined(s, t);
  }
}

Law table() { return Law::table({0, 0.5, 1.25, 2}, {0.1, 0.3, -0.2, 0.1}, true); }
// Several terms of every kind; one has a phase too large for the usual reduction.
Law rich() {
  return Law::harmonics({{0.3, 0.7, 0.2}, {0.1, 1.4, -1}, {1e-7, 0.7, 3e6}}, 0.5) + Law::polynomial({0.1, 0.2, -0.1}) +
         Law::harmonics({{0.2, 0.25, 5}, {0, 3, 0}, {0.1, 0.7, 1}}) + table() + Law::function([](double t) {
           return Motion{std::sin(t), std::cos(t), -std::sin(t)};
         });
}

Scene in_space() {
  SceneBuilder b("space", 3);
  b.point("O", {0, 0, 0}).vector("u", {1, 0, 0}).vector("v", {0, 1, 0}).vector("w", {0, 0, 1});
  b.point("X", {1, 2, 3}).fixed_point("A", {0, 0, -9});
  b.add(Body{"body", "O", {"u", "v", "w"}, {}, {{"P", {0.1, 0.2, 0.3}}}, {}});
  b.drive("pose", Pose{"body", {rich(), table(), Law::constant(2)}, {Law::polynomial({0, 2}), rich(), table()}});
  b.drive("x", DrivenCoordinate{"X.x", rich()}).drive("y", DrivenCoordinate{"X.y", Law()});
  b.drive("z", DrivenDistance{"A", "X", Law::constant(12) + rich()});
  return b.time(0, 1, 0.01).build();
}

Scene in_the_plane() {
  SceneBuilder b("plane", 2);
  b.point("O", {0, 0, 0}).vector("u", {1, 0, 0}).fixed_point("A", {-4, 0, 0}).point("B", {-3, 0, 0});
  b.add(Body{"plate", "O", {"u"}, {}, {{"P", {0.3, -0.2, 0}}}, {}}).constrain("arm", Distance{"A", "B", 1.0});
  b.drive("pose", Pose{"plate", {rich(), table()}, {rich()}}).drive("turn", PointAngle{"A", "B", "", rich()});
  return b.time(0, 1, 0.01).build();
}

TEST(DriveProgram, ComputesEveryKindOfDriverAndLaw) {
  for (const Scene& scene : {in_space(), in_the_plane()}) {
    SCOPED_TRACE(scene.name());
    const System s = system_of(scene);
    for (const double t : {0.0, 0.4, 1.9, 7.3}) expect_as_defined(s, t);
  }
}

TEST(DriveProgram, LeavesOutUnusedLaws) {
  const System s = system_of(in_space());
  const auto input = static_cast<std::size_t>(
      std::find_if(s.inputs.begin(), s.inputs.end(), [](const DriverInput& in) { return in.must_not_vanish; }) -
      s.inputs.begin());
  ASSERT_LT(input, s.inputs.size());
  std::vector<std::uint8_t> read(s.coordinates.size(), 0);
  read[static_cast<std::size_t>(s.inputs[input].first)] = 1;
  DriveProgram program(s, driven_behind(s, read));
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    EXPECT_EQ(program.slot(i, 0), i == input ? 0 : -1);
  }
  const State x = run(program, s, 0.3);
  for (std::size_t c = 1; c < s.coordinates.size(); ++c) {
    EXPECT_EQ(x[0][c] != 0, static_cast<Index>(c) == s.inputs[input].first) << s.coordinate_name(static_cast<Index>(c));
  }
}

TEST(DriveProgram, DoesNotCallReplacedLaws) {
  int asked = 0;
  SceneBuilder b("asked", 2);
  b.point("X", {4, 0, 0}).drive("y", DrivenCoordinate{"X.y", Law::table({0, 1}, {0, 1})});
  b.drive("x", DrivenCoordinate{"X.x", Law::function([&asked](double t) {
                                  ++asked;
                                  return Motion{t, 1, 0};
                                })});
  const System s = system_of(b.time(0, 1, 0.1).build());
  DriveProgram program(s, all_driven(s));
  std::size_t x_input = s.scene->drivers()[static_cast<std::size_t>(s.inputs[0].driver)].name == "x" ? 0 : 1;
  const std::int32_t x = program.slot(x_input, 0), y = program.slot(1 - x_input, 0);
  const auto at_x = static_cast<std::size_t>(s.inputs[x_input].first);
  asked = 0;
  EXPECT_EQ(run(program, s, 0.5)[0][at_x], 0.5 / s.unit(1));
  EXPECT_EQ(asked, 1);
  program.hold(x, true);
  (void)run(program, s, 0.5);
  EXPECT_EQ(asked, 1);

  State state = at_rest(s);
  const auto place = [&] { program.place({state[0].data(), state[1].data(), state[2].data()}); };
  program.evaluate(2);  // after the end of the table
  program.replace(x, {3, 4, 5});
  place();
  EXPECT_FALSE(program.defined());
  for (std::size_t d = 0; d < 3; ++d) EXPECT_EQ(state[d][at_x], (3.0 + static_cast<double>(d)) / s.unit(1));
  program.hold(y, true);
  program.evaluate(2);
  program.replace(y, {1, 0, 0});
  place();
  EXPECT_TRUE(program.defined());
}

}  // namespace
}  // namespace assur
