#include <cs.h>

#include "equations/dense_block.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

std::int32_t GroupedSystem::fill(const SolvedGroup& group) const {
  std::vector<Index> column(system->coordinates.size(), -1);
  const DenseBlock block(*system, group.equations, group.unknowns, column);
  Eigen::SparseMatrix<double> j = block.sparse_jacobian(start);
  j.makeCompressed();
  cs_di a{};
  a.nzmax = static_cast<int>(j.nonZeros());
  a.m = static_cast<int>(j.rows());
  a.n = static_cast<int>(j.cols());
  a.p = j.outerIndexPtr();
  a.i = j.innerIndexPtr();
  a.x = j.valuePtr();
  a.nz = -1;
  cs_dis* symbolic = cs_di_sqr(2, &a, 0);
  cs_din* numeric = symbolic == nullptr ? nullptr : cs_di_lu(&a, symbolic, 0.1);
  const std::int32_t fill = numeric == nullptr ? -1 : numeric->L->p[a.n] + numeric->U->p[a.n] - a.n;
  cs_di_nfree(numeric);
  cs_di_sfree(symbolic);
  return fill;
}

std::int32_t Structure::fill(std::int32_t group) const {
  return parts_->fill(parts_->groups[static_cast<std::size_t>(group)]);
}

}  // namespace assur
