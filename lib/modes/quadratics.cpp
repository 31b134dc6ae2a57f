#include "modes/quadratics.hpp"

#include <cmath>

#include "decompositions.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

// Singular values below this share of the largest one count as 0. Coefficients carry errors of some epsilon.
constexpr double kDependent = 1e-12;
// A constant above this, in equations scaled to 1, contradicts an equation without unknowns.
constexpr double kContradicts = 1e-10;

// x^T a x + b^T x + c
struct Polynomial {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
  double c = 0;

  [[nodiscard]] double norm() const { return std::sqrt(a.squaredNorm() + b.squaredNorm() + c * c); }
};

std::vector<Polynomial> expanded(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
                                 const std::vector<double>& q) {
  std::vector<Index> column(s.coordinates.size(), -1);
  for (std::size_t j = 0; j < unknowns.size(); ++j) column[idx(unknowns[j])] = static_cast<Index>(j);
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  const auto slope = [&](Index form) {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
    for (const Term& t : s.form(form)) {
      if (const Index j = column[idx(t.coordinate)]; j >= 0) b[j] += s.constants[idx(t.constant)];
    }
    return b;
  };
  std::vector<Polynomial> all;
  for (const Index e : equations) {
    Polynomial p{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), residual<double>(s, e, q)};
    gradient<double>(s, e, q, [&](Index c, double value) {
      if (const Index j = column[idx(c)]; j >= 0) p.b[j] += value;
    });
    double largest = 0;
    for (const Product& product : s.products_of(s.equations[idx(e)])) {
      const Eigen::VectorXd a = slope(product.a), b = slope(product.b);
      const Eigen::MatrixXd ab = s.constants[idx(product.constant)] * a * b.transpose();
      p.a += (ab + ab.transpose()) / 2;
      largest = std::max(largest, ab.cwiseAbs().maxCoeff());
    }
    // The remainder of a cancellation is not a quadratic term.
    p.a = (p.a.array().abs() > 64 * kEps * largest).select(p.a, 0.0);
    all.push_back(std::move(p));
  }
  return all;
}

// Combinations sum_i weights(i, k) p_i, one for each column.
std::vector<Polynomial> combined(const std::vector<Polynomial>& all, const Eigen::MatrixXd& weights) {
  std::vector<Polynomial> out;
  for (Eigen::Index k = 0; k < weights.cols(); ++k) {
    Polynomial sum{0 * all.front().a, 0 * all.front().b, 0};
    for (Eigen::Index i = 0; i < weights.rows(); ++i) {
      sum.a += weights(i, k) * all[static_cast<std::size_t>(i)].a;
      sum.b += weights(i, k) * all[static_cast<std::size_t>(i)].b;
      sum.c += weights(i, k) * all[static_cast<std::size_t>(i)].c;
    }
    out.push_back(std::move(sum));
  }
  return out;
}

void scale(std::vector<Polynomial>& all) {
  for (Polynomial& p : all) {
    const double norm = p.norm();
    if (!(norm > 0)) continue;
    p.a /= norm;
    p.b /= norm;
    p.c /= norm;
  }
}

class Elimination {
 public:
  Elimination(std::vector<Polynomial> all, Quadratics& out) : all_(std::move(all)), out_(out) {}

  // Takes out linear combinations without quadratic terms, as long as there are any.
  void run() {
    while (!all_.empty() && out_.size() > 0 && out_.kind == Quadratics::Kind::square) {
      scale(all_);
      const auto rows = static_cast<Eigen::Index>(all_.size());
      const Eigen::Index n = out_.size();
      Eigen::MatrixXd terms(rows, n * n);
      for (Eigen::Index i = 0; i < rows; ++i) terms.row(i) = all_[static_cast<std::size_t>(i)].a.reshaped().transpose();
      const Eigen::JacobiSVD<Eigen::MatrixXd> svd(terms, Eigen::ComputeFullU);
      const Eigen::VectorXd& sigma = svd.singularValues();
      const Eigen::Index rank = (sigma.array() > kDependent).count();
      if (rank == rows) break;
      const std::vector<Polynomial> linear = combined(all_, svd.matrixU().rightCols(rows - rank));
      std::vector<Polynomial> others = combined(all_, svd.matrixU().leftCols(rank));
      all_ = std::move(others);
      eliminate(linear);
    }
    if (out_.kind == Quadratics::Kind::square && static_cast<Eigen::Index>(all_.size()) < out_.size()) {
      out_.kind = Quadratics::Kind::dependent;
    }
    if (out_.size() == 0) return;
    scale(all_);
    for (const Polynomial& p : all_) {
      Eigen::MatrixXd form(out_.size() + 1, out_.size() + 1);
      form << p.c, p.b.transpose() / 2, p.b / 2, p.a;
      out_.forms.push_back(form / form.norm());
    }
  }

 private:
  void eliminate(const std::vector<Polynomial>& linear) {
    const auto rows = static_cast<Eigen::Index>(linear.size());
    const Eigen::Index n = out_.size();
    Eigen::MatrixXd l(rows, n);
    Eigen::VectorXd c(rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
      l.row(i) = linear[static_cast<std::size_t>(i)].b.transpose();
      c[i] = linear[static_cast<std::size_t>(i)].c;
    }
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(l, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Eigen::VectorXd& sigma = svd.singularValues();
    const Eigen::Index rank = (sigma.array() > kDependent).count();
    const Eigen::VectorXd right = -(svd.matrixU().transpose() * c);
    if (rank < rows && right.tail(rows - rank).cwiseAbs().maxCoeff() > kContradicts) {
      out_.kind = Quadratics::Kind::contradictory;
      return;
    }
    const Eigen::VectorXd at =
        svd.matrixV().leftCols(rank) * (right.head(rank).array() / sigma.head(rank).array()).matrix();
    const Eigen::MatrixXd free = svd.matrixV().rightCols(n - rank);
    for (Polynomial& p : all_) {
      p.c += p.b.dot(at) + at.dot(p.a * at);
      p.b = (free.transpose() * (p.b + 2 * (p.a * at))).eval();
      p.a = (free.transpose() * p.a * free).eval();
    }
    out_.origin += out_.basis * at;
    out_.basis = (out_.basis * free).eval();
    // Without unknowns left, an equation is a constant, which must vanish.
    if (out_.size() == 0) {
      for (const Polynomial& p : all_) {
        if (std::abs(p.c) > kContradicts) out_.kind = Quadratics::Kind::contradictory;
      }
    }
  }

  std::vector<Polynomial> all_;
  Quadratics& out_;
};

}  // namespace

Quadratics quadratics(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
                      const std::vector<double>& q) {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  Quadratics out;
  out.origin.resize(n);
  for (Eigen::Index j = 0; j < n; ++j) out.origin[j] = q[idx(unknowns[static_cast<std::size_t>(j)])];
  out.basis = Eigen::MatrixXd::Identity(n, n);
  Elimination(expanded(s, equations, unknowns, q), out).run();
  return out;
}

}  // namespace assur
