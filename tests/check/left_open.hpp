// Bounds for the errors of the outputs of a run, by columns, if its equations hold to a relative residual.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "decompositions.hpp"
#include "equations/system.hpp"
#include "index.hpp"
#include "outputs/output_program.hpp"
#include "structure/grouped_system.hpp"

namespace assur::test {

// The bounds are to first order and divided by the residual r. Every position equation i has an error of at most r s_i,
// where s_i is the scale of its residual; every velocity equation has at most r (|J| |v| + |b|) in maximum norms;
// acceleration equations likewise:
//   J dq = s e,   J dv = -B(v) dq + s' e',   J da = -B(a) dq - 2 B(v) dv + s'' e'',   |e|, |e'|, |e''| <= 1,
// where B(x) is the derivative of J(q) x. Each column takes the worst e, e' and e''.
class LeftOpen {
 public:
  // `structure` must have no eliminated unknowns and no callbacks.
  explicit LeftOpen(const GroupedSystem& structure)
      : system_(*structure.system),
        outputs_(system_, every_coordinate(system_)),
        columns_(column_names(system_).size()) {
    column_.assign(system_.coordinates.size(), -1);
    for (const SolvedGroup& g : structure.groups) {
      for (const std::int32_t u : g.unknowns) {
        column_[idx(u)] = static_cast<Eigen::Index>(unknowns_.size());
        unknowns_.push_back(u);
      }
      equations_.insert(equations_.end(), g.equations.begin(), g.equations.end());
    }
  }

  // One number for each column, in SI units, at a posture (all coordinates, in internal units) and its time.
  [[nodiscard]] std::vector<double> at(double time, std::vector<double> q) const {
    std::vector<double> out(columns_, 0.0);
    const auto n = static_cast<Eigen::Index>(unknowns_.size());
    if (n == 0) return out;
    std::vector<double> v(q.size(), 0.0), a(q.size(), 0.0);
    if (!drive(system_, time, q.data(), v.data(), a.data()).ok()) return out;
    v[0] = a[0] = 0;

    const Slopes at_q = slopes(q, 1);
    const Matrix inverse = at_q.of_unknowns.partialPivLu().inverse();
    const auto solve = [&](const Vector& rhs, std::vector<double>& x) {
      const Vector solved = inverse * rhs;
      for (Eigen::Index j = 0; j < n; ++j) x[idx(unknowns_[static_cast<std::size_t>(j)])] = solved[j];
    };
    const auto scale = [&](const Vector& size_of_rhs, const std::vector<double>& x) {
      return Vector::Constant(n, at_q.norm * largest(x) + size_of_rhs.maxCoeff());
    };
    Vector of_positions(n), rhs(n), size(n);
    for (Eigen::Index i = 0; i < n; ++i) of_positions[i] = residual_scale(system_, equation(i), q);
    apply(q, v, rhs, size);  // terms of the known coordinates
    solve(-rhs, v);
    const Vector of_velocities = scale(size, v);
    const Slopes at_v = slopes(v, 0);
    Vector curvature(n), size_of_curvature(n);
    apply_bilinear(v, curvature, size_of_curvature);
    apply(q, a, rhs, size);
    solve(-rhs - curvature, a);
    const Vector of_accelerations = scale(size + size_of_curvature, a);
    const Slopes at_a = slopes(a, 0);

    const Matrix q_e = inverse * of_positions.asDiagonal();
    const Matrix v_e = -inverse * (at_v.of_unknowns * q_e), v_f = inverse * of_velocities.asDiagonal();
    const Matrix a_e = -inverse * (at_a.of_unknowns * q_e + 2 * at_v.of_unknowns * v_e),
                 a_f = -2 * inverse * (at_v.of_unknowns * v_f), a_g = inverse * of_accelerations.asDiagonal();
    const Matrix none = Matrix::Zero(n, n);
    add(q, v, a, q_e, v_e, a_e, out);
    add(q, v, a, none, v_f, a_f, out);
    add(q, v, a, none, none, a_g, out);
    add(q, v, a, diagonal(q), none, none, out);  // rounding of the coordinates themselves
    add(q, v, a, none, diagonal(v), none, out);
    add(q, v, a, none, none, diagonal(a), out);
    add_rounding(q, v, a, out);
    return out;
  }

 private:
  static constexpr int kDraws = 8;
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;
  struct Slopes {
    Matrix of_unknowns;
    double norm = 0;  // of all coordinates: the largest sum of a row
  };

  [[nodiscard]] Index equation(Eigen::Index i) const { return equations_[static_cast<std::size_t>(i)]; }
  static std::vector<std::int32_t> every_coordinate(const System& system) {
    std::vector<std::int32_t> out(system.coordinates.size());
    std::iota(out.begin(), out.end(), 0);
    return out;
  }
  static double largest(std::span<const double> x) {
    double out = 0;
    for (const double each : x) out = std::max(out, std::abs(each));
    return out;
  }

  [[nodiscard]] Matrix diagonal(const std::vector<double>& x) const {
    Vector of_unknowns(static_cast<Eigen::Index>(unknowns_.size()));
    for (std::size_t j = 0; j < unknowns_.size(); ++j) of_unknowns[static_cast<Eigen::Index>(j)] = x[idx(unknowns_[j])];
    return of_unknowns.asDiagonal();
  }

  // J(q), or B(x), which is J without its linear part.
  [[nodiscard]] Slopes slopes(std::span<const double> x, int linear) const {
    const auto n = static_cast<Eigen::Index>(unknowns_.size());
    Slopes out{Matrix::Zero(n, n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      double sum = 0;
      const Equation& e = system_.equations[idx(equation(i))];
      const auto through = [&](Index form, double factor) {
        for (const Term& t : system_.form(form)) {
          const double value = system_.constants[idx(t.constant)] * factor;
          if (t.coordinate != kOne) sum += std::abs(value);
          if (const Eigen::Index j = column_[idx(t.coordinate)]; j >= 0) out.of_unknowns(i, j) += value;
        }
      };
      if (linear != 0 && e.linear >= 0) through(e.linear, 1);
      for (const Product& p : system_.products_of(e)) {
        const double c = system_.constants[idx(p.constant)];
        through(p.a, c * form_value(system_, p.b, x));
        through(p.b, c * form_value(system_, p.a, x));
      }
      out.norm = std::max(out.norm, sum);
    }
    return out;
  }

  // Computes J(q) x, and the sum of the absolute values of its terms.
  void apply(std::span<const double> q, std::span<const double> x, Vector& value, Vector& size) const {
    for (Eigen::Index i = 0; i < value.size(); ++i) {
      value[i] = size[i] = 0;
      gradient<double>(system_, equation(i), q, [&](Index c, double slope) {
        value[i] += slope * x[idx(c)];
        size[i] += std::abs(slope * x[idx(c)]);
      });
    }
  }

  // Computes B(x) x, and the sum of the absolute values of its terms.
  void apply_bilinear(std::span<const double> x, Vector& value, Vector& size) const {
    for (Eigen::Index i = 0; i < value.size(); ++i) {
      value[i] = size[i] = 0;
      for (const Product& p : system_.products_of(system_.equations[idx(equation(i))])) {
        const double term =
            2 * system_.constants[idx(p.constant)] * form_value(system_, p.a, x) * form_value(system_, p.b, x);
        value[i] += term;
        size[i] += std::abs(term);
      }
    }
  }

  // Adds the effect of an error of each equation on the columns.
  void add(const std::vector<double>& q, const std::vector<double>& v, const std::vector<double>& a, const Matrix& dq,
           const Matrix& dv, const Matrix& da, std::vector<double>& out) const {
    std::vector<double> change[3], columns(columns_);
    for (auto& c : change) c.assign(q.size(), 0.0);
    for (Eigen::Index e = 0; e < dq.cols(); ++e) {
      for (std::size_t j = 0; j < unknowns_.size(); ++j) {
        const auto row = static_cast<Eigen::Index>(j);
        change[0][idx(unknowns_[j])] = dq(row, e);
        change[1][idx(unknowns_[j])] = dv(row, e);
        change[2][idx(unknowns_[j])] = da(row, e);
      }
      outputs_.differentiate({q.data(), v.data(), a.data()}, {change[0].data(), change[1].data(), change[2].data()},
                             nullptr, columns.data());
      for (std::size_t c = 0; c < columns_; ++c) out[c] += std::abs(columns[c]);
    }
  }

  // Adds rounding errors of the inputs of measures: the largest for several random choices of signs, divided by
  // epsilon.
  void add_rounding(const std::vector<double>& q, const std::vector<double>& v, const std::vector<double>& a,
                    std::vector<double>& out) const {
    const std::vector<double> none(q.size(), 0.0);
    std::vector<double> columns(columns_), worst(columns_, 0.0);
    RandomSign sign(1);
    for (int k = 0; k < kDraws; ++k) {
      outputs_.differentiate({q.data(), v.data(), a.data()}, {none.data(), none.data(), none.data()}, &sign,
                             columns.data());
      for (std::size_t c = 0; c < columns_; ++c) worst[c] = std::max(worst[c], std::abs(columns[c]));
    }
    for (std::size_t c = 0; c < columns_; ++c) out[c] += worst[c] / std::numeric_limits<double>::epsilon();
  }

  const System& system_;
  OutputProgram outputs_;
  std::size_t columns_;
  std::vector<Eigen::Index> column_;  // of each coordinate
  std::vector<Index> unknowns_, equations_;
};

}  // namespace assur::test
