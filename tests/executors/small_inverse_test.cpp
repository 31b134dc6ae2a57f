// Inverses by cofactors, on every executor, against Eigen in extended precision.
#include "program/small_inverse-inl.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "executors/executors.hpp"
#include "numbers.hpp"
#include "program/step_graph.hpp"
#include "properties/small_random_scenes.hpp"

namespace assur {
namespace {

constexpr double kSmallest = 0x1p-30;  // volume

// Inputs: a matrix, row after row, and a right-hand side. Outputs: the solution, the same by columns, and whether the
// matrix is too close to a singular one.
template <int N>
StepProgram program() {
  Graph graph;
  const auto input = [&](int i) { return graph.load({Memory::inputs, static_cast<std::uint32_t>(i)}); };
  std::uint32_t next = 0;
  const auto put = [&](const Value& v) { graph.store({Memory::outputs, next++}, v); };
  Value a[N][N], b[N], x[N], sum[N];
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) a[i][j] = input(N * i + j);
    b[i] = input(N * N + i);
  }
  HWY_NAMESPACE::SmallInverse<Value, N> inverse;
  const Value poor = inverse.invert(a);
  inverse.solve(b, x);
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      const Value part = inverse.entry(j, i) * b[i];
      sum[j] = i == 0 ? part : sum[j] + part;
    }
  }
  for (const Value& v : x) put(v);
  for (const Value& v : sum) put(v);
  put(poor);
  return {{graph.phase()}, {}};
}

template <int N>
void expect_accurate() {
  using Matrix = Eigen::Matrix<double, N, N>;
  using Exact = Eigen::Matrix<long double, N, N>;
  using Column = Eigen::Matrix<double, N, 1>;
  std::array<std::size_t, kMemories> sizes{};
  sizes[static_cast<std::size_t>(Memory::inputs)] = N * N + N;
  sizes[static_cast<std::size_t>(Memory::outputs)] = 2 * N + 1;
  for (const test::NamedExecutor& e : test::executors_of(program<N>(), {1, 4, 8})) {
    SCOPED_TRACE(e.name);
    test::Draw draw(N);
    int poor = 0;
    for (int k = 0; k < 2000; ++k) {
      // Singular values of any size between 1 and 1e-12, rows of any length.
      const auto random = [&] { return Column::NullaryExpr([&] { return draw.real(-1, 1); }); };
      const auto sizes_of = [&](double low, double high) {
        return Column(Column::NullaryExpr([&] { return std::pow(10, draw.real(low, high)); }));
      };
      const auto rotation = [&] {
        Matrix columns;
        for (int i = 0; i < N; ++i) columns.col(i) = random();
        return Matrix(columns.householderQr().householderQ());
      };
      const Matrix a = sizes_of(-3, 3).asDiagonal() * (rotation() * sizes_of(-12, 0).asDiagonal() * rotation()).eval();
      const Column b = a.rowwise().norm().cwiseProduct(Column(random()));
      test::StepMemory m(sizes, e.lanes);
      for (std::size_t l = 0; l < static_cast<std::size_t>(e.lanes); ++l) {
        for (std::uint32_t i = 0; i < N * N; ++i) m({Memory::inputs, i}, l) = a(i / N, i % N);
        for (std::uint32_t i = 0; i < N; ++i) m({Memory::inputs, N * N + i}, l) = b[i];
      }
      e.executor->run(m.at);
      const Exact exact = a.template cast<long double>();
      const auto volume =
          static_cast<double>(std::abs(exact.fullPivLu().determinant()) / exact.rowwise().norm().prod());
      const double found = m({Memory::outputs, 2 * N}, 0);
      if (volume > 2 * kSmallest || volume < kSmallest / 2) {
        EXPECT_EQ(found, volume < kSmallest ? 1 : 0) << volume;
      }
      if (found > 0) {
        ++poor;
        continue;
      }
      const Column x = exact.fullPivLu().solve(b.template cast<long double>()).template cast<double>();
      const double bound = 16 * kEps / volume * (x.cwiseAbs().maxCoeff() + 1);
      for (std::uint32_t i = 0; i < 2 * N; ++i) EXPECT_NEAR(m({Memory::outputs, i}, 0), x[i % N], bound) << volume;
    }
    EXPECT_GT(poor, 50);
    EXPECT_LT(poor, 1000);
  }
}

TEST(SmallInverse, IsAsAccurateAsTheVolumeOfTheRowsAllows) {
  expect_accurate<2>();
  expect_accurate<3>();
}

TEST(SmallInverse, RefusesMatricesWithoutInverse) {
  std::array<std::size_t, kMemories> sizes{};
  sizes[static_cast<std::size_t>(Memory::inputs)] = 12;
  sizes[static_cast<std::size_t>(Memory::outputs)] = 7;
  for (const test::NamedExecutor& e : test::executors_of(program<3>(), {1, 8})) {
    SCOPED_TRACE(e.name);
    for (const std::array<double, 3>& last :
         {std::array<double, 3>{1, 2, 0}, {0, 0, kNan}, {kInfinity, 0, 1}, {1, 0, 1e-12}}) {
      test::StepMemory m(sizes, e.lanes);
      const std::array<double, 9> matrix = {1, 0, 0, 0, 1, 0, last[0], last[1], last[2]};
      for (std::uint32_t i = 0; i < 9; ++i) m({Memory::inputs, i}, 0) = matrix[i];
      e.executor->run(m.at);
      EXPECT_EQ(m({Memory::outputs, 6}, 0), 1) << last[0] << " " << last[1] << " " << last[2];
    }
  }
}

}  // namespace
}  // namespace assur
