#include "check/makers.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "check/matrices.hpp"
#include "mechanisms/random_mechanism.hpp"
#include "numbers.hpp"
#include "scene/law_evaluate.hpp"

namespace assur::check {
namespace {

// The value of a parameter, or its default.
double get(const Parameters& set, const std::string& name, double otherwise) {
  const auto found = set.find(name);
  return found == set.end() ? otherwise : found->second.value();
}

// A callback with n equations A (x - c s) = 0 and the known solution x_i = c_i s(t). s oscillates; c_i is 1/2, 1 or 2.
// Row i of A is scaled by 10^(-grade i / n).
Made callback_matrix(const Dense& a, double grade) {
  const std::size_t n = a.size();
  const auto c = [](std::size_t i) { return std::ldexp(1.0, static_cast<int>(i % 3) - 1); };
  Callback callback;
  callback.equations = static_cast<int>(n);
  const Law law = Law::harmonics({{0.25, 1, 0.3}}, 1);
  SceneBuilder builder("callback_matrix", 2);
  for (std::size_t i = 0; i < n; i += 2) {
    const std::string name = "X" + std::to_string(i / 2);
    builder.point(name, {c(i), c(i + 1), 0});
    callback.coordinates.insert(callback.coordinates.end(), {name + ".x", name + ".y"});
  }
  callback.coordinates.emplace_back("S.x");
  std::vector<double> matrix;  // n x (n + 1), row-major
  for (std::size_t i = 0; i < n; ++i) {
    const double factor = std::pow(10.0, -grade * static_cast<double>(i) / static_cast<double>(n));
    long double sum = 0;
    for (std::size_t j = 0; j < n; ++j) {
      matrix.push_back(factor * a[i][j]);
      sum += static_cast<long double>(matrix.back()) * c(j);
    }
    matrix.push_back(-static_cast<double>(sum));
  }
  callback.jacobian = [matrix](std::span<const double>, std::span<double> j) {
    std::copy(matrix.begin(), matrix.end(), j.begin());
  };
  callback.residual = [matrix, n](std::span<const double> x, std::span<double> phi) {
    for (std::size_t i = 0; i < n; ++i) {
      phi[i] = 0;
      for (std::size_t j = 0; j <= n; ++j) phi[i] += matrix[i * (n + 1) + j] * x[j];
    }
  };
  callback.curvature = [](std::span<const double>, std::span<const double>, std::span<double> out) {
    std::fill(out.begin(), out.end(), 0.0);
  };
  builder.point("S", {1, 0, 0})
      .drive("motor", DrivenCoordinate{"S.x", law})
      .constrain("level", FixedCoordinate{"S.y", 0})
      .constrain("matrix", std::move(callback));
  const ClosedForm solution = [law, c](const std::string& output, double t) -> std::optional<std::array<LongJet, 3>> {
    if (output[0] != 'X') return std::nullopt;
    const auto i = static_cast<std::size_t>(2 * std::stoi(output.substr(1)));
    const LongJet s = evaluate<long double>(law, static_cast<long double>(t));
    return std::array<LongJet, 3>{s * c(i), s * c(i + 1), LongJet{}};
  };
  return {builder.time(0, 1, 0.05).build(), solution};
}

Dense dense(const std::string& name, const Parameters& set) {
  Parameters rest = set;
  rest.erase("grade");
  return matrix(name, rest);
}

// A four-bar whose crank follows a law that is a function of the program.
SceneBuilder four_bar(Law law) {
  SceneBuilder builder("four_bar", 2);
  builder.fixed_point("A", {0, 0, 0}).fixed_point("D", {2, 0, 0}).point("B", {0.8, 0, 0}).point("C", {1.6, 1.2, 0});
  builder.constrain("crank", Distance{"A", "B", 0.8}).constrain("coupler", Distance{"B", "C", 1.8});
  builder.constrain("rocker", Distance{"D", "C", 1.3});
  builder.drive("motor", PointAngle{"A", "B", "", std::move(law)});
  return builder;
}

// The value of the law is `bad` (NaN or infinite) from t = 0.5 s on.
Made law_to(double bad) {
  const Law law = Law::function([bad](double t) { return t < 0.5 ? Motion{t, 1, 0} : Motion{bad, bad, bad}; });
  return {four_bar(law).time(0, 1, 0.05).build(), nullptr};
}

// A callback |B - C| = 1.8 that overflows from t = 0.5 s on.
Made callback_to_infinity() {
  SceneBuilder builder("callback_to_infinity", 2);
  builder.fixed_point("A", {0, 0, 0}).point("C", {1.6, 1.2, 0}).point("S", {0, 0, 0});
  builder.drive("motor", PointAngle{"A", "C", "", Law::polynomial({0.6, 1})});
  builder.drive("clock", DrivenCoordinate{"S.x", Law::polynomial({0, 1})});
  Callback callback;
  callback.coordinates = {"S.x", "S.y"};
  callback.equations = 1;
  const auto bad = [](double t) { return t < 0.475 ? 1.0 : kInfinity; };
  callback.residual = [bad](std::span<const double> x, std::span<double> phi) { phi[0] = bad(x[0]) * (x[1] - x[0]); };
  callback.jacobian = [bad](std::span<const double> x, std::span<double> j) { j[0] = -bad(x[0]), j[1] = bad(x[0]); };
  callback.curvature = [](std::span<const double>, std::span<const double>, std::span<double> out) { out[0] = 0; };
  return {builder.constrain("follow", std::move(callback)).time(0, 1, 0.05).build(), nullptr};
}

// A crank that follows a table: sin t at `points` knots from 0 to `end`.
Made table(const Parameters& set) {
  const int points = static_cast<int>(get(set, "points", 4));
  const double end = get(set, "end", 1);
  std::vector<double> time, value;
  for (int i = 0; i < points; ++i) {
    time.push_back(end * i / (points - 1));
    value.push_back(std::sin(time.back()));
  }
  return {four_bar(Law::table(time, value)).time(0, 1, 0.05).build(), nullptr};
}

// One crank with `count` dyads on its end, all on one level, which differ in their lengths. The ground point of the
// middle dyad is so far away that its bars come within `gap` rad of being in line, at the angle 1.
Made wide(const Parameters& set) {
  const int count = static_cast<int>(get(set, "count", 10000));
  const double gap = get(set, "gap", 0);
  const Law law = Law::polynomial({0.5, 1});
  struct Dyad {
    Triple ground;
    double coupler, rocker;
  };
  std::vector<Dyad> dyads;
  for (int i = 0; i < count; ++i) dyads.push_back({{2, 0, 0}, 1.8, 1.3 + 0.1 * i / count});
  if (gap > 0) {
    Dyad& near = dyads[dyads.size() / 2];
    near.coupler = 1;  // |B - D|^2 = 5 - 4 cos(angle) where the bars are in line
    near.rocker = std::sqrt(5 - 4 * std::cos(1 + gap)) - 1;
  }
  SceneBuilder builder("wide", 2);
  const Triple b = {std::cos(0.5), std::sin(0.5), 0};
  const auto start = on_circle({0, 0, 0}, 1, LongJet{0.5L, 0, 0});
  builder.fixed_point("A", {0, 0, 0}).point("B", b).constrain("crank", Distance{"A", "B", 1.0});
  builder.drive("motor", PointAngle{"A", "B", "", law});
  for (std::size_t i = 0; i < dyads.size(); ++i) {
    const std::string k = std::to_string(i), C = "C" + k, D = "D" + k;
    const auto at = meet(start, dyads[i].coupler, dyads[i].ground, dyads[i].rocker);
    builder.fixed_point(D, dyads[i].ground)
        .point(C, {static_cast<double>(at[0].value), static_cast<double>(at[1].value), 0})
        .constrain("coupler" + k, Distance{"B", C, dyads[i].coupler})
        .constrain("rocker" + k, Distance{D, C, dyads[i].rocker});
  }
  const ClosedForm solution = [law, dyads](const std::string& output,
                                           double t) -> std::optional<std::array<LongJet, 3>> {
    const auto end = on_circle({0, 0, 0}, 1, evaluate<long double>(law, static_cast<long double>(t)));
    if (output == "B") return end;
    const Dyad& d = dyads[static_cast<std::size_t>(std::stoi(output.substr(1)))];
    return meet(end, d.coupler, d.ground, d.rocker);
  };
  return {builder.time(0, 0.5, 0.05).build(), solution};
}

}  // namespace

Made make(const std::string& maker, const Parameters& set) {
  constexpr const char* kMatrix = "callback_";
  if (maker == "law_to_nan") return law_to(kNan);
  if (maker == "law_to_infinity") return law_to(kInfinity);
  if (maker == "callback_to_infinity") return callback_to_infinity();
  if (maker == "table") return table(set);
  if (maker == "wide") return wide(set);
  if (maker == "random_mechanism") {
    return {mechanisms::random_mechanism(static_cast<std::uint64_t>(get(set, "seed", 1))).scene(), nullptr};
  }
  if (maker.starts_with(kMatrix)) {
    return callback_matrix(dense(maker.substr(std::string(kMatrix).size()), set), get(set, "grade", 0));
  }
  throw Error(Error::Kind::input, "there is no maker '" + maker + "'");
}

}  // namespace assur::check
