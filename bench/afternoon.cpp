#include "afternoon.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace assur::bench {
namespace {

constexpr std::size_t kMostIterations = 10;
constexpr double kRounding = 1e-12;  // a residual below it that no longer falls is rounding

}  // namespace

// ---- Newton's method

template <class Mechanism>
Afternoon<Mechanism>::Afternoon(Mechanism mechanism, KluOptions options, double tolerance)
    : mechanism_(std::move(mechanism)), tolerance_(tolerance), columns_(mechanism_.columns()) {
  n_ = static_cast<int>(columns_.start.size()) - 1;
  for (std::vector<double>* x : {&q_, &v_, &a_, &correction_}) x->resize(static_cast<std::size_t>(n_));
  jacobian_.resize(columns_.row.size());
  mechanism_.guess(q_.data());
  klu_defaults(&common_);
  if (options == KluOptions::unscaled) {
    common_.scale = -1;
    common_.tol = 1;
  }
  symbolic_ = klu_analyze(n_, columns_.start.data(), columns_.row.data(), &common_);
}

template <class Mechanism>
Afternoon<Mechanism>::~Afternoon() {
  klu_free_numeric(&numeric_, &common_);
  klu_free_symbolic(&symbolic_, &common_);
}

template <class Mechanism>
bool Afternoon<Mechanism>::step(double t) {
  const double h = t - time_;
  for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += h * (v_[i] + h / 2 * a_[i]);
  time_ = t;
  mechanism_.drive(t);

  residual_ = mechanism_.evaluate(q_.data(), correction_.data(), jacobian_.data());
  for (iterations_ = 0; !(residual_ <= tolerance_); ++iterations_) {
    if (iterations_ == kMostIterations || !factorize() || !solve(correction_)) return false;
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] -= correction_[i];
    const double before = residual_;
    residual_ = mechanism_.evaluate(q_.data(), correction_.data(), jacobian_.data());
    if (residual_ <= kRounding && residual_ > before / 4) {
      ++iterations_;
      break;
    }
  }

  if (!factorize()) return false;
  mechanism_.velocity(v_.data());
  if (!solve(v_)) return false;
  mechanism_.acceleration(v_.data(), a_.data());
  return solve(a_);
}

template <class Mechanism>
bool Afternoon<Mechanism>::factorize() {
  int* const start = columns_.start.data();
  int* const row = columns_.row.data();
  if (numeric_ != nullptr) return klu_refactor(start, row, jacobian_.data(), symbolic_, numeric_, &common_) != 0;
  numeric_ = klu_factor(start, row, jacobian_.data(), symbolic_, &common_);
  return numeric_ != nullptr;
}

template <class Mechanism>
bool Afternoon<Mechanism>::solve(std::vector<double>& b_to_x) {
  return klu_solve(symbolic_, numeric_, n_, 1, b_to_x.data(), &common_) != 0;
}

template class Afternoon<FourBarChain>;
template class Afternoon<StewartHandles>;

// ---- the chain

namespace {

constexpr double kCrank = 0.8, kFirstCoupler = 1.8, kCoupler = 2, kRocker = 1.3, kSpacing = 2;  // m
constexpr double kCrankSpeed = 2 * std::numbers::pi;                                            // rad/s

}  // namespace

FourBarChain::FourBarChain(int loops) : loops_(static_cast<std::size_t>(loops)) {}

// Both columns of B_k have entries of coupler k, rocker k and coupler k + 1.
Columns FourBarChain::columns() const {
  Columns c{{0}, {}};
  for (int k = 0; k < static_cast<int>(loops_); ++k) {
    for (int axis = 0; axis < 2; ++axis) {
      c.row.insert(c.row.end(), {2 * k, 2 * k + 1});
      if (k + 1 < static_cast<int>(loops_)) c.row.push_back(2 * k + 2);
      c.start.push_back(static_cast<int>(c.row.size()));
    }
  }
  return c;
}

// The first loop's rocker stands upright at the start, and the further loops are nearly parallelograms.
void FourBarChain::guess(double* q) const {
  for (std::size_t k = 0; k < loops_; ++k) {
    q[2 * k] = kSpacing * static_cast<double>(k + 1) + 0.05;
    q[2 * k + 1] = kRocker;
  }
}

void FourBarChain::drive(double t) {
  const double cosine = std::cos(kCrankSpeed * t), sine = std::sin(kCrankSpeed * t);
  x_ = kCrank * cosine, y_ = kCrank * sine;
  vx_ = -kCrankSpeed * y_, vy_ = kCrankSpeed * x_;
  ax_ = -kCrankSpeed * vy_, ay_ = kCrankSpeed * vx_;
}

double FourBarChain::evaluate(const double* q, double* phi, double* jacobian) {
  double px = x_, py = y_, worst = 0, length = kFirstCoupler;
  double* before = nullptr;  // entry of the coupler in the columns of the point before
  std::size_t before_stride = 0;
  for (std::size_t k = 0; k < loops_; ++k) {
    const double bx = q[2 * k], by = q[2 * k + 1], anchor = kSpacing * static_cast<double>(k + 1);
    const double dx = bx - px, dy = by - py, rx = bx - anchor;
    const double coupler = (dx * dx + dy * dy - length * length) / 2,
                 rocker = (rx * rx + by * by - kRocker * kRocker) / 2;
    phi[2 * k] = coupler;
    phi[2 * k + 1] = rocker;
    const double coupler_scale = std::abs(dx) * (std::abs(bx) + std::abs(px)) +
                                 std::abs(dy) * (std::abs(by) + std::abs(py)) + length * length / 2;
    const double rocker_scale = std::abs(rx) * (std::abs(bx) + anchor) + by * by + kRocker * kRocker / 2;
    worst = std::max({worst, std::abs(coupler) / coupler_scale, std::abs(rocker) / rocker_scale});

    if (k == 0) {
      dx_ = dx, dy_ = dy;
    } else {
      before[0] = -dx;
      before[before_stride] = -dy;
    }
    const std::size_t rows = k + 1 < loops_ ? 3 : 2;
    jacobian[0] = dx;
    jacobian[1] = rx;
    jacobian[rows] = dy;
    jacobian[rows + 1] = by;
    before = jacobian + 2;
    before_stride = rows;
    jacobian += 2 * rows;
    px = bx, py = by, length = kCoupler;
  }
  return worst;
}

void FourBarChain::velocity(double* b) const {
  std::fill_n(b, 2 * loops_, 0.0);
  b[0] = dx_ * vx_ + dy_ * vy_;
}

void FourBarChain::acceleration(const double* v, double* b) const {
  double px = vx_, py = vy_;
  for (std::size_t k = 0; k < loops_; ++k) {
    const double bx = v[2 * k], by = v[2 * k + 1], dx = bx - px, dy = by - py;
    b[2 * k] = -(dx * dx + dy * dy);
    b[2 * k + 1] = -(bx * bx + by * by);
    px = bx, py = by;
  }
  b[0] += dx_ * ax_ + dy_ * ay_;
}

// ---- the platform

namespace {

using Vec = StewartHandles::Vec;

constexpr double kHandle = 0.2, kRod = 0.55;                  // m
constexpr double kBase = 0.5, kTerminal = 0.3;                // m, radii
constexpr double kBaseSpread = 0.35, kTerminalSpread = 0.7;   // rad, half the angle between the joints of a pair
constexpr double kToe = 0.2, kElevation = 0.1;                // rad, of the handles' axes
constexpr double kMove = 0.05, kTurn = 0.15, kHeight = 0.55;  // m, rad, m: amplitudes and mean height of the motion
constexpr double kSpeed = 1;                                  // rad/s

constexpr std::array<Vec, 6> kGuess = {{{0.60590, -0.20646, 0.14220},
                                        {0.57498, 0.21672, 0.16390},
                                        {-0.11534, 0.61014, 0.15912},
                                        {-0.44275, 0.37422, 0.18341},
                                        {-0.44004, -0.36196, 0.18737},
                                        {-0.10077, -0.59568, 0.17072}}};

double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(double s, const Vec& a) { return {s * a[0], s * a[1], s * a[2]}; }

struct Wave {
  double value, rate, acceleration;
  Wave(double amplitude, double angle, double offset = 0) {
    const double sine = amplitude * std::sin(angle);
    value = offset + sine;
    rate = kSpeed * amplitude * std::cos(angle);
    acceleration = -kSpeed * kSpeed * sine;
  }
};

}  // namespace

StewartHandles::StewartHandles() {
  for (std::size_t k = 0; k < legs_.size(); ++k) {
    const double pair = 2 * std::numbers::pi / 3 * static_cast<double>(k / 2), side = k % 2 == 0 ? -1 : 1;
    const double base = pair + kBaseSpread * side, terminal = pair + kTerminalSpread * side;
    const double axis = base + std::numbers::pi / 2 + kToe;
    Leg& leg = legs_[k];
    leg.A = {kBase * std::cos(base), kBase * std::sin(base), 0};
    leg.a = {std::cos(kElevation) * std::cos(axis), std::cos(kElevation) * std::sin(axis), std::sin(kElevation)};
    leg.local = {kTerminal * std::cos(terminal), kTerminal * std::sin(terminal), 0};
  }
}

Columns StewartHandles::columns() const {
  Columns c{{0}, {}};
  for (int column = 0; column < 18; ++column) {
    const int first = column / 3 * 3;
    c.row.insert(c.row.end(), {first, first + 1, first + 2});
    c.start.push_back(static_cast<int>(c.row.size()));
  }
  return c;
}

void StewartHandles::guess(double* q) const {
  for (const Vec& B : kGuess) q = std::copy(B.begin(), B.end(), q);
}

// O and R = Rz(psi) Ry(theta) Rx(phi); the joints of the terminal follow from its angular velocity and acceleration.
void StewartHandles::drive(double t) {
  const double angle = kSpeed * t;
  const Wave x(kMove, angle), y(kMove, angle + 1), z(kMove, angle + 2, kHeight);
  const Wave psi(kTurn, angle + 0.5), theta(kTurn, angle + 1.5), phi(kTurn, angle + 2.5);
  const double cp = std::cos(psi.value), sp = std::sin(psi.value), ct = std::cos(theta.value),
               st = std::sin(theta.value);
  const double cf = std::cos(phi.value), sf = std::sin(phi.value);
  const Vec u = {cp * ct, sp * ct, -st}, v = {cp * st * sf - sp * cf, sp * st * sf + cp * cf, ct * sf};
  const Vec up = {0, 0, 1}, node = {-sp, cp, 0};  // axes of psi and theta; the axis of phi is u
  const Vec first = psi.rate * up, second = first + theta.rate * node, omega = second + phi.rate * u;
  const Vec alpha = psi.acceleration * up + theta.acceleration * node + phi.acceleration * u +
                    cross(first, theta.rate * node) + cross(second, phi.rate * u);
  for (Leg& leg : legs_) {
    const Vec arm = leg.local[0] * u + leg.local[1] * v;  // the joints lie in the plane of u and v
    const Vec turning = cross(omega, arm);
    leg.P = Vec{x.value, y.value, z.value} + arm;
    leg.rate = Vec{x.rate, y.rate, z.rate} + turning;
    leg.acceleration = Vec{x.acceleration, y.acceleration, z.acceleration} + cross(alpha, arm) + cross(omega, turning);
  }
}

double StewartHandles::evaluate(const double* q, double* phi, double* jacobian) {
  double worst = 0;
  for (Leg& leg : legs_) {
    const Vec B = {q[0], q[1], q[2]}, h = B - leg.A;
    leg.d = B - leg.P;
    double scale[3] = {kRod * kRod / 2, kHandle * kHandle / 2, 0};
    for (std::size_t i = 0; i < 3; ++i) {
      scale[0] += std::abs(leg.d[i]) * (std::abs(B[i]) + std::abs(leg.P[i]));
      scale[1] += std::abs(h[i]) * (std::abs(B[i]) + std::abs(leg.A[i]));
      scale[2] += std::abs(leg.a[i]) * (std::abs(B[i]) + std::abs(leg.A[i]));
      *jacobian++ = leg.d[i];
      *jacobian++ = h[i];
      *jacobian++ = leg.a[i];
    }
    phi[0] = (dot(leg.d, leg.d) - kRod * kRod) / 2;
    phi[1] = (dot(h, h) - kHandle * kHandle) / 2;
    phi[2] = dot(h, leg.a);
    for (std::size_t i = 0; i < 3; ++i) worst = std::max(worst, std::abs(phi[i]) / scale[i]);
    q += 3;
    phi += 3;
  }
  return worst;
}

void StewartHandles::velocity(double* b) const {
  for (const Leg& leg : legs_) {
    *b++ = dot(leg.d, leg.rate);
    *b++ = 0;
    *b++ = 0;
  }
}

void StewartHandles::acceleration(const double* v, double* b) const {
  for (const Leg& leg : legs_) {
    const Vec B = {v[0], v[1], v[2]}, relative = B - leg.rate;
    *b++ = dot(leg.d, leg.acceleration) - dot(relative, relative);
    *b++ = -dot(B, B);
    *b++ = 0;
    v += 3;
  }
}

}  // namespace assur::bench
