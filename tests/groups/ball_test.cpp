// Midpoint-radius arithmetic and the proof of solutions, compared with exact rational arithmetic.
#include "groups/ball.hpp"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <vector>

#include "groups/newton_kantorovich.hpp"
#include "properties/small_random_scenes.hpp"
#include "scene/law_evaluate.hpp"
#include "verification/quad.hpp"

namespace assur {
namespace {

using Exact = boost::multiprecision::cpp_rational;
using Long = boost::multiprecision::cpp_bin_float_100;
using test::Draw;

double any_double(Draw& draw) { return std::ldexp(draw.real(-1, 1), static_cast<int>(draw.below(80)) - 40); }

double any_radius(Draw& draw, double middle) {
  const double relative[] = {0, 1e-30, 1e-16, 1e-3, 2};
  return relative[draw.below(5)] * std::abs(middle);
}

template <class S>
S any_middle(Draw& draw) {
  const double high = any_double(draw);
  return S(high) + S(high) * S(draw.real(-1, 1) * 0x1p-53);  // all bits of a quad are used
}

// Checks every corner of a and b, where the operations have their extremes.
template <class S, class Operation>
void expect_held(const Ball<S>& a, const Ball<S>& b, const Ball<S>& result, Operation&& operation) {
  for (const int i : {-1, 1}) {
    for (const int j : {-1, 1}) {
      const Exact x = Exact(a.middle()) + i * Exact(a.radius()), y = Exact(b.middle()) + j * Exact(b.radius());
      EXPECT_LE(abs(operation(x, y) - Exact(result.middle())), Exact(result.radius()));
    }
  }
}

template <class S>
void expect_operations_to_hold_their_results(std::uint64_t seed) {
  Draw draw(seed);
  for (int k = 0; k < 300; ++k) {
    const S p = any_middle<S>(draw), q = any_middle<S>(draw);
    const Ball<S> a(p, any_radius(draw, static_cast<double>(p))), b(q, any_radius(draw, static_cast<double>(q)));
    expect_held(a, b, a + b, [](const Exact& x, const Exact& y) { return Exact(x + y); });
    expect_held(a, b, a - b, [](const Exact& x, const Exact& y) { return Exact(x - y); });
    expect_held(a, b, a * b, [](const Exact& x, const Exact& y) { return Exact(x * y); });
    expect_held(a, a, -a, [](const Exact& x, const Exact&) { return Exact(-x); });
    const Ball<S> quotient = a / b;
    if (b.radius() >= std::abs(static_cast<double>(q))) {
      EXPECT_EQ(quotient.radius(), HUGE_VAL);
    } else {
      expect_held(a, b, quotient, [](const Exact& x, const Exact& y) { return Exact(x / y); });
    }
    EXPECT_GE(Exact(a.magnitude()), Exact(abs(Exact(a.middle())) + Exact(a.radius())));
  }
}

TEST(Ball, OperationsEncloseEveryResult) {
  expect_operations_to_hold_their_results<double>(1);
  expect_operations_to_hold_their_results<Quad>(2);
}

// The radius of a product of exact operands is a few units in the last place.
TEST(Ball, IsNarrow) {
  Draw draw(3);
  for (int k = 0; k < 100; ++k) {
    const Ball<Quad> product = Ball<Quad>(any_double(draw)) * Ball<Quad>(any_double(draw));
    EXPECT_LE(product.radius(), 0x1p-111 * product.magnitude());
  }
}

TEST(Ball, BoundsLieOutsideTheNextDouble) {
  Draw draw(4);
  for (int k = 0; k < 1000; ++k) {
    const double x = std::ldexp(draw.real(0.5, 1), -static_cast<int>(draw.below(1074)));
    EXPECT_GE(up(x), std::nextafter(x, HUGE_VAL));
    EXPECT_LE(down(x), std::nextafter(x, -HUGE_VAL));
  }
  EXPECT_GT(up(0), 0);
  EXPECT_EQ(up(HUGE_VAL), HUGE_VAL);
}

// ---- laws

void expect_value_held(const Law& law, double t) {
  const Ball<Quad> value = evaluate<Ball<Quad>>(law, Ball<Quad>(t)).value;
  const Long exact = evaluate<Long>(law, Long(t)).value;
  EXPECT_LE(abs(exact - Long(value.middle())), Long(value.radius())) << "t = " << t;
  EXPECT_LE(value.radius(), 1e-26 * (1 + value.magnitude())) << "t = " << t;
}

TEST(Ball, EnclosesValuesOfLaws) {
  const std::vector<Law> laws = {
      Law::polynomial({1, -5, 10, -10, 5, -1}),  // (1 - t)^5: cancels near 1
      Law::harmonics({{0.7, 1.3, 0.4}, {1e-3, 1e4, 2}}, 0.1),
      Law::table({0, 0.3, 0.7, 1.1, 2}, {1, 1.4, 0.2, -0.3, 0.1}),
      Law::table({0, 0.3, 0.7, 1.1, 2}, {1, 1.4, 0.2, -0.3, 1}, true),
  };
  for (const Law& law : laws) {
    for (const double t : {0.0, 0.1, 0.3, 0.99999, 1.0, 1.7, 1.999}) expect_value_held(law, t);
  }
  for (const double t : {-3.3, 17.0, 12345.678}) expect_value_held(laws[3], t);
  for (const double t : {12.5, 1e5 + 0.1}) expect_value_held(laws[1], t);
}

TEST(Ball, EnclosesSinesAndCosines) {
  Draw draw(5);
  for (int k = 0; k < 200; ++k) {
    const double x = any_double(draw), radius = draw.maybe() ? 0 : draw.real(0, 1e-3);
    const Ball<Quad> a(Quad(x), radius), s = sin(a), c = cos(a);
    for (const int side : {-1, 0, 1}) {
      const Long at = Long(x) + side * Long(radius);
      EXPECT_LE(abs(sin(at) - Long(s.middle())), Long(s.radius())) << x;
      EXPECT_LE(abs(cos(at) - Long(c.middle())), Long(c.radius())) << x;
    }
  }
}

// ---- matrices

TEST(BallMatrix, ProductEnclosesEveryProduct) {
  Draw draw(6);
  for (const Eigen::Index n : {1, 3, 17}) {
    Eigen::MatrixXd c(n, n);
    BallMatrix x{Eigen::MatrixXd(n, 2), Eigen::MatrixXd(n, 2)};
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) c(i, j) = any_double(draw);
      for (Eigen::Index j = 0; j < 2; ++j) {
        x.middle(i, j) = any_double(draw);
        x.radius(i, j) = j == 0 ? 0 : any_radius(draw, x.middle(i, j));
      }
    }
    const BallMatrix result = product(c, x);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < 2; ++j) {
        Exact middle = 0, radius = 0;  // the farthest corner is at middle + radius
        for (Eigen::Index k = 0; k < n; ++k) {
          middle += Exact(c(i, k)) * Exact(x.middle(k, j));
          radius += abs(Exact(c(i, k))) * Exact(x.radius(k, j));
        }
        EXPECT_LE(abs(middle - Exact(result.middle(i, j))) + radius, Exact(result.radius(i, j)));
      }
    }
  }
}

// ---- the theorem

BallMatrix rounded(const std::vector<Exact>& exact, Eigen::Index rows) {
  const auto columns = static_cast<Eigen::Index>(exact.size()) / rows;
  BallMatrix out{Eigen::MatrixXd(rows, columns), Eigen::MatrixXd(rows, columns)};
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < columns; ++j) {
      const Exact& x = exact[static_cast<std::size_t>(i * columns + j)];
      out.middle(i, j) = static_cast<double>(x);
      out.radius(i, j) = up(static_cast<double>(Exact(abs(x - Exact(out.middle(i, j))))));
    }
  }
  return out;
}

// x^2 = h around x = s + d, where h = s^2 + e is known within e; the other solution is -s.
SolutionProof prove_root(double s, double d, double e) {
  const Exact x = Exact(s) + Exact(d), h = Exact(s) * Exact(s) + Exact(e);
  ProofEquations equations{rounded({x * x - h}, 1), rounded({2 * x}, 1), rounded({Exact(-1)}, 1),
                           Eigen::VectorXd::Constant(1, std::abs(e)),
                           [](const Eigen::VectorXd& r) { return Eigen::VectorXd(r.cwiseProduct(r)); }};
  return prove_solution(equations);
}

TEST(SolutionProof, HoldsUpToTheOtherSolution) {
  for (const double s : {1.0, 1e-3, 1e-6}) {
    for (const double d : {0.0, 1e-12 * s, -1e-3 * s, 0.2 * s}) {
      const SolutionProof proof = prove_root(s, d, 0);
      ASSERT_TRUE(proof.holds) << s << " " << d;
      EXPECT_GE(proof.radius[0], std::abs(d));
      // The bounds of the theorem are known here. With Y = |d (2 s + d) / (2 x)| and B = 1 / (2 x), its smaller root is
      // at least |d|, and the larger one is 2 s + d for d > 0.
      EXPECT_LE(proof.radius[0], (d > 0 ? 1 + 1e-11 : 1.01) * std::abs(d) + 1e-15 * s);
      EXPECT_LE(proof.uniqueness, 2 * s + d);
      EXPECT_GE(proof.uniqueness, 1.9 * s);
    }
  }
}

TEST(SolutionProof, CoversTheRangesOfItsInputs) {
  const double s = 0.5;
  for (const double e : {1e-14, 1e-9, -1e-4}) {
    const SolutionProof proof = prove_root(s, 0, e);
    ASSERT_TRUE(proof.holds);
    // The interval of h includes s^2, whose root is x, and s^2 + 2 e, whose root is about e / s away.
    EXPECT_GE(proof.radius[0], std::abs(std::sqrt(s * s + 2 * e) - s) - 1e-16);
    EXPECT_LE(proof.radius[0], 1.01 * std::abs(2 * e) / (2 * s) + 1e-15);
  }
}

// x^2 = h has no real solution for h < 0. A solution too far from x is not found.
TEST(SolutionProof, FailsWithoutANearbySolution) {
  const auto none = [](double x, double h) {
    ProofEquations equations{rounded({Exact(x) * Exact(x) - Exact(h)}, 1),
                             rounded({2 * Exact(x)}, 1),
                             {Eigen::MatrixXd(1, 0), Eigen::MatrixXd(1, 0)},
                             Eigen::VectorXd(0),
                             [](const Eigen::VectorXd& r) { return Eigen::VectorXd(r.cwiseProduct(r)); }};
    return prove_solution(equations);
  };
  for (const double x : {1e-3, 0.1, 10.0}) EXPECT_FALSE(none(x, -1e-12).holds);
  EXPECT_FALSE(none(1, 0).holds);    // double root
  EXPECT_FALSE(none(0, 1).holds);    // singular Jacobian
  EXPECT_FALSE(none(0.4, 1).holds);  // 4 B Y = (1 - x^2) / x^2 > 1
  EXPECT_TRUE(none(0.8, 1).holds);
  EXPECT_EQ(none(0, 1).defect, HUGE_VAL);
}

// Three equations that couple all unknowns and have a known solution.
TEST(SolutionProof, HoldsForIllConditionedSystems) {
  Draw draw(7);
  for (int k = 0; k < 200; ++k) {
    constexpr int n = 3;
    const double spread = std::pow(10, -draw.real(0, 9));  // relative difference between the last two equations
    double linear[n][n], square[n][n], solution[n], off[n];
    for (int i = 0; i < n; ++i) {
      solution[i] = draw.real(-1, 1);
      off[i] = draw.real(-1, 1) * 1e-13;
      for (int j = 0; j < n; ++j) {
        linear[i][j] = draw.real(-1, 1);
        square[i][j] = draw.real(-1, 1);
        if (i == n - 1) linear[i][j] = linear[i - 1][j] + spread * linear[i][j];
        if (i == n - 1) square[i][j] = square[i - 1][j] + spread * square[i][j];
      }
    }
    std::vector<Exact> phi, jacobian;
    for (int i = 0; i < n; ++i) {
      Exact sum = 0;
      for (int j = 0; j < n; ++j) {
        const Exact root = solution[j], x = root + Exact(off[j]);
        sum += Exact(linear[i][j]) * (x - root) + Exact(square[i][j]) * (x * x - root * root);
        jacobian.push_back(Exact(linear[i][j]) + 2 * Exact(square[i][j]) * x);
      }
      phi.push_back(sum);
    }
    ProofEquations equations{rounded(phi, n),
                             rounded(jacobian, n),
                             {Eigen::MatrixXd(n, 0), Eigen::MatrixXd(n, 0)},
                             Eigen::VectorXd(0),
                             [&](const Eigen::VectorXd& r) {
                               Eigen::VectorXd out(n);
                               for (int i = 0; i < n; ++i) {
                                 out[i] = 0;
                                 for (int j = 0; j < n; ++j) {
                                   out[i] = up(out[i] + up(std::abs(square[i][j]) * up(r[j] * r[j])));
                                 }
                               }
                               return out;
                             }};
    const SolutionProof proof = prove_solution(equations);
    if (!proof.holds) {
      EXPECT_LE(spread, 1e-5);  // 4 B Y is about 1e-13 / spread^2
      continue;
    }
    for (int i = 0; i < n; ++i) EXPECT_LE(std::abs(off[i]), proof.radius[i]);
  }
}

}  // namespace
}  // namespace assur
