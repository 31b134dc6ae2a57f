#include "modes/homotopy.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <random>

#include "numbers.hpp"

namespace assur {
namespace {

using Complex = std::complex<double>;
constexpr int kMost = static_cast<int>(kMostPolynomials) + 1;  // homogeneous coordinates
using Vector7 = Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, kMost, 1>;
using Matrix7 = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;

// Choices with room. On 96 groups (samples, random chains, mechanisms up to 1e-16 from a fold) and 40 random systems,
// 2,676 paths, no path is lost and all ends have the same kind if one of them is changed: steps by 2 to 4, corrections
// by 10 to 100, shares and exponents by 3 to 100, the others by 1.25 to 2. Only kCertain = 0.05 takes two simple ends
// for multiple ones.
constexpr double kFirstStep = 0.05;      // first step of log t
constexpr double kLongestStep = 0.5;     // longest step of log t
constexpr double kShortestStep = 1e-9;   // step of log t; a path that needs a shorter one is lost
constexpr int kMostSteps = 20000;        // most steps of a path; the tests take 282
constexpr double kPredicted = 1e-5;      // largest first correction, relative to the point: else the step is repeated
constexpr double kEasy = 1e-7;           // a smaller first correction lengthens the step
constexpr double kCorrected = 1e-11;     // last correction
constexpr double kRoughest = 1e-8;       // last correction if rounding allows no smaller one
constexpr double kTested = 0.7;          // change of log t between two tests for the end of a path
constexpr double kLastLog = -32;         // log t where paths end; double solutions are then 1e-7 from their paths
constexpr double kLateLog = -12;         // log t below which a path without a further step is near its end
constexpr double kCertain = 0.25;        // Newton-Kantorovich number of a certain end; the theorem needs 0.5
constexpr double kFar = 1e-6;            // share of the homogenising coordinate below which a solution is at infinity
constexpr double kFarEnough = 1e-3;      // such a share for a path with a steady exponent, at its last step
constexpr double kLeastExponent = 0.04;  // exponent of t in the homogenising coordinate of a path to infinity
constexpr double kSteady = 0.1;          // relative change of that exponent
constexpr int kLongSteady = 4;           // tests in a row with such a change
constexpr int kMostPasses = 6;           // two agree in all tests

double operator_bound(const Quadratics& s) {  // a bound of the second derivatives
  double sum = 0;
  for (const Eigen::MatrixXd& q : s.forms) sum += q.squaredNorm();
  return 2 * std::sqrt(sum);
}

// A complex number of magnitude 1. Distributions of the standard library differ from platform to platform.
Complex on_unit_circle(std::mt19937_64& random) {
  return std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(random() >> 11) * 0x1p-53);
}

enum class End : std::uint8_t { simple, infinite, multiple, lost };

struct PathEnd {
  End end = End::lost;
  Vector7 z;         // simple, multiple: without the homogenising coordinate
  double apart = 0;  // simple
};

// H(Y, t) = (1 - t) F(Y) + gamma t G(Y) over projective points Y = (Y_0, ..., Y_m) of length 1, with
// G_i = Y_i^2 - p_i Y_0^2. A path leads from t = 1 to t = 0; log t is its parameter.
class Pass {
 public:
  Pass(const Quadratics& system, std::uint64_t seed)
      : s_(system), m_(static_cast<int>(system.size())), bound_(std::max(operator_bound(system), 2 * std::sqrt(m_))) {
    std::mt19937_64 random(seed);
    gamma_ = on_unit_circle(random);
    for (int i = 0; i < m_; ++i) roots_.push_back(on_unit_circle(random));
    probe_.resize(m_ + 1);
    for (int i = 0; i <= m_; ++i) probe_[i] = on_unit_circle(random);
  }

  [[nodiscard]] int paths() const { return 1 << m_; }

  [[nodiscard]] PathEnd follow(int path) const {
    Vector7 y(m_ + 1);
    y[0] = 1;
    for (int i = 0; i < m_; ++i) {
      y[i + 1] = ((path >> i) & 1) != 0 ? roots_[static_cast<std::size_t>(i)] : -roots_[static_cast<std::size_t>(i)];
    }
    y.normalize();
    double log_t = 0, step = kFirstStep, next_test = -kTested;
    double exponent = 0;
    int steady = 0;
    for (int k = 0; k < kMostSteps; ++k) {
      const double by = std::min(step, log_t - next_test);
      Vector7 next;
      const std::optional<double> first = advance(y, log_t, by, next);
      if (!first) {
        step = by / 2;
        if (step < kShortestStep) break;
        continue;
      }
      y = next;
      log_t -= by;
      if (*first < kEasy) step = std::min({kLongestStep, 2 * by, by < step ? step : 2 * step});
      if (log_t > next_test) continue;
      next_test = std::max(log_t - kTested, kLastLog - 1e-9);
      if (std::optional<PathEnd> end = certain_end(y, std::exp(log_t))) return *end;
      const double now = exponent_at(y, log_t);
      steady = std::abs(now - exponent) < kSteady * now && now > kLeastExponent ? steady + 1 : 0;
      exponent = now;
      if (log_t <= kLastLog || (steady >= kLongSteady && std::abs(y[0]) < kFar)) break;
    }
    // Rounding ends the path if the Jacobian is singular at its end.
    if (steady >= kLongSteady && std::abs(y[0]) < kFarEnough) return {End::infinite, {}, 0};
    return log_t < kLateLog ? finite_end(y, exponent) : PathEnd{};
  }

 private:
  void evaluate(const Vector7& y, double t, Vector7* h, Matrix7* j, Vector7* by_t) const {
    for (int i = 0; i < m_; ++i) {
      const Complex p = roots_[static_cast<std::size_t>(i)] * roots_[static_cast<std::size_t>(i)];
      const Vector7 qy = s_.forms[static_cast<std::size_t>(i)].cast<Complex>() * y;
      const Complex f = y.cwiseProduct(qy).sum(), g = gamma_ * (y[i + 1] * y[i + 1] - p * y[0] * y[0]);
      if (h != nullptr) (*h)[i] = (1 - t) * f + t * g;
      if (by_t != nullptr) (*by_t)[i] = g - f;
      if (j != nullptr) {
        j->row(i).head(m_ + 1) = (2 * (1 - t)) * qy.transpose();
        (*j)(i, i + 1) += 2 * t * gamma_ * y[i + 1];
        (*j)(i, 0) -= 2 * t * gamma_ * p * y[0];
      }
    }
  }

  // dY / d(log t), orthogonal to `patch`
  [[nodiscard]] Vector7 tangent(const Vector7& y, const Vector7& patch, double t) const {
    Matrix7 j(m_ + 1, m_ + 1);
    Vector7 by_t(m_ + 1);
    evaluate(y, t, nullptr, &j, &by_t);
    j.row(m_) = patch.adjoint();
    by_t[m_] = 0;
    return j.partialPivLu().solve(-t * by_t);
  }

  struct Correction {
    double size;
    double rounding;  // estimate of the corrections that rounding causes
  };

  // One step of Newton's method, orthogonal to `patch`.
  [[nodiscard]] Correction correct(Vector7& y, const Vector7& patch, double t) const {
    Matrix7 j(m_ + 1, m_ + 1);
    Vector7 h(m_ + 1);
    evaluate(y, t, &h, &j, nullptr);
    j.row(m_) = patch.adjoint();
    h[m_] = 0;
    const Eigen::PartialPivLU<Matrix7> lu(j);
    const Vector7 d = lu.solve(h);
    y -= d;
    return {d.norm(), 8 * kEps * bound_ * lu.solve(probe_).norm()};
  }

  // Runge-Kutta's method of order 4, then Newton's. Returns the size of the first correction; empty: not accepted.
  [[nodiscard]] std::optional<double> advance(const Vector7& y, double log_t, double by, Vector7& out) const {
    const double half = std::exp(log_t - by / 2), t = std::exp(log_t - by);
    const Vector7 k1 = tangent(y, y, std::exp(log_t));
    const Vector7 k2 = tangent(y - by / 2 * k1, y, half);
    const Vector7 k3 = tangent(y - by / 2 * k2, y, half);
    const Vector7 k4 = tangent(y - by * k3, y, t);
    out = y - by / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    const double first = correct(out, y, t).size;
    if (!(first <= kPredicted)) return std::nullopt;
    double last = first;
    for (int i = 0; i < 3 && last > kCorrected; ++i) {
      const Correction now = correct(out, y, t);
      const double enough = std::max(kCorrected, std::min(now.rounding, kRoughest));
      if (!(now.size <= std::max(0.1 * last, enough))) return std::nullopt;
      last = now.size <= enough ? 0 : now.size;
    }
    if (last > kCorrected) return std::nullopt;
    out.normalize();
    return first;
  }

  // With Y_0 ~ t^a along a path, a: 0 for finite ends, > 0 for ends at infinity.
  [[nodiscard]] double exponent_at(const Vector7& y, double log_t) const {
    return (tangent(y, y, std::exp(log_t))[0] / y[0]).real();
  }

  // The end, if one solution of H(., tau) is near y for each tau in [0, t]: Newton-Kantorovich theorem with bounds for
  // all tau.
  [[nodiscard]] std::optional<PathEnd> certain_end(const Vector7& y, double t) const {
    Matrix7 j(m_ + 1, m_ + 1), j_t(m_ + 1, m_ + 1);
    Vector7 f(m_ + 1), h(m_ + 1);
    evaluate(y, 0, &f, &j, nullptr);
    evaluate(y, t, &h, &j_t, nullptr);
    const double change = (j_t - j).topRows(m_).norm();
    j.row(m_) = y.adjoint();
    const double inverse = 1 / j.jacobiSvd().singularValues()[m_];
    if (!(inverse * change < 0.5)) return std::nullopt;
    const double b = inverse / (1 - inverse * change);
    const double residual = std::max(f.head(m_).norm(), h.head(m_).norm());
    if (!(b * b * bound_ * residual <= kCertain)) return std::nullopt;
    Vector7 end = y;
    for (int i = 0; i < 8 && correct(end, y, 0).size > 4 * kEps; ++i) {
    }
    end.normalize();
    if (std::abs(end[0]) < kFar) return PathEnd{End::infinite, {}, 0};
    return simple_at(end.tail(m_) / end[0]);
  }

  // The end if the solution at z is simple beyond the doubt of rounding.
  [[nodiscard]] std::optional<PathEnd> simple_at(Vector7 z) const {
    Vector7 y(m_ + 1), h(m_ + 1);
    Matrix7 j(m_ + 1, m_ + 1);
    for (int i = 0;; ++i) {
      y << 1, z;
      evaluate(y, 0, &h, &j, nullptr);
      const Matrix7 inner = j.block(0, 1, m_, m_);
      if (i == 3) {
        const double inverse = 1 / inner.jacobiSvd().singularValues()[m_ - 1];
        const double rounding = 4 * m_ * kEps * y.squaredNorm() * bound_;
        if (!(inverse * inverse * bound_ * (h.head(m_).norm() + rounding) <= kCertain)) return std::nullopt;
        return PathEnd{End::simple, z, 1 / (inverse * bound_)};
      }
      z -= inner.partialPivLu().solve(h.head(m_));
    }
  }

  // The end of a path that does not lead to infinity, and that may not be a simple solution.
  [[nodiscard]] PathEnd finite_end(const Vector7& y, double exponent) const {
    if (std::abs(y[0]) < kFarEnough || exponent > kLeastExponent) return {};
    const Vector7 z = y.tail(m_) / y[0];
    if (const std::optional<PathEnd> end = simple_at(z); end && (end->z - z).norm() < end->apart) return *end;
    return {End::multiple, z, 0};
  }

  const Quadratics& s_;
  int m_;
  double bound_;  // bound of the second derivatives of H(., t), for each t
  Complex gamma_;
  std::vector<Complex> roots_;  // roots of p_i
  Vector7 probe_;               // a random right-hand side
};

// The ends of all paths of one pass.
struct Ends {
  std::vector<PathEnd> simple;
  std::vector<Vector7> multiple;
  int diverged = 0;
  int lost = 0;

  [[nodiscard]] const PathEnd* find(const Vector7& z) const {
    const auto found =
        std::find_if(simple.begin(), simple.end(), [&](const PathEnd& e) { return (e.z - z).norm() < e.apart / 2; });
    return found == simple.end() ? nullptr : &*found;
  }
};

Ends all_ends(const Pass& pass) {
  Ends out;
  for (int p = 0; p < pass.paths(); ++p) {
    PathEnd end = pass.follow(p);
    switch (end.end) {
      case End::simple:
        if (out.find(end.z) != nullptr) {
          ++out.lost;  // two paths cannot end at a simple solution: one of them left its path
        } else {
          out.simple.push_back(std::move(end));
        }
        break;
      case End::infinite:
        ++out.diverged;
        break;
      case End::multiple:
        out.multiple.push_back(end.z);
        break;
      case End::lost:
        ++out.lost;
        break;
    }
  }
  // The equations are real, so that solutions come in conjugate pairs.
  for (const PathEnd& e : out.simple) {
    if (out.find(e.z.conjugate()) == nullptr) ++out.lost;
  }
  return out;
}

bool agree(const Ends& a, const Ends& b) {
  return a.lost == 0 && b.lost == 0 && a.simple.size() == b.simple.size() && a.multiple.size() == b.multiple.size() &&
         std::all_of(a.simple.begin(), a.simple.end(), [&](const PathEnd& e) { return b.find(e.z) != nullptr; });
}

constexpr double kSameMultiple = 1e-4;  // relative distance; paths end about 1e-7 from a double solution

Solutions described(const Ends& ends, int paths, int lost) {
  Solutions out;
  out.paths = paths;
  out.diverged = ends.diverged;
  out.multiple = static_cast<int>(ends.multiple.size());
  out.lost = lost;
  for (const PathEnd& e : ends.simple) {
    // The conjugate is a solution, too. Nearer than `apart` it is the same one.
    if (2 * e.z.imag().norm() < e.apart) {
      out.real.push_back({e.z.real(), e.apart});
    } else {
      ++out.complex;
    }
  }
  for (const Vector7& z : ends.multiple) {
    const double near = kSameMultiple * (1 + z.norm());
    const Eigen::VectorXd at = z.real();
    if (z.imag().norm() < near && std::none_of(out.real_multiple.begin(), out.real_multiple.end(),
                                               [&](const Eigen::VectorXd& o) { return (o - at).norm() < near; })) {
      out.real_multiple.push_back(at);
    }
  }
  return out;
}

}  // namespace

Solutions solve(const Quadratics& system) {
  std::vector<Ends> passes;
  Ends all;  // of all passes
  int least_lost = 0;
  for (int k = 0; k < kMostPasses; ++k) {
    const Pass pass(system, static_cast<std::uint64_t>(k) + 1);
    Ends now = all_ends(pass);
    for (const Ends& before : passes) {
      if (agree(before, now)) return described(now, pass.paths(), 0);
    }
    if (passes.empty() || now.lost < least_lost) {
      least_lost = now.lost;
      all.diverged = now.diverged;
      all.multiple = now.multiple;
    }
    for (const PathEnd& e : now.simple) {
      if (all.find(e.z) == nullptr) all.simple.push_back(e);
    }
    passes.push_back(std::move(now));
  }
  return described(all, 1 << system.size(), std::max(least_lost, 1));
}

}  // namespace assur
