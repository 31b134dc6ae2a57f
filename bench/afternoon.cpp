#include "afternoon.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace assur::bench {
namespace {

constexpr std::size_t kMostIterations = 10;
constexpr double kRounding = 1e-12;  // a smaller residual that no longer falls is rounding

}  // namespace

// ---- Newton's method

template <class Mechanism>
Afternoon<Mechanism>::Afternoon(Mechanism mechanism, KluOptions options, double tolerance)
    : mechanism_(std::move(mechanism)),
      solver_(mechanism_.pattern(), options == KluOptions::defaults ? 0.001 : 1,
              options == KluOptions::defaults ? 2 : -1),
      tolerance_(tolerance) {
  const Pattern pattern = mechanism_.pattern();
  for (std::vector<double>* x : {&q_, &v_, &a_, &correction_}) x->resize(static_cast<std::size_t>(pattern.n));
  jacobian_.resize(pattern.row.size());
  mechanism_.guess(q_.data());
}

template <class Mechanism>
bool Afternoon<Mechanism>::step(double t) {
  const double h = t - time_;
  for (std::size_t i = 0; i < q_.size(); ++i) q_[i] += h * (v_[i] + h / 2 * a_[i]);
  time_ = t;
  mechanism_.drive(t);

  residual_ = mechanism_.evaluate(q_.data(), correction_.data(), jacobian_.data());
  for (iterations_ = 0; !(residual_ <= tolerance_); ++iterations_) {
    if (iterations_ == kMostIterations || !solver_.factorize(jacobian_.data())) return false;
    if (!solver_.solve(correction_.data())) return false;
    for (std::size_t i = 0; i < q_.size(); ++i) q_[i] -= correction_[i];
    const double before = residual_;
    residual_ = mechanism_.evaluate(q_.data(), correction_.data(), jacobian_.data());
    if (residual_ <= kRounding && residual_ > before / 4) {
      ++iterations_;
      break;
    }
  }

  if (!solver_.factorize(jacobian_.data())) return false;
  mechanism_.velocity(v_.data());
  if (!solver_.solve(v_.data())) return false;
  mechanism_.acceleration(v_.data(), a_.data());
  return solver_.solve(a_.data());
}

template class Afternoon<FourBarChain>;
template class Afternoon<StewartHandles>;

// ---- the chain

namespace {

using peers::FourBars;

constexpr double kCrank = FourBars::kCrank, kRocker = FourBars::kRocker, kSpacing = 2;  // m
constexpr double kCrankSpeed = FourBars::kSpeed;                                        // rad/s

}  // namespace

FourBarChain::FourBarChain(int loops) : loops_(static_cast<std::size_t>(loops)) {}

// Both columns of B_k have entries of coupler k, rocker k and coupler k + 1.
Pattern FourBarChain::pattern() const {
  Pattern c{2 * static_cast<int>(loops_), {0}, {}};
  for (int k = 0; k < static_cast<int>(loops_); ++k) {
    for (int axis = 0; axis < 2; ++axis) {
      c.row.insert(c.row.end(), {2 * k, 2 * k + 1});
      if (k + 1 < static_cast<int>(loops_)) c.row.push_back(2 * k + 2);
      c.column_start.push_back(c.nnz());
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
  double px = x_, py = y_, worst = 0, length = FourBars::coupler(1);
  double* before = nullptr;  // entries of the coupler in the columns of the previous point
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
    px = bx, py = by, length = FourBars::coupler(2);
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

using peers::cross;
using peers::dot;
using peers::Vec;
using peers::operator+;
using peers::operator-;
using peers::operator*;

constexpr double kHandle = peers::Stewart::kHandle, kRod = peers::Stewart::kRod;  // m

constexpr std::array<Vec, 6> kGuess = {{{0.60590, -0.20646, 0.14220},
                                        {0.57498, 0.21672, 0.16390},
                                        {-0.11534, 0.61014, 0.15912},
                                        {-0.44275, 0.37422, 0.18341},
                                        {-0.44004, -0.36196, 0.18737},
                                        {-0.10077, -0.59568, 0.17072}}};

// One coordinate of the terminal with its time derivatives.
struct Motion {
  double value, rate, acceleration;
  Motion(const peers::Wave& wave, double t) {
    const double sine = wave.amplitude * std::sin(t + wave.phase);
    value = wave.offset + sine;
    rate = wave.amplitude * std::cos(t + wave.phase);
    acceleration = -sine;
  }
};

}  // namespace

StewartHandles::StewartHandles() {
  const auto legs = peers::Stewart::legs();
  for (std::size_t k = 0; k < legs_.size(); ++k) legs_[k] = {legs[k]};
}

Pattern StewartHandles::pattern() const {
  Pattern c{18, {0}, {}};
  for (int column = 0; column < 18; ++column) {
    const int first = column / 3 * 3;
    c.row.insert(c.row.end(), {first, first + 1, first + 2});
    c.column_start.push_back(c.nnz());
  }
  return c;
}

void StewartHandles::guess(double* q) const {
  for (const Vec& B : kGuess) q = std::copy(B.begin(), B.end(), q);
}

// O and R = Rz(psi) Ry(theta) Rx(phi); the joints of the terminal follow from its angular velocity and acceleration.
void StewartHandles::drive(double t) {
  const auto at = [t](std::size_t i) { return Motion(peers::Stewart::kPose[i], t); };
  const Motion x = at(0), y = at(1), z = at(2), psi = at(3), theta = at(4), phi = at(5);
  const double cp = std::cos(psi.value), sp = std::sin(psi.value), ct = std::cos(theta.value),
               st = std::sin(theta.value);
  const double cf = std::cos(phi.value), sf = std::sin(phi.value);
  const Vec u = {cp * ct, sp * ct, -st}, v = {cp * st * sf - sp * cf, sp * st * sf + cp * cf, ct * sf};
  const Vec up = {0, 0, 1}, node = {-sp, cp, 0};  // axes of psi and theta; the axis of phi is u
  const Vec first = psi.rate * up, second = first + theta.rate * node, omega = second + phi.rate * u;
  const Vec alpha = psi.acceleration * up + theta.acceleration * node + phi.acceleration * u +
                    cross(first, theta.rate * node) + cross(second, phi.rate * u);
  for (Leg& leg : legs_) {
    const Vec arm = leg.P[0] * u + leg.P[1] * v;  // the joints lie in the plane of u and v
    const Vec turning = cross(omega, arm);
    leg.joint = Vec{x.value, y.value, z.value} + arm;
    leg.rate = Vec{x.rate, y.rate, z.rate} + turning;
    leg.acceleration = Vec{x.acceleration, y.acceleration, z.acceleration} + cross(alpha, arm) + cross(omega, turning);
  }
}

double StewartHandles::evaluate(const double* q, double* phi, double* jacobian) {
  double worst = 0;
  for (Leg& leg : legs_) {
    const Vec B = {q[0], q[1], q[2]}, h = B - leg.A;
    leg.d = B - leg.joint;
    double scale[3] = {kRod * kRod / 2, kHandle * kHandle / 2, 0};
    for (std::size_t i = 0; i < 3; ++i) {
      scale[0] += std::abs(leg.d[i]) * (std::abs(B[i]) + std::abs(leg.joint[i]));
      scale[1] += std::abs(h[i]) * (std::abs(B[i]) + std::abs(leg.A[i]));
      scale[2] += std::abs(leg.axis[i]) * (std::abs(B[i]) + std::abs(leg.A[i]));
      *jacobian++ = leg.d[i];
      *jacobian++ = h[i];
      *jacobian++ = leg.axis[i];
    }
    phi[0] = (dot(leg.d, leg.d) - kRod * kRod) / 2;
    phi[1] = (dot(h, h) - kHandle * kHandle) / 2;
    phi[2] = dot(h, leg.axis);
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
