#include "check/matrices.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "assur/backend.hpp"
#include "backends/refined.hpp"
#include "decompositions.hpp"
#include "numbers.hpp"

namespace assur::check {
namespace {

Dense filled(std::size_t n, const std::function<double(std::size_t, std::size_t)>& entry) {
  Dense a(n, std::vector<double>(n));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) a[i][j] = entry(i, j);
  }
  return a;
}

// Entries of random sign between 1/2 and 1, and n on the diagonal: well conditioned.
Dense random_matrix(std::size_t n) {
  std::mt19937_64 random(5);
  return filled(n, [&](std::size_t i, std::size_t j) {
    const double x = 0.5 + static_cast<double>(random() >> 11) * 0x1p-54;
    return (random() % 2 ? x : -x) + (i == j ? static_cast<double>(n) : 0);
  });
}

// Two equal rows of whole numbers, so that elimination ends at an exact zero.
Dense repeated_row(std::size_t n) {
  Dense a = filled(n, [n](std::size_t i, std::size_t j) { return i == j ? 2.0 : j == (i + 1) % n ? 1.0 : 0.0; });
  a[n - 1] = a[0];
  return a;
}

Pattern pattern_of(const Dense& a, std::vector<double>& values) {
  Pattern pattern;
  pattern.n = static_cast<std::int32_t>(a.size());
  pattern.column_start.push_back(0);
  for (std::size_t j = 0; j < a.size(); ++j) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (a[i][j] == 0) continue;
      pattern.row.push_back(static_cast<std::int32_t>(i));
      values.push_back(a[i][j]);
    }
    pattern.column_start.push_back(pattern.nnz());
  }
  return pattern;
}

// Condition in the maximum norm, after scaling rows and columns to unit length: bad scaling alone harms no solver.
double condition_of(const Dense& a) {
  const auto n = static_cast<Eigen::Index>(a.size());
  Eigen::MatrixXd m(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) m(i, j) = a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  if (!m.allFinite()) return kInfinity;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (const double size = m.row(i).lpNorm<Eigen::Infinity>(); size > 0) m.row(i) /= size;
  }
  for (Eigen::Index j = 0; j < n; ++j) {
    if (const double size = m.col(j).lpNorm<Eigen::Infinity>(); size > 0) m.col(j) /= size;
  }
  const Eigen::VectorXd sigma = Eigen::JacobiSVD<Eigen::MatrixXd>(m).singularValues();
  return sigma[0] / sigma[n - 1];
}

struct Task {
  Pattern pattern;
  std::vector<double> values;
  std::vector<double> right, solution;
};

// x_j: random sign, between 1/2 and 1 divided by the largest entry of column j, so that rounding of other columns hides
// no column; b = A x rounded once.
Task task_of(const Dense& a) {
  Task task;
  task.pattern = pattern_of(a, task.values);
  std::mt19937_64 random(11);
  for (std::size_t j = 0; j < a.size(); ++j) {
    double largest = 0;
    for (const std::vector<double>& row : a) largest = std::max(largest, std::abs(row[j]));
    const double x = (0.5 + static_cast<double>(random() >> 11) * 0x1p-54) / (largest > 0 ? largest : 1);
    task.solution.push_back(random() % 2 ? x : -x);
  }
  for (const std::vector<double>& row : a) {
    long double sum = 0;
    for (std::size_t j = 0; j < row.size(); ++j) sum += static_cast<long double>(row[j]) * task.solution[j];
    task.right.push_back(static_cast<double>(sum));
  }
  return task;
}

// Normwise, maximum norms.
double backward_error(const Dense& a, const Task& task, const std::vector<double>& x) {
  long double residual = 0, largest_row = 0, largest = 0, right = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    long double sum = -static_cast<long double>(task.right[i]), row = 0;
    for (std::size_t j = 0; j < a.size(); ++j) {
      sum += static_cast<long double>(a[i][j]) * x[j];
      row += std::abs(a[i][j]);
    }
    residual = std::max(residual, std::abs(sum));
    largest_row = std::max(largest_row, row);
    largest = std::max(largest, std::abs(static_cast<long double>(x[i])));
    right = std::max(right, std::abs(static_cast<long double>(task.right[i])));
  }
  return static_cast<double>(residual / (largest_row * largest + right));
}

// Componentwise, relative.
double forward_error(const Task& task, const std::vector<double>& x) {
  double off = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double d = std::abs(x[i] - task.solution[i]) / std::abs(task.solution[i]);
    if (!(d <= off)) off = std::isnan(d) ? kInfinity : d;
  }
  return off;
}

// "", "+float", "+refine", "+float+refine"
std::string policy_of(bool single, bool refine) {
  return std::string(single ? "+float" : "") + (refine ? "+refine" : "");
}

Run solve(const Dense& a, const Task& task, const Backend& backend, bool single, bool refine, double accuracy) {
  Run run;
  run.strategy = std::string(backend.id) + policy_of(single, refine);
  const std::unique_ptr<LinearSolver> solver =
      make_solver(backend, ThreadBudget{1}, single ? Precision::binary32 : Precision::binary64, refine);
  std::vector<double> x = task.right;
  Status status = solver->analyze(task.pattern, 1);
  if (status.ok()) status = solver->factorize(task.values);
  if (status.ok()) status = solver->solve(x, 1);
  if (!status.ok()) {
    run.verdict = name(status.code);
    return run;
  }
  run.forward_error = forward_error(task, x);
  run.backward_error = backward_error(a, task, x);
  const Figures figures = solver->figures(0);
  const double lost =
      std::max(figures.pivot_growth, figures.reciprocal_condition > 0 ? 1 / figures.reciprocal_condition : 0);
  run.verdict = run.forward_error <= accuracy ? "pass" : lost * kEps > accuracy ? "inaccurate" : "wrong";
  return run;
}

}  // namespace

Dense matrix(const std::string& name, const Parameters& set) {
  const auto get = [&](const char* parameter, double otherwise) {
    const auto found = set.find(parameter);
    return found == set.end() ? otherwise : found->second.value();
  };
  const auto n = static_cast<std::size_t>(get("n", 20));
  if (name == "wilkinson") {  // partial pivoting doubles the last column at each step
    return filled(n, [n](std::size_t i, std::size_t j) { return j == n - 1 || i == j ? 1.0 : i > j ? -1.0 : 0.0; });
  }
  if (name == "hilbert") {
    return filled(n, [](std::size_t i, std::size_t j) { return 1.0 / static_cast<double>(i + j + 1); });
  }
  if (name == "kahan") {  // its pivots do not show that it is nearly singular (SIAM Review 8, 1966)
    const double angle = get("angle", 1.2);
    return filled(n, [angle](std::size_t i, std::size_t j) {
      return i > j ? 0.0 : std::pow(std::sin(angle), static_cast<double>(i)) * (i == j ? 1 : -std::cos(angle));
    });
  }
  if (name == "repeated_row") return repeated_row(n);
  Dense a = random_matrix(n);
  const auto scale = [&](const std::function<double(std::size_t, std::size_t)>& factor) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) a[i][j] *= factor(i, j);
    }
  };
  if (name == "random") return a;
  if (name == "graded") {
    const double factor = get("factor", 1 / 8.0);
    scale([factor](std::size_t i, std::size_t j) { return std::pow(factor, static_cast<double>(i + j)); });
  } else if (name == "tiny") {
    scale([](std::size_t, std::size_t) { return 1e-150; });
  } else if (name == "huge") {
    scale([](std::size_t, std::size_t) { return 1e150; });
  } else if (name == "zero_row") {
    a[n / 2].assign(n, 0.0);
  } else if (name == "nan") {
    a[n / 2][n / 2] = kNan;
  } else {
    throw Error(Error::Kind::input, "there is no matrix '" + name + "'");
  }
  return a;
}

Result run_matrix(const Case& c, const std::function<bool()>& stop) {
  Result result;
  result.what = c;
  const Dense a = matrix(c.matrix, c.set);
  const Task task = task_of(a);
  for (const Backend& backend : backends()) {
    const Shape shape{.n = task.pattern.n, .nnz = task.pattern.nnz()};
    if (!backend.why_not(shape, ThreadBudget{1}).empty()) continue;
    for (const bool single : {false, true}) {
      if (single && !backend.single) continue;
      for (const bool refine : {false, true}) {
        const auto& only = c.strategies;
        if (!only.empty() && std::find(only.begin(), only.end(), policy_of(single, refine)) == only.end()) continue;
        if (stop()) {
          result.interrupted = true;
          return result;
        }
        result.add(solve(a, task, backend, single, refine, c.limit()));
      }
    }
  }
  const double condition = condition_of(a);
  if (std::isfinite(condition)) {
    result.condition = condition;
    result.bound = kEps * condition;
  }
  return result;
}

}  // namespace assur::check
