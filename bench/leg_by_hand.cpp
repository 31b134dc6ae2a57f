#include "leg_by_hand.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

namespace assur::bench {
namespace {

using peers::dot;
using peers::operator+;
using peers::operator*;

constexpr double kHandle = peers::Stewart::kHandle, kRod = peers::Stewart::kRod;  // m

// First unknown of each vector, first equation of each kind.
enum Unknown { kB = 0, kE = 3, kR = 6, kC = 9, kD = 12 };
enum Equation { kHandleLength = 0, kHinge = 3, kRodLength = 4, kCR = 7, kCT, kDR, kDC, kEE, kRR, kCC, kDD };

Vec at(const LegByHand::Unknowns& q, std::size_t i) { return {q[i], q[i + 1], q[i + 2]}; }
Vec magnitude(const LegByHand::Unknowns& q, std::size_t i) {
  return {std::abs(q[i]), std::abs(q[i + 1]), std::abs(q[i + 2])};
}
Vec in_plane(const Vec& local, const Terminal& x) { return local[0] * x.u + local[1] * x.v; }

}  // namespace

Pattern LegByHand::pattern() {
  Pattern p;
  p.n = kUnknowns;
  p.column_start = {0};
  const auto column = [&p](std::initializer_list<int> rows) {
    p.row.insert(p.row.end(), rows.begin(), rows.end());
    p.column_start.push_back(p.nnz());
  };
  for (int i = 0; i < 3; ++i) column({kHandleLength + i, kRodLength + i});
  for (int i = 0; i < 3; ++i) column({kHandleLength + i, kHinge, kEE});
  for (int i = 0; i < 3; ++i) column({kRodLength + i, kCR, kDR, kRR});
  for (int i = 0; i < 3; ++i) column({kCR, kCT, kDC, kCC});
  for (int i = 0; i < 3; ++i) column({kDR, kDC, kDD});
  return p;
}

void LegByHand::set_inputs(const Terminal& value) {
  P_ = in_plane(local_P_, value);
  for (std::size_t i = 0; i < 3; ++i) {
    P_[i] += value.O[i];
    P_scale_[i] = std::abs(value.O[i]) + std::abs(local_P_[0] * value.u[i]) + std::abs(local_P_[1] * value.v[i]);
  }
  t_ = in_plane(local_t_, value);
}

void LegByHand::evaluate(const Unknowns& q, Unknowns& phi, double* jacobian) {
  const Vec B = at(q, kB), e = at(q, kE), r = at(q, kR), c = at(q, kC), d = at(q, kD);
  c_ = c;
  for (std::size_t i = 0; i < 3; ++i) {
    phi[kHandleLength + i] = B[i] - A_[i] - kHandle * e[i];
    phi[kRodLength + i] = P_[i] - B[i] - kRod * r[i];
  }
  phi[kHinge] = dot(e, a_);
  phi[kCR] = dot(c, r);
  phi[kCT] = dot(c, t_);
  phi[kDR] = dot(d, r);
  phi[kDC] = dot(d, c);
  phi[kEE] = (dot(e, e) - 1) / 2;
  phi[kRR] = (dot(r, r) - 1) / 2;
  phi[kCC] = (dot(c, c) - 1) / 2;
  phi[kDD] = (dot(d, d) - 1) / 2;
  const auto put = [&jacobian](std::initializer_list<double> values) {
    jacobian = std::copy(values.begin(), values.end(), jacobian);
  };
  for (std::size_t i = 0; i < 3; ++i) put({1, -1});
  for (std::size_t i = 0; i < 3; ++i) put({-kHandle, a_[i], e[i]});
  for (std::size_t i = 0; i < 3; ++i) put({-kRod, c[i], d[i], r[i]});
  for (std::size_t i = 0; i < 3; ++i) put({r[i], t_[i], d[i], c[i]});
  for (std::size_t i = 0; i < 3; ++i) put({r[i], c[i], d[i]});
}

void LegByHand::scale(const Unknowns& q, Unknowns& scale) const {
  const Vec B = magnitude(q, kB), e = magnitude(q, kE), r = magnitude(q, kR), c = magnitude(q, kC),
            d = magnitude(q, kD);
  for (std::size_t i = 0; i < 3; ++i) {
    scale[kHandleLength + i] = B[i] + std::abs(A_[i]) + kHandle * e[i];
    scale[kRodLength + i] = P_scale_[i] + B[i] + kRod * r[i];
  }
  scale[kHinge] = std::abs(a_[0]) * e[0] + std::abs(a_[1]) * e[1] + std::abs(a_[2]) * e[2];
  scale[kCR] = 2 * dot(c, r);
  scale[kCT] = 2 * (std::abs(t_[0]) * c[0] + std::abs(t_[1]) * c[1] + std::abs(t_[2]) * c[2]);
  scale[kDR] = 2 * dot(d, r);
  scale[kDC] = 2 * dot(d, c);
  scale[kEE] = dot(e, e) + 0.5;
  scale[kRR] = dot(r, r) + 0.5;
  scale[kCC] = dot(c, c) + 0.5;
  scale[kDD] = dot(d, d) + 0.5;
}

void LegByHand::velocity(const Terminal& rate, Unknowns& b) {
  b.fill(0);
  const Vec arm = in_plane(local_P_, rate);
  t_rate_ = in_plane(local_t_, rate);
  for (std::size_t i = 0; i < 3; ++i) b[kRodLength + i] = -(rate.O[i] + arm[i]);
  b[kCT] = -dot(c_, t_rate_);
}

void LegByHand::acceleration(const Unknowns& v, const Terminal& acceleration, Unknowns& b) const {
  const Vec e = at(v, kE), r = at(v, kR), c = at(v, kC), d = at(v, kD);
  const Vec arm = in_plane(local_P_, acceleration), t = in_plane(local_t_, acceleration);
  for (std::size_t i = 0; i < 3; ++i) {
    b[kHandleLength + i] = 0;
    b[kRodLength + i] = -(acceleration.O[i] + arm[i]);
  }
  b[kHinge] = 0;
  b[kCR] = -2 * dot(c, r);
  b[kCT] = -(dot(c_, t) + 2 * dot(c, t_rate_));
  b[kDR] = -2 * dot(d, r);
  b[kDC] = -2 * dot(d, c);
  b[kEE] = -dot(e, e);
  b[kRR] = -dot(r, r);
  b[kCC] = -dot(c, c);
  b[kDD] = -dot(d, d);
}

LegByHand::Reads LegByHand::reads(const Unknowns& q) const {
  Reads all;
  const auto inputs = std::copy(q.begin(), q.end(), all.begin());
  std::copy(t_.begin(), t_.end(), std::copy(P_.begin(), P_.end(), inputs));
  return all;
}

}  // namespace assur::bench
