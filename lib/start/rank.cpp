#include "start/rank.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "equations/residual_scale.hpp"
#include "numbers.hpp"
#include "start/assembly.hpp"
#include "start/independent_rows.hpp"
#include "start/sparse_rank.hpp"

namespace assur {
namespace {
// Rows or columns. The sparse way takes over before kLargestDenseRank: its blocks may be as large as that.
constexpr Eigen::Index kLargestWhole = 400;

using Qr = RowQr;

// True if this entry belongs to the null vector whose own entry is 1.
bool counts(const Eigen::VectorXd& c, Eigen::Index i) {
  return std::abs(c[i]) > kLeastOfNullVector * std::max(1.0, c.cwiseAbs().maxCoeff());
}

// Column k >= rank of a pivoted QR as a combination of the first `rank` columns: the other entries of a null vector.
Eigen::VectorXd combination(const Qr& qr, Eigen::Index k) {
  const Eigen::Index r = qr.rank();
  return qr.matrixR().topLeftCorner(r, r).template triangularView<Eigen::Upper>().solve(qr.matrixR().col(k).head(r));
}

SparseRows scaled(const Eigen::SparseMatrix<double>& j) {
  SparseRows rows(j);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) /= std::max(rows.row(i).norm(), kLeastScale);
  Eigen::SparseMatrix<double> columns(rows);
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    if (const double n = columns.col(i).norm(); n > 0) columns.col(i) /= n;
  }
  return SparseRows(columns);
}

// The same for large parts.
void study_sparse(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
                  const DenseBlock& block, const std::vector<std::vector<double>>& at, RankStudy& out) {
  std::vector<SparseRows> postures;
  std::vector<Eigen::Index> rank;
  std::size_t best = 0;
  for (const std::vector<double>& posture : at) {
    postures.push_back(scaled(block.sparse_jacobian(posture)));
    rank.push_back(rank_of(postures.back()));
    if (rank.back() > rank[best]) best = rank.size() - 1;
  }
  out.rank = static_cast<Index>(rank[best]);
  out.singular_start = rank[0] < rank[best];
  const SparseRank found = sparse_rank(s, equations, unknowns, postures, best);
  const auto equation_at = [&](Eigen::Index k) { return equations[static_cast<std::size_t>(k)]; };
  for (const Eigen::Index k : found.kept) out.kept.push_back(equation_at(k));
  std::sort(out.kept.begin(), out.kept.end());
  for (std::size_t k = 0; k < found.dropped.size(); ++k) {
    const Index e = equation_at(found.dropped[k]);
    out.dropped.push_back(e);
    std::set<std::string> names = {s.equation_name(e)};
    for (const Eigen::Index row : found.combinations[k]) names.insert(s.equation_name(equation_at(row)));
    out.redundant.push_back({{names.begin(), names.end()}, s.equation_name(e)});
  }
  for (const Eigen::Index k : found.undetermined) out.undetermined.push_back(unknowns[static_cast<std::size_t>(k)]);
  std::sort(out.undetermined.begin(), out.undetermined.end());
}

}  // namespace

RankStudy study_rank(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
                     std::optional<double> laws_from, std::span<const Index> rather_dropped, std::vector<double>& q,
                     std::vector<Index>& column) {
  RankStudy out;
  const DenseBlock block(s, equations, unknowns, column);
  if (equations.empty()) {  // unknowns that nothing mentions
    out.undetermined.assign(unknowns.begin(), unknowns.end());
    return out;
  }
  out.residual = fit(s, equations, unknowns, q, column);

  const TimeGrid& grid = s.scene->time();
  std::vector<std::vector<double>> at = {q};
  std::vector<double> on_path = q;
  for (int step = 1; step <= kStepsOnPath && grid.step > 0 && laws_from; ++step) {
    if (!drive(s, *laws_from + step * grid.step, on_path.data(), nullptr, nullptr).ok()) break;
    if (fit(s, equations, unknowns, on_path, column) > kConsistent) break;
    if (step == kStepsOnPath / 2 || step == kStepsOnPath) at.push_back(on_path);
  }
  if (std::max(block.rows(), block.columns()) > kLargestWhole) {
    study_sparse(s, equations, unknowns, block, at, out);
    return out;
  }

  std::vector<Eigen::MatrixXd> postures;
  for (const std::vector<double>& posture : at) postures.push_back(scaled_rows(block.jacobian(posture)));
  std::size_t best = 0;
  Qr rows = factored(postures[0].transpose());  // at the best posture
  std::vector<Eigen::Index> rank = {rows.rank()};
  for (std::size_t i = 1; i < postures.size(); ++i) {
    Qr here = factored(postures[i].transpose());
    rank.push_back(here.rank());
    if (rank[i] <= rank[best]) continue;
    best = i;
    rows = std::move(here);
  }
  out.rank = static_cast<Index>(rank[best]);
  out.singular_start = rank[0] < rank[best];

  std::vector<Eigen::Index> rather_last;
  for (Eigen::Index row = 0; row < block.rows(); ++row) {
    const Index e = equations[static_cast<std::size_t>(row)];
    if (std::find(rather_dropped.begin(), rather_dropped.end(), e) != rather_dropped.end()) rather_last.push_back(row);
  }
  const std::vector<Eigen::Index> order = independent_first(postures[best], rows, rank[best], rather_last);
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
    const Qr basis = factored(kept);
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

  const Qr columns = factored(postures[best]);
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
