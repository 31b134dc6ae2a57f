#include "mechanisms/plain_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numbers.hpp"

namespace assur::mechanisms {
namespace {

constexpr double kShortest = 0x1p-34;   // share of the way; if steps become shorter, the motion ends here
constexpr int kMostAttempts = 100'000;  // of one call; the motion ends at the next failure
constexpr double kVolume = 0.7;       // largest change of log(volume of the Jacobian) in a step, to miss no singularity
constexpr double kCorrection = 0.05;  // largest first correction, relative to the step
constexpr double kContraction = 0.1;  // each correction is at most this part of the one before
constexpr double kConverged = 1e-11;  // last correction, relative to the unknowns
constexpr double kMeet = 1e-7;        // share of the way; two points that turn far round each other within it have met

template <class T, class F>
std::vector<PlainEquations::Input<T>> inputs(const std::vector<TimeJet<Real>>& laws, const F& of) {
  std::vector<PlainEquations::Input<T>> in;
  in.reserve(laws.size());
  for (const TimeJet<Real>& l : laws) in.push_back(of(l));
  return in;
}

PlainEquations::Input<double> plain(const TimeJet<Real>& l) {
  return {static_cast<double>(l.value), static_cast<double>(std::cos(l.value)), static_cast<double>(std::sin(l.value))};
}

template <class T>
PlainEquations::Input<TimeJet<T>> jet(const TimeJet<Real>& l) {
  const Real c = std::cos(l.value), s = std::sin(l.value);
  const auto make = [](Real v, Real r, Real a) {
    return TimeJet<T>(static_cast<T>(v), static_cast<T>(r), static_cast<T>(a));
  };
  return {make(l.value, l.rate, l.curve), make(c, -s * l.rate, -s * l.curve - c * l.rate * l.rate),
          make(s, c * l.rate, c * l.curve - s * l.rate * l.rate)};
}

}  // namespace

std::vector<TimeJet<Real>> laws_at(const PlainEquations& equations, Real t) {
  std::vector<TimeJet<Real>> out;
  for (const Law* law : equations.laws()) out.push_back(value_of(*law, t));
  return out;
}

double PlainMotion::size(const Vector& x) const { return x.cwiseQuotient(column_scale_).cwiseAbs().maxCoeff(); }

double PlainMotion::scale(int derivative) const {
  Real most = 0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const Real d = derivative == 1 ? x_[i].rate : x_[i].curve;
    most = std::max(most, std::abs(d) / Real(column_scale_[static_cast<Eigen::Index>(i)]));
  }
  return static_cast<double>(most);
}

double PlainMotion::factorise(const Vector& x, const std::vector<TimeJet<Real>>& laws) {
  const std::size_t n = equations_.unknowns(), m = equations_.equations();
  Eigen::MatrixXd jacobian(m, n);
  std::vector<Strip> at(n), out(m);
  const auto in = inputs<Strip>(laws, [](const TimeJet<Real>& l) {
    const auto p = plain(l);
    return PlainEquations::Input<Strip>{p.value, p.cosine, p.sine};
  });
  for (std::size_t first = 0; first < n; first += Strip::kWidth) {
    for (std::size_t i = 0; i < n; ++i) {
      at[i] = Strip(x[static_cast<Eigen::Index>(i)]);
      if (i >= first && i < first + Strip::kWidth) at[i].by[i - first] = column_scale_[static_cast<Eigen::Index>(i)];
    }
    equations_.evaluate(at.data(), in.data(), out.data());
    for (std::size_t i = first; i < std::min(n, first + Strip::kWidth); ++i) {
      for (std::size_t r = 0; r < m; ++r) {
        jacobian(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(i)) = out[r].by[i - first];
      }
    }
  }
  row_scale_ = jacobian.rowwise().norm();
  for (Eigen::Index r = 0; r < row_scale_.size(); ++r) {
    row_scale_[r] = row_scale_[r] > 1e-200 ? 1 / row_scale_[r] : 0;
  }
  jacobian = row_scale_.asDiagonal() * jacobian;
  qr_.compute(jacobian);
  return qr_.matrixQR().diagonal().cwiseAbs().array().max(1e-300).log().sum();
}

PlainMotion::Vector PlainMotion::solve(const Vector& residual) const {
  return column_scale_.cwiseProduct(qr_.solve(row_scale_.cwiseProduct(residual)));
}

PlainMotion::Vector PlainMotion::left(const Vector& x, const std::vector<TimeJet<Real>>& laws) const {
  const auto in = inputs<double>(laws, plain);
  Vector out(static_cast<Eigen::Index>(equations_.equations()));
  equations_.evaluate(x.data(), in.data(), out.data());
  return out;
}

// Uses the latest factorisation, which may be of a neighbouring posture.
void PlainMotion::derivatives(const Vector& x, const std::vector<TimeJet<Real>>& laws, Vector& v, Vector& a) const {
  const std::size_t n = equations_.unknowns(), m = equations_.equations();
  const auto in = inputs<TimeJet<double>>(laws, jet<double>);
  std::vector<TimeJet<double>> at(n), out(m);
  v = Vector::Zero(x.size()), a = v;
  Vector rate(static_cast<Eigen::Index>(m)), curve(rate.size());
  for (int k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto j = static_cast<Eigen::Index>(i);
      at[i] = {x[j], v[j], a[j]};
    }
    equations_.evaluate(at.data(), in.data(), out.data());
    for (std::size_t r = 0; r < m; ++r) {
      rate[static_cast<Eigen::Index>(r)] = out[r].rate;
      curve[static_cast<Eigen::Index>(r)] = out[r].curve;
    }
    v -= solve(rate);
    a -= solve(curve);
  }
}

PlainMotion::Start PlainMotion::start(const std::vector<std::string>& columns, const std::vector<double>& row,
                                      const std::vector<TimeJet<Real>>& laws, double& figure) {
  x_.assign(equations_.unknowns(), {});
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const auto at = std::find(columns.begin(), columns.end(), equations_.unknown_names()[i]);
    // All unknowns are outputs, because only fixed coordinates are left out.
    if (at == columns.end())
      throw Error(Error::Kind::input, equations_.unknown_names()[i] + " is not among the outputs");
    x_[i].value = row[static_cast<std::size_t>(at - columns.begin())];
  }
  return begin(laws, figure);
}

PlainMotion::Start PlainMotion::start_as_written(const std::vector<TimeJet<Real>>& laws, double& figure) {
  x_.clear();
  for (const Real value : equations_.as_written()) x_.emplace_back(value);
  return begin(laws, figure);
}

PlainMotion::Start PlainMotion::begin(const std::vector<TimeJet<Real>>& laws, double& figure) {
  const std::size_t n = equations_.unknowns();
  Vector x(static_cast<Eigen::Index>(n));
  column_scale_.resize(x.size());
  for (std::size_t i = 0; i < n; ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    x[j] = static_cast<double>(x_[i].value);
    column_scale_[j] = equations_.is_length()[i] ? equations_.length() : 1;
  }
  most_volume_ = least_volume_ = factorise(x, laws);
  const double smallest = qr_.matrixQR().diagonal().cwiseAbs().minCoeff();
  // The correction of the posture that the equations demand, and the residual that remains after it.
  const Vector residual = left(x, laws);
  const Vector correction = solve(residual);
  figure = std::max(size(correction), row_scale_.cwiseProduct(residual).cwiseAbs().maxCoeff());
  const double far = x.cwiseQuotient(column_scale_).cwiseAbs().maxCoeff();
  // Too near to a singularity, the correction does not measure the violation.
  if (smallest < 1e-6) return figure < 1e-5 ? Start::singular : Start::off_equations;
  if (figure > 1e-9 * std::max(far, 1.0) / smallest) return Start::off_equations;
  if (!settle(laws)) return Start::singular;
  const auto in = inputs<Real>(laws, [](const TimeJet<Real>& l) {
    return PlainEquations::Input<Real>{l.value, std::cos(l.value), std::sin(l.value)};
  });
  std::vector<Real> value(n);
  for (std::size_t i = 0; i < n; ++i) value[i] = x_[i].value;
  for (const Real off : equations_.angles_off(value.data(), in.data())) {
    if (std::abs(off) > 1e-6) {
      figure = static_cast<double>(off);
      return Start::off_law;
    }
  }
  return Start::right;
}

Real PlainMotion::advance(const Laws& laws) {
  const auto n = static_cast<Eigen::Index>(equations_.unknowns());
  Vector x(n), v, a, next_v, next_a;
  for (Eigen::Index i = 0; i < n; ++i) x[i] = static_cast<double>(x_[static_cast<std::size_t>(i)].value);
  double s = 0, stride = stride_;
  std::vector<TimeJet<Real>> now = laws(0);
  double volume = factorise(x, now);
  derivatives(x, now, v, a);
  std::vector<Real> turned = turned_, next_turned;
  std::vector<bool> met = met_, next_met;
  for (int attempt = 0; s < 1; ++attempt) {
    bool last = false;
    double h = stride;
    if (s + h >= 1 - 1e-9) h = 1 - s, last = true;
    const double to = last ? 1 : s + h;
    const std::vector<TimeJet<Real>> then = laws(to);
    const Vector predicted = x + h * v + h * h / 2 * a;
    Vector next = predicted;
    const double next_volume = factorise(next, then);
    const double rounding = kConverged * std::max(1.0, size(x));  // of a correction far from the origin
    double first = 0, before = 0;
    bool good = std::isfinite(next_volume) && std::abs(next_volume - volume) * care_ <= kVolume;
    for (int k = 0; good; ++k) {
      const Vector correction = solve(left(next, then));
      const double c = size(correction);
      next -= correction;
      if (k == 0) first = c;
      if (c <= rounding) break;
      good = c < 1e3 && k < 8 && (k == 0 || c <= kContraction * before);
      before = c;
    }
    if (good) {
      const double moved = size(next - x);
      good = first * care_ <= kCorrection * moved + 1e-9 + rounding;
    }
    if (good) {
      derivatives(next, then, next_v, next_a);
      // The tangent may turn only a little, unless the posture hardly moves.
      const double turn = size(next_v - v - h * a) * h;
      good = turn * care_ <= 0.2 * size(next - x) + 1e-9;
    }
    if (good) {
      next_turned = turned, next_met = met;
      good = unwrap(next, next_turned, next_met) || h < kMeet;
    }
    if (!good) {
      stride = h / 2;
      if (stride >= kShortest && attempt < kMostAttempts) continue;
      stride_ = 0.01;
      return s;
    }
    s = to;
    turned = next_turned, met = next_met;
    x = next, v = next_v, a = next_a, volume = next_volume, now = then;
    least_volume_ = std::min(least_volume_, volume), most_volume_ = std::max(most_volume_, volume);
    if (!last || h > 0.9 * stride) stride = std::min(1.0, 1.7 * h);
  }
  stride_ = std::max(stride, 1e-6);
  for (Eigen::Index i = 0; i < n; ++i) {
    x_[static_cast<std::size_t>(i)].value = x[i];
  }
  turned_ = turned, met_ = met;
  return 1;
}

Real PlainMotion::advance(Real t0, Real t1) {
  return advance([&](Real s) {
    const Real h = t1 - t0;
    std::vector<TimeJet<Real>> out = laws_at(equations_, t0 + s * h);
    for (TimeJet<Real>& l : out) l = {l.value, l.rate * h, l.curve * h * h};
    return out;
  });
}

void PlainMotion::follow(std::vector<PlainEquations::Column> angles) {
  angles_ = std::move(angles);
  turned_.clear();
  for (const TimeJet<Real>& angle : show(angles_)) turned_.push_back(angle.value);
  met_.assign(angles_.size(), false);
}

// The number of turns comes from the unwrapped angle (double), the angle itself from the present posture.
std::vector<TimeJet<Real>> PlainMotion::turned() const {
  std::vector<TimeJet<Real>> now = show(angles_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    now[i].value += kTwoPi * std::round((turned_[i] - now[i].value) / kTwoPi);
  }
  return now;
}

bool PlainMotion::unwrap(const Vector& x, std::vector<Real>& turned, std::vector<bool>& met) const {
  if (angles_.empty()) return true;
  std::vector<TimeJet<Real>> at(static_cast<std::size_t>(x.size()));
  for (std::size_t i = 0; i < at.size(); ++i) at[i].value = x[static_cast<Eigen::Index>(i)];
  const std::vector<TimeJet<Real>> now = equations_.show(angles_, at.data());
  bool sure = true;
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    const Real by = std::remainder(now[i].value - turned[i], kTwoPi);
    turned[i] += by;
    if (std::abs(by) * care_ <= 1) continue;
    sure = false;
    met[i] = true;
  }
  return sure;
}

// Residuals in long double, factorisation in double: each round adds about ten digits.
bool PlainMotion::settle(const std::vector<TimeJet<Real>>& laws) {
  const std::size_t n = equations_.unknowns(), m = equations_.equations();
  Vector x(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) x[static_cast<Eigen::Index>(i)] = static_cast<double>(x_[i].value);
  factorise(x, laws);
  condition_ = 1 / qr_.matrixQR().diagonal().cwiseAbs().minCoeff();
  const auto in = inputs<TimeJet<Real>>(laws, jet<Real>);
  std::vector<TimeJet<Real>> out(m);
  for (std::size_t i = 0; i < n; ++i) x_[i].rate = x_[i].curve = 0;
  Vector residual[3];
  for (Vector& r : residual) r.resize(static_cast<Eigen::Index>(m));
  // Derivatives far below this are treated as zero.
  Real least = 1e-9;
  for (const TimeJet<Real>& l : laws) least = std::max({least, std::abs(l.rate), std::sqrt(std::abs(l.curve))});
  least *= Real(1e-3);
  double before = kInfinity;
  for (int k = 0; k < 12; ++k) {
    equations_.evaluate(x_.data(), in.data(), out.data());
    for (std::size_t r = 0; r < m; ++r) {
      const auto j = static_cast<Eigen::Index>(r);
      residual[0][j] = static_cast<double>(out[r].value);
      residual[1][j] = static_cast<double>(out[r].rate);
      residual[2][j] = static_cast<double>(out[r].curve);
    }
    double worst = 0;
    Real most[3] = {1, least, least * least};
    for (std::size_t i = 0; i < n; ++i) {
      const Real l = column_scale_[static_cast<Eigen::Index>(i)];
      most[0] = std::max(most[0], std::abs(x_[i].value) / l);
      most[1] = std::max(most[1], std::abs(x_[i].rate) / l);
      most[2] = std::max(most[2], std::abs(x_[i].curve) / l);
    }
    for (int d = 0; d < 3; ++d) {
      const Vector c = solve(residual[d]);
      for (std::size_t i = 0; i < n; ++i) {
        Real& target = d == 0 ? x_[i].value : d == 1 ? x_[i].rate : x_[i].curve;
        target -= c[static_cast<Eigen::Index>(i)];
      }
      const double relative = most[d] > 0 ? size(c) / static_cast<double>(most[d]) : size(c) > 0 ? 1 : 0;
      worst = std::max(worst, relative);
    }
    if (!std::isfinite(worst)) return false;
    // Only rounding of long double remains, 1/2,048 of that of the judged doubles.
    const double remains = std::max(1e-13, 1e-17 * static_cast<double>(most[0]) * condition_ * condition_);
    if (worst < 1e-18 || (k > 3 && worst >= before / 2)) return std::min(worst, before) < remains;
    before = worst;
  }
  return before < 1e-13;
}

PlainRows::PlainRows(PlainMotion& motion, const std::vector<std::string>& columns) : motion_(motion) {
  std::vector<PlainEquations::Column> angles;
  for (const std::string& name : columns) {
    columns_.push_back(motion.equations().column(name));
    angle_.push_back(columns_.back().signed_angle ? static_cast<int>(angles.size()) : -1);
    if (columns_.back().signed_angle) angles.push_back(columns_.back());
  }
  motion.follow(std::move(angles));
}

std::vector<Real> PlainRows::now() {
  const double rate = motion_.scale(1) / (2 * std::numbers::pi);
  scale_[1] = std::max(scale_[1], rate);
  scale_[2] = std::max({scale_[2], motion_.scale(2) / std::pow(2 * std::numbers::pi, 2), rate * rate});
  const std::vector<TimeJet<Real>> jets = motion_.show(columns_), angles = motion_.turned();
  std::vector<Real> out;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const PlainEquations::Column& c = columns_[i];
    const TimeJet<Real>& jet = jets[i];
    out.push_back(is_angle(i)         ? angles[static_cast<std::size_t>(angle_[i])].value
                  : c.derivative == 0 ? jet.value
                  : c.derivative == 1 ? jet.rate
                                      : jet.curve);
  }
  return out;
}

bool PlainRows::knows_turns(std::size_t i) const {
  return is_angle(i) && motion_.knows_turns(static_cast<std::size_t>(angle_[i]));
}

}  // namespace assur::mechanisms
