#include "start/sparse_rank.hpp"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseQR>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <utility>

#include "decompositions.hpp"
#include "graph/blocks.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "start/independent_rows.hpp"

namespace assur {
namespace {

constexpr double kNegligible = 1e-13;  // smaller remainders of a row of length 1 are rounding
constexpr int kMostRounds = 16;        // of exchanges; the tests of structures take none

using Columns = Eigen::SparseMatrix<double>;

// The columns of a matrix: the first `rank` in this order are independent.
struct Order {
  Eigen::Index rank = 0;
  std::vector<Eigen::Index> columns;
  Columns r;  // the triangular factor
};

// Columns and rows in the order of a breadth-first search, which makes a band of a chain of loops. The search starts at
// the column that a first search reaches last (Cuthill and McKee 1969).
struct Band {
  std::vector<Eigen::Index> columns, rows;
};
Band band_of(const Columns& a, const std::vector<Eigen::Index>& sources) {
  const SparseRows by_rows(a);
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(a.cols())), seen_row(static_cast<std::size_t>(a.rows()));
  const auto search = [&](const std::vector<Eigen::Index>& from, Band& out) {
    const std::size_t first = out.columns.size();
    out.columns.insert(out.columns.end(), from.begin(), from.end());
    for (const Eigen::Index c : from) seen[static_cast<std::size_t>(c)] = 1;
    for (std::size_t k = first; k < out.columns.size(); ++k) {
      for (Columns::InnerIterator e(a, out.columns[k]); e; ++e) {
        if (std::exchange(seen_row[static_cast<std::size_t>(e.row())], 1) != 0) continue;
        out.rows.push_back(e.row());
        for (SparseRows::InnerIterator f(by_rows, e.row()); f; ++f) {
          if (std::exchange(seen[static_cast<std::size_t>(f.col())], 1) == 0) out.columns.push_back(f.col());
        }
      }
    }
  };
  Band out;
  search(sources, out);
  for (Eigen::Index c = 0; c < a.cols(); ++c) {
    if (seen[static_cast<std::size_t>(c)] != 0) continue;
    Band first;
    search({c}, first);
    for (const Eigen::Index k : first.columns) seen[static_cast<std::size_t>(k)] = 0;
    for (const Eigen::Index k : first.rows) seen_row[static_cast<std::size_t>(k)] = 0;
    search({first.columns.back()}, out);
  }
  for (Eigen::Index r = 0; r < a.rows(); ++r) {
    if (seen_row[static_cast<std::size_t>(r)] == 0) out.rows.push_back(r);
  }
  return out;
}

// Among columns with the same last row, short ones come first, because they make the smallest blocks.
Order factor(const Columns& a, const std::vector<Eigen::Index>& sources = {}) {
  Band band = band_of(a, sources);
  std::vector<int> place(static_cast<std::size_t>(a.rows()));
  for (std::size_t k = 0; k < band.rows.size(); ++k) {
    place[static_cast<std::size_t>(band.rows[k])] = static_cast<int>(k);
  }
  std::vector<std::pair<int, int>> key(static_cast<std::size_t>(a.cols()), {-1, 0});  // last row, entries
  for (Eigen::Index c = 0; c < a.cols(); ++c) {
    auto& [last, entries] = key[static_cast<std::size_t>(c)];
    for (Columns::InnerIterator e(a, c); e; ++e) {
      last = std::max(last, place[static_cast<std::size_t>(e.row())]);
      ++entries;
    }
  }
  std::stable_sort(band.columns.begin(), band.columns.end(), [&](Eigen::Index x, Eigen::Index y) {
    return key[static_cast<std::size_t>(x)] < key[static_cast<std::size_t>(y)];
  });
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < band.columns.size(); ++k) {
    for (Columns::InnerIterator e(a, band.columns[k]); e; ++e) {
      entries.emplace_back(place[static_cast<std::size_t>(e.row())], static_cast<int>(k), e.value());
    }
  }
  Columns ordered(a.rows(), a.cols());
  ordered.setFromTriplets(entries.begin(), entries.end());
  ordered.makeCompressed();
  Eigen::SparseQR<Columns, Eigen::NaturalOrdering<int>> qr;
  qr.setPivotThreshold(64 * kEps * static_cast<double>(std::max(a.rows(), a.cols())));
  qr.compute(ordered);
  Order out{qr.rank(), {}, qr.matrixR()};
  for (const int k : qr.colsPermutation().indices()) out.columns.push_back(band.columns[static_cast<std::size_t>(k)]);
  return out;
}

// Expresses rows of a matrix by its kept rows, which form a square matrix in block triangular form.
class Combinations {
 public:
  Combinations(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
               const std::vector<Eigen::Index>& kept)
      : place_(unknowns.size()), block_of_(unknowns.size()), rest_(unknowns.size(), 0.0) {
    std::vector<Index> chosen;
    for (const Eigen::Index r : kept) chosen.push_back(equations[static_cast<std::size_t>(r)]);
    const Blocks blocks = decompose(s, chosen, unknowns);
    is_usable_ = blocks.square();
    for (Index b = 0; b < blocks.size(); ++b) {
      is_usable_ = is_usable_ && blocks.unknowns_of(b).size() <= kLargestDenseRank;
    }
    if (!is_usable_) return;
    std::vector<Index> row_of(s.equations.size(), -1), column_of(s.coordinates.size(), -1);
    for (std::size_t i = 0; i < equations.size(); ++i) row_of[idx(equations[i])] = static_cast<Index>(i);
    for (std::size_t j = 0; j < unknowns.size(); ++j) column_of[idx(unknowns[j])] = static_cast<Index>(j);
    for (Index b = 0; b < blocks.size(); ++b) {
      Block& block = blocks_.emplace_back();
      for (const Index e : blocks.equations_of(b)) block.rows.push_back(row_of[idx(e)]);
      for (const Index u : blocks.unknowns_of(b)) {
        const Index j = column_of[idx(u)];
        block_of_[idx(j)] = b;
        place_[idx(j)] = static_cast<Eigen::Index>(block.columns.size());
        block.columns.push_back(j);
      }
    }
  }

  // False if large blocks remain.
  [[nodiscard]] bool is_usable() const { return is_usable_; }

  void factor(const SparseRows& a) {
    a_ = &a;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      Block& block = blocks_[b];
      const auto n = static_cast<Eigen::Index>(block.rows.size());
      Eigen::MatrixXd transposed = Eigen::MatrixXd::Zero(n, n);
      for (Eigen::Index i = 0; i < n; ++i) {
        for (SparseRows::InnerIterator e(a, block.rows[static_cast<std::size_t>(i)]); e; ++e) {
          const auto j = static_cast<std::size_t>(e.col());
          if (block_of_[j] == static_cast<Index>(b)) transposed(place_[j], i) = e.value();
        }
      }
      block.transposed.compute(transposed);
    }
  }

  // Expresses row r by kept rows: calls use(row, coefficient) for each of them, from the last block to the first.
  template <class Use>
  void express(Eigen::Index r, Use&& use) {
    subtract(r, -1, -1);
    while (!open_.empty()) {
      const Index b = *open_.begin();
      open_.erase(open_.begin());
      const Block& block = blocks_[idx(b)];
      Eigen::VectorXd right(static_cast<Eigen::Index>(block.columns.size()));
      for (std::size_t j = 0; j < block.columns.size(); ++j) {
        right[static_cast<Eigen::Index>(j)] = std::exchange(rest_[idx(block.columns[j])], 0.0);
      }
      if (right.lpNorm<Eigen::Infinity>() <= kNegligible) continue;
      const Eigen::VectorXd c = block.transposed.solve(right);
      for (std::size_t i = 0; i < block.rows.size(); ++i) {
        const double share = c[static_cast<Eigen::Index>(i)];
        if (share == 0) continue;
        subtract(block.rows[i], share, b);
        use(static_cast<Eigen::Index>(block.rows[i]), share);
      }
    }
  }

 private:
  struct Block {
    std::vector<Index> rows, columns;
    Eigen::PartialPivLU<Eigen::MatrixXd> transposed;
  };

  // Subtracts `share` times row r outside of block `without`.
  void subtract(Eigen::Index r, double share, Index without) {
    for (SparseRows::InnerIterator e(*a_, r); e; ++e) {
      const auto j = static_cast<std::size_t>(e.col());
      if (block_of_[j] == without) continue;
      rest_[j] -= share * e.value();
      open_.insert(block_of_[j]);
    }
  }

  bool is_usable_ = false;
  std::vector<Block> blocks_;        // in solving order
  std::vector<Eigen::Index> place_;  // columns: index within the block
  std::vector<Index> block_of_;      // columns
  std::vector<double> rest_;         // columns: remainder of the row that is expressed
  std::set<Index, std::greater<>> open_;
  const SparseRows* a_ = nullptr;
};

// Exchanges dropped rows for kept ones, so that the dropped ones become combinations with small coefficients. Skips
// rows that an earlier exchange used, so that the kept rows stay independent. False if nothing was exchanged.
bool exchange(Combinations& combinations, SparseRank& out) {
  std::set<Eigen::Index> used;
  std::vector<std::size_t> place(out.kept.size() + out.dropped.size());
  for (std::size_t k = 0; k < out.kept.size(); ++k) place[static_cast<std::size_t>(out.kept[k])] = k;
  bool any = false;
  for (Eigen::Index& dropped : out.dropped) {
    std::vector<Eigen::Index> uses;
    Eigen::Index most = -1;
    double largest = kMostCoefficient;
    combinations.express(dropped, [&](Eigen::Index row, double share) {
      if (std::abs(share) > kLeastOfNullVector) uses.push_back(row);
      if (std::abs(share) > largest && used.count(row) == 0) largest = std::abs(share), most = row;
    });
    if (most < 0) continue;
    used.insert(uses.begin(), uses.end());
    std::swap(out.kept[place[static_cast<std::size_t>(most)]], dropped);
    any = true;
  }
  return any;
}

// Columns with an entry in a null vector.
std::vector<Eigen::Index> null_columns(const SparseRows& a) {
  const Order order = factor(Columns(a));
  std::set<Eigen::Index> out;
  const Columns leading = order.r.topLeftCorner(order.rank, order.rank);
  for (Eigen::Index k = order.rank; k < a.cols(); ++k) {
    out.insert(order.columns[static_cast<std::size_t>(k)]);
    const Eigen::VectorXd right = Eigen::VectorXd(order.r.col(k)).head(order.rank);
    const Eigen::VectorXd c = leading.triangularView<Eigen::Upper>().solve(right);
    const double least = kLeastOfNullVector * std::max(1.0, c.size() == 0 ? 0.0 : c.lpNorm<Eigen::Infinity>());
    for (Eigen::Index i = 0; i < c.size(); ++i) {
      if (std::abs(c[i]) > least) out.insert(order.columns[static_cast<std::size_t>(i)]);
    }
  }
  return {out.begin(), out.end()};
}

}  // namespace

Eigen::Index rank_of(const SparseRows& rows) { return factor(Columns(rows.transpose())).rank; }

SparseRank sparse_rank(const System& s, std::span<const Index> equations, std::span<const Index> unknowns,
                       const std::vector<SparseRows>& postures, std::size_t best) {
  SparseRank out;
  const SparseRows& a = postures[best];
  // Starting from the drivers, keeps the first equations that determine their unknowns, so that the blocks are small.
  std::vector<Eigen::Index> sources;
  std::vector<Index> mentioned;
  for (std::size_t i = 0; i < equations.size(); ++i) {
    s.mentioned(equations[i], mentioned);
    const auto is_driven = [&](Index c) { return s.coordinates[idx(c)].role == Role::driven; };
    if (std::any_of(mentioned.begin(), mentioned.end(), is_driven)) sources.push_back(static_cast<Eigen::Index>(i));
  }
  const Order order = factor(Columns(a.transpose()), sources);
  out.kept.assign(order.columns.begin(), order.columns.begin() + order.rank);
  out.dropped.assign(order.columns.begin() + order.rank, order.columns.end());
  out.combinations.resize(out.dropped.size());
  if (static_cast<Eigen::Index>(out.kept.size()) < a.cols()) {
    out.undetermined = null_columns(a);
    return out;
  }
  for (int round = 0; round < kMostRounds; ++round) {
    Combinations combinations(s, equations, unknowns, out.kept);
    if (!combinations.is_usable()) return out;
    combinations.factor(a);
    if (!exchange(combinations, out)) break;
  }
  // An entry may vanish at one posture by chance.
  Combinations combinations(s, equations, unknowns, out.kept);
  if (!combinations.is_usable()) return out;
  for (const SparseRows& posture : postures) {
    combinations.factor(posture);
    for (std::size_t k = 0; k < out.dropped.size(); ++k) {
      combinations.express(out.dropped[k], [&](Eigen::Index row, double share) {
        if (std::abs(share) > kLeastOfNullVector) out.combinations[k].push_back(row);
      });
    }
  }
  return out;
}

}  // namespace assur
