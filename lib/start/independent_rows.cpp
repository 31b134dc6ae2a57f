#include "start/independent_rows.hpp"

#include <algorithm>
#include <cmath>

#include "equations/dense_block.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr int kMostExchanges = 64;  // the tests of structures take one

// Of the rows in `order` the first `rank` are independent. Exchanges rows until the other rows, as combinations of
// these, have no coefficient above kMostCoefficient (Gu and Eisenstat's strong rank-revealing factorisation).
void spread(const Eigen::MatrixXd& a, Eigen::Index rank, std::vector<Eigen::Index>& order) {
  if (rank == 0 || rank == a.rows()) return;
  for (int exchange = 0; exchange < kMostExchanges; ++exchange) {
    Eigen::MatrixXd kept(a.cols(), rank), others(a.cols(), a.rows() - rank);
    for (Eigen::Index k = 0; k < rank; ++k) kept.col(k) = a.row(order[static_cast<std::size_t>(k)]);
    for (Eigen::Index k = rank; k < a.rows(); ++k) others.col(k - rank) = a.row(order[static_cast<std::size_t>(k)]);
    const Eigen::MatrixXd shares = kept.householderQr().solve(others).cwiseAbs();
    Eigen::Index i = 0, k = 0;
    if (!(shares.maxCoeff(&i, &k) > kMostCoefficient)) return;
    std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(rank + k)]);
  }
}

}  // namespace

Eigen::MatrixXd scaled_rows(Eigen::MatrixXd j) {
  for (Eigen::Index i = 0; i < j.rows(); ++i) j.row(i) /= std::max(j.row(i).norm(), kLeastScale);
  for (Eigen::Index i = 0; i < j.cols(); ++i) {
    if (const double n = j.col(i).norm(); n > 0) j.col(i) /= n;
  }
  return j;
}

RowQr factored(const Eigen::MatrixXd& a) {
  RowQr qr(a.rows(), a.cols());
  // n eps sigma_1, with a margin for postures that are exact to a few eps only.
  qr.setThreshold(64 * kEps * static_cast<double>(std::max(a.rows(), a.cols())));
  qr.compute(a);
  return qr;
}

std::vector<Eigen::Index> independent_first(const Eigen::MatrixXd& a, const RowQr& rows, Eigen::Index rank,
                                            std::span<const Eigen::Index> rather_last) {
  std::vector<Eigen::Index> order(rows.colsPermutation().indices().begin(), rows.colsPermutation().indices().end());
  if (static_cast<Eigen::Index>(rather_last.size()) == a.rows() - rank) {
    std::stable_partition(order.begin(), order.end(), [&](Eigen::Index row) {
      return std::find(rather_last.begin(), rather_last.end(), row) == rather_last.end();
    });
  }
  spread(a, rank, order);
  std::sort(order.begin() + rank, order.end());
  return order;
}

}  // namespace assur
