// Four-bar linkages: a chain of crank-rockers, a chain of rhombi, a chain of parallelograms, and a four-bar that is
// almost a parallelogram.
#include <numbers>
#include <string>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {
namespace {

std::string number(std::string_view name, int i) { return std::string(name) + std::to_string(i); }

// Points A_i are fixed; B_i is the end of the crank (i = 0) or rocker about A_i; couplers join B_i and B_{i+1}.
struct Chain {
  SceneBuilder builder;
  Triple end{};  // B of the last loop

  Chain(std::string name, const Triple& a, const Triple& b, double crank, Law law)
      : builder(std::move(name), 2), end(b) {
    builder.fixed_point("A0", a)
        .point("B0", b)
        .constrain("crank", Distance{"A0", "B0", crank})
        .drive("motor", PointAngle{"A0", "B0", "", std::move(law)});
  }

  // Adds loop i, with its rocker about a; b: guess of B_{i+1}.
  void add_loop(int i, const Triple& a, const Triple& b, double coupler, const Number& rocker) {
    const std::string A = number("A", i + 1), B = number("B", i + 1);
    builder.fixed_point(A, a)
        .point(B, b)
        .constrain(number("coupler", i + 1), Distance{number("B", i), B, coupler})
        .constrain(number("rocker", i + 1), Distance{A, B, rocker});
    end = b;
  }

  Scene finish(int loops, const Values& values) {
    builder.measure("rocker_angle", AbsoluteAngle{number("A", loops), number("B", loops)});
    builder.time(0, values.plain("steps") * values.plain("step"), values.plain("step"));
    return std::move(builder).build();
  }
};

}  // namespace

// A_i = (2i, 0); crank 0.8, coupler 1.8 in the first loop and 2 in the others, rockers 1.3; B_{i+1} to the left of
// B_i -> A_{i+1}.
Scene four_bar(const Values& values) {
  const int loops = values.count("loops");
  const double crank = 0.8, rocker = 1.3;
  Chain chain("four_bar", {0, 0, 0}, {crank, 0, 0}, crank, Law::polynomial({0, values["omega"]}));
  for (int i = 0; i < loops; ++i) {
    const double coupler = i == 0 ? 1.8 : 2;
    const Triple a = {2.0 * (i + 1), 0, 0};
    chain.add_loop(i, a, meet(chain.end, coupler, a, rocker), coupler, rocker);
  }
  return chain.finish(loops, values);
}

// Benchmark A02 of the IFToMM library as kinematics: A_i = (i, 0), all links 1, all parallel to the crank at f(t) =
// pi/2 + swing sin t. All loops are singular together at sin f = 0, which a swing of 1.2 does not reach.
Scene n_four_bar(const Values& values) {
  const int loops = values.count("loops");
  Chain chain("n_four_bar", {0, 0, 0}, {0, 1, 0}, 1, wave(values["swing"], 1, 0, std::numbers::pi / 2));
  for (int i = 0; i < loops; ++i) {
    const double x = i + 1;
    chain.add_loop(i, {x, 0, 0}, {x, 1, 0}, 1, 1);
  }
  return chain.finish(loops, values);
}

// Parallelograms in series: A_i = (2i, 0), rods 1, couplers 2, all rods parallel to the crank at f(t) = pi/2 + 1.2 sin
// t. A third rod about G_i holds the middle M_i of each coupler: it is redundant, or a contradiction if it is too long.
Scene parallelograms(const Values& values) {
  const int loops = values.count("loops");
  Chain chain("parallelograms", {0, 0, 0}, {0, 1, 0}, 1, wave(1.2, values["omega"], 0, std::numbers::pi / 2));
  for (int i = 0; i < loops; ++i) {
    const double x = 2 * (i + 1);
    chain.add_loop(i, {x, 0, 0}, {x, 1, 0}, 2, 1);
    const std::string G = number("G", i + 1), M = number("M", i + 1);
    chain.builder.fixed_point(G, {x - 1, 0, 0})
        .add(Body{number("bar", i + 1), "", {}, {number("B", i), number("B", i + 1)}, {{M, {1, 0, 0}}}, {}})
        .constrain(number("third", i + 1), Distance{G, M, 1 + values["excess"]});
  }
  return chain.finish(loops, values);
}

// Ground 2, crank 1, coupler 2, rocker 1 + delta; one turn per second, from crank angle pi/2 on the parallelogram's
// side. For delta > 0 the rocker stays on that side. It passes the change point of the parallelogram (crank angle pi)
// at a distance that vanishes with delta.
Scene almost_parallelogram(const Values& values) {
  const Number rocker = 1 + values["delta"];
  const Triple a = {2, 0, 0}, b = {0, 1, 0};
  Chain chain("almost_parallelogram", {0, 0, 0}, b, 1, Law::polynomial({std::numbers::pi / 2, kTurn}));
  chain.add_loop(0, a, meet(b, 2, a, rocker), 2, rocker);
  return chain.finish(1, values);
}

}  // namespace assur::samples
