#include "structure/rank.hpp"

#include <algorithm>
#include <set>

#include "decompositions.hpp"
#include "numbers.hpp"
#include "structure/assembly.hpp"
#include "structure/dense_block.hpp"

namespace assur {
namespace {
constexpr double kNonzero = 1e-8;          // smaller entries of a null vector, relative to the largest, are zero
constexpr Eigen::Index kLargestQr = 3000;  // larger ones take minutes

constexpr double kMostShare = 1.5;
constexpr int kMostExchanges = 64;
constexpr Eigen::Index kLargestSpread = 400;  // each exchange is a dense QR

using Qr = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;

// Scales rows, then columns, to unit length.
Eigen::MatrixXd scaled(Eigen::MatrixXd j) {
  for (Eigen::Index i = 0; i < j.rows(); ++i) {
    if (const double n = j.row(i).norm(); n > 0) j.row(i) /= n;
  }
  for (Eigen::Index i = 0; i < j.cols(); ++i) {
    if (const double n = j.col(i).norm(); n > 0) j.col(i) /= n;
  }
  return j;
}

Qr factor(const Eigen::MatrixXd& a) {
  Qr qr(a.rows(), a.cols());
  // n eps sigma_1, with a margin for postures that are exact to a few eps only.
  qr.setThreshold(64 * kEps * static_cast<double>(std::max(a.rows(), a.cols())));
  qr.compute(a);
  return qr;
}

// True if this entry belongs to the null vector whose own entry is 1.
bool counts(const Eigen::VectorXd& c, Eigen::Index i) {
  return std::abs(c[i]) > kNonzero * std::max(1.0, c.cwiseAbs().maxCoeff());
}

// Of the rows in `order` the first `rank` are independent. Exchanges rows until the other rows, as combinations of
// these, have no coefficient above kMostShare (Gu and Eisenstat's strong rank-revealing factorisation).
void spread(const Eigen::MatrixXd& a, Eigen::Index rank, std::vector<Eigen::Index>& order) {
  if (rank == 0 || rank == a.rows() || rank > kLargestSpread) return;
  for (int exchange = 0; exchange < kMostExchanges; ++exchange) {
    Eigen::MatrixXd kept(a.cols(), rank), others(a.cols(), a.rows() - rank);
    for (Eigen::Index k = 0; k < rank; ++k) kept.col(k) = a.row(order[static_cast<std::size_t>(k)]);
    for (Eigen::Index k = rank; k < a.rows(); ++k) others.col(k - rank) = a.row(order[static_cast<std::size_t>(k)]);
    const Eigen::MatrixXd shares = kept.householderQr().solve(others).cwiseAbs();
    Eigen::Index i = 0, k = 0;
    if (!(shares.maxCoeff(&i, &k) > kMostShare)) return;
    std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(rank + k)]);
  }
}

// Column k >= rank of a pivoted QR as a combination of the first `rank` columns: the other entries of a null vector.
Eigen::VectorXd combination(const Qr& qr, Eigen::Index k) {
  const Eigen::Index r = qr.rank();
  return qr.matrixR().topLeftCorner(r, r).template triangularView<Eigen::Upper>().solve(qr.matrixR().col(k).head(r));
}

}  // namespace

RankStudy study_rank(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
                     std::optional<double> laws_from, std::vector<double>& q, std::vector<Index>& column) {
  RankStudy out;
  const DenseBlock block(s, equations, unknowns, column);
  if (std::max(block.rows(), block.columns()) > kLargestQr) {
    throw Error(Error::Kind::input, "a part with " + std::to_string(block.columns()) + " unknowns and " +
                                        std::to_string(block.rows()) +
                                        " equations is structurally singular, and too large (limit: 3000) to find out "
                                        "numerically which equations are redundant; split the scene to locate them");
  }
  if (equations.empty()) {  // unknowns that nothing mentions
    out.undetermined.assign(unknowns.begin(), unknowns.end());
    return out;
  }
  out.residual = fit(s, equations, unknowns, q, column);

  const TimeGrid& grid = s.scene->time();
  std::vector<Eigen::MatrixXd> postures = {scaled(block.jacobian(q))};
  std::vector<double> on_path = q;
  for (int step = 1; step <= 7 && grid.step > 0 && laws_from; ++step) {
    if (!drive(s, *laws_from + step * grid.step, on_path.data(), nullptr, nullptr).ok()) break;
    if (fit(s, equations, unknowns, on_path, column) > 1e-10) break;
    if (step == 3 || step == 7) postures.push_back(scaled(block.jacobian(on_path)));
  }

  std::size_t best = 0;
  std::vector<Eigen::Index> rank;
  for (std::size_t i = 0; i < postures.size(); ++i) {
    rank.push_back(factor(postures[i].transpose()).rank());
    if (rank[i] > rank[best]) best = i;
  }
  out.rank = static_cast<Index>(rank[best]);
  out.singular_start = rank[0] < rank[best];

  const Qr rows = factor(postures[best].transpose());
  std::vector<Eigen::Index> order(rows.colsPermutation().indices().begin(), rows.colsPermutation().indices().end());
  spread(postures[best], rank[best], order);
  const auto equation_at = [&](Eigen::Index k) {
    return equations[static_cast<std::size_t>(order[static_cast<std::size_t>(k)])];
  };
  for (Eigen::Index k = 0; k < block.rows(); ++k) (k < rank[best] ? out.kept : out.dropped).push_back(equation_at(k));
  // Uses the null vectors at all postures, because an entry may vanish at one of them by chance.
  std::vector<std::set<std::string>> names(static_cast<std::size_t>(block.rows() - rank[best]));
  for (const Eigen::MatrixXd& posture : postures) {
    if (rank[best] == 0) break;
    const Eigen::MatrixXd permuted = posture(order, Eigen::all);
    const Eigen::MatrixXd kept = permuted.topRows(rank[best]).transpose();
    const Qr basis = factor(kept);
    if (basis.rank() < rank[best]) continue;
    for (Eigen::Index k = rank[best]; k < block.rows(); ++k) {
      const Eigen::VectorXd c = basis.solve(permuted.row(k).transpose());
      for (Eigen::Index i = 0; i < c.size(); ++i) {
        if (counts(c, i)) {
          names[static_cast<std::size_t>(k - rank[best])].insert(s.equation_name(equation_at(i)));
        }
      }
    }
  }
  for (Eigen::Index k = rank[best]; k < block.rows(); ++k) {
    std::set<std::string>& set = names[static_cast<std::size_t>(k - rank[best])];
    set.insert(s.equation_name(equation_at(k)));
    out.redundant.push_back({{set.begin(), set.end()}, s.equation_name(equation_at(k))});
  }
  std::sort(out.kept.begin(), out.kept.end());

  const Qr columns = factor(postures[best]);
  std::set<Index> undetermined;
  for (Eigen::Index k = columns.rank(); k < block.columns(); ++k) {
    const auto unknown_at = [&](Eigen::Index i) {
      return unknowns[static_cast<std::size_t>(columns.colsPermutation().indices()[i])];
    };
    const Eigen::VectorXd c = combination(columns, k);
    undetermined.insert(unknown_at(k));
    for (Eigen::Index i = 0; i < c.size(); ++i) {
      if (counts(c, i)) undetermined.insert(unknown_at(i));
    }
  }
  out.undetermined.assign(undetermined.begin(), undetermined.end());
  return out;
}

}  // namespace assur
