#include "backends/residual.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "backends/with_lanes.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

// Calls entry(k, to, from) for each nonzero k: row `to`, factor of unknown `from`.
template <typename Entry>
void for_each_entry(const PackSystem& system, const Entry& entry) {
  const Pattern& p = system.pattern;
  const bool transposed = system.transpose == Transpose::yes;
  for (std::size_t j = 0; j < static_cast<std::size_t>(p.n); ++j) {
    const auto end = static_cast<std::size_t>(p.column_start[j + 1]);
    for (auto k = static_cast<std::size_t>(p.column_start[j]); k < end; ++k) {
      const auto i = static_cast<std::size_t>(p.row[k]);
      transposed ? entry(k, j, i) : entry(k, i, j);
    }
  }
}

// Calls element(i, lane) for n x lanes numbers, lanes innermost.
template <typename Element>
void for_each_element(std::size_t size, std::size_t lanes, const Element& element) {
  with_lanes(lanes, [&](auto w) {
    for (std::size_t i = 0; i < size; i += w) {
      for (std::size_t lane = 0; lane < w; ++lane) element(i + lane, lane);
    }
  });
}

// norm = max(norm, size); NaN if any size was not finite: comparisons ignore NaN, sums do not.
void raise(double& norm, double size) { norm = (size > norm ? size : norm) + size * 0; }

}  // namespace

void subtract_product(const PackSystem& system, std::span<const double> x, std::span<double> residual) {
  const double* __restrict const a = system.values.data();
  const double* __restrict const from_x = x.data();
  double* __restrict const r = residual.data();
  with_lanes(static_cast<std::size_t>(system.lanes), [&](auto w) {
    for_each_entry(system, [&](std::size_t k, std::size_t to, std::size_t from) {
      for (std::size_t lane = 0; lane < w; ++lane) r[to * w + lane] -= a[k * w + lane] * from_x[from * w + lane];
    });
  });
}

void subtract_product(const PackSystem& system, std::span<const double> x, std::span<double> residual,
                      std::span<double> weight) {
  const double* __restrict const a = system.values.data();
  const double* __restrict const from_x = x.data();
  double* __restrict const r = residual.data();
  double* __restrict const sum = weight.data();
  for (std::size_t i = 0; i < residual.size(); ++i) sum[i] = std::abs(r[i]);
  with_lanes(static_cast<std::size_t>(system.lanes), [&](auto w) {
    for_each_entry(system, [&](std::size_t k, std::size_t to, std::size_t from) {
      for (std::size_t lane = 0; lane < w; ++lane) {
        const double product = a[k * w + lane] * from_x[from * w + lane];
        r[to * w + lane] -= product;
        sum[to * w + lane] += std::abs(product);
      }
    });
  });
}

void norms(std::span<const double> x, std::span<double> norm) {
  std::fill(norm.begin(), norm.end(), 0.0);
  for_each_element(x.size(), norm.size(), [&](std::size_t i, std::size_t lane) { raise(norm[lane], std::abs(x[i])); });
}

void norms(std::span<const double> x, std::span<const double> scale, std::span<double> norm) {
  std::fill(norm.begin(), norm.end(), 0.0);
  for_each_element(x.size(), norm.size(),
                   [&](std::size_t i, std::size_t lane) { raise(norm[lane], std::abs(scale[i] * x[i])); });
}

void equilibrate(const PackSystem& system, std::span<double> row, std::span<double> column) {
  const double* __restrict const a = system.values.data();
  double* __restrict const r = row.data();
  double* __restrict const c = column.data();
  std::fill(row.begin(), row.end(), 0.0);
  std::fill(column.begin(), column.end(), 0.0);
  const auto invert = [](std::span<double> largest) {
    for (double& x : largest) x = x > 0 ? 1 / x : 1;
  };
  with_lanes(static_cast<std::size_t>(system.lanes), [&](auto w) {
    for_each_entry(system, [&](std::size_t k, std::size_t to, std::size_t) {
      for (std::size_t lane = 0; lane < w; ++lane) {
        r[to * w + lane] = std::max(r[to * w + lane], std::abs(a[k * w + lane]));
      }
    });
    invert(row);
    for_each_entry(system, [&](std::size_t k, std::size_t to, std::size_t from) {
      for (std::size_t lane = 0; lane < w; ++lane) {
        c[from * w + lane] = std::max(c[from * w + lane], r[to * w + lane] * std::abs(a[k * w + lane]));
      }
    });
    invert(column);
  });
}

void matrix_norms(const PackSystem& system, std::span<const double> row, std::span<const double> column,
                  std::span<double> norm, std::span<double> sum) {
  const double* __restrict const a = system.values.data();
  const double* __restrict const r = row.data();
  const double* __restrict const c = column.data();
  double* __restrict const s = sum.data();
  std::fill(sum.begin(), sum.end(), 0.0);
  with_lanes(static_cast<std::size_t>(system.lanes), [&](auto w) {
    for_each_entry(system, [&](std::size_t k, std::size_t to, std::size_t from) {
      for (std::size_t lane = 0; lane < w; ++lane) {
        s[to * w + lane] += std::abs(r[to * w + lane] * a[k * w + lane] * c[from * w + lane]);
      }
    });
  });
  norms(sum, norm);
}

void componentwise_errors(std::span<const double> residual, std::span<const double> weight, std::span<double> error) {
  std::fill(error.begin(), error.end(), 0.0);
  for_each_element(residual.size(), error.size(), [&](std::size_t i, std::size_t lane) {
    const double r = std::abs(residual[i]);
    raise(error[lane], r <= 0 ? 0 : r / weight[i]);
  });
}

void raise_vanishing_weights(const PackSystem& system, std::span<const double> x, std::span<double> weight,
                             std::span<double> column, std::span<double> row) {
  const auto lanes = static_cast<std::size_t>(system.lanes);
  const double vanishing = 1000 * system.pattern.n * kEps;
  std::fill(column.begin(), column.end(), 0.0);
  std::fill(row.begin(), row.end(), 0.0);
  for_each_entry(system, [&](std::size_t k, std::size_t, std::size_t from) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      double& largest = column[from * lanes + lane];
      largest = std::max(largest, std::abs(system.values[k * lanes + lane]));
    }
  });
  for_each_entry(system, [&](std::size_t k, std::size_t to, std::size_t from) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      double& largest = row[to * lanes + lane];
      largest = std::max(largest, std::abs(system.values[k * lanes + lane]) / column[from * lanes + lane]);
    }
  });
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    double norm_of_x = 0;
    for (std::size_t i = lane; i < x.size(); i += lanes) norm_of_x = std::max(norm_of_x, column[i] * std::abs(x[i]));
    for (std::size_t i = lane; i < x.size(); i += lanes) {
      const double product = row[i] * norm_of_x;
      if (weight[i] <= vanishing * product) weight[i] += product;
    }
  }
}

}  // namespace assur
