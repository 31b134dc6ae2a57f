#include <algorithm>
#include <set>

#include "assur/structure.hpp"
#include "index.hpp"

namespace assur {

Shape Structure::shape(const Group& group) const {
  const GroupClass& c = classes[idx(group.group_class)];
  Shape s;
  s.n = c.n;
  s.nnz = pattern(group.group_class).nnz();
  s.groups = static_cast<Index>(
      std::count_if(groups.begin(), groups.end(), [&](const Group& g) { return g.group_class == group.group_class; }));
  s.rhs = 1 + group.derivatives;
  return s;
}

Pattern Structure::pattern(std::int32_t group_class) const { return jacobian_pattern(classes[idx(group_class)]); }

Pattern jacobian_pattern(const GroupClass& c) {
  std::vector<std::set<Index>> rows(idx(c.n));  // for each column
  for (Index i = 0; i < c.n; ++i) {
    const GroupClass::Equation& e = c.equations[idx(i)];
    const auto take = [&](Index f) {
      if (f < 0) return;
      for (Index t = c.form_start[idx(f)]; t < c.form_start[idx(f) + 1]; ++t) {
        const Index u = c.terms[idx(t)].coordinate;
        if (u >= 0 && u < c.n) rows[idx(u)].insert(i);
      }
    };
    take(e.linear);
    for (Index p = e.products_begin; p < e.products_end; ++p) {
      take(c.products[idx(p)].a);
      take(c.products[idx(p)].b);
    }
  }
  Pattern out;
  out.n = c.n;
  out.column_start = {0};
  for (const auto& column : rows) {
    out.row.insert(out.row.end(), column.begin(), column.end());
    out.column_start.push_back(static_cast<Index>(out.row.size()));
  }
  return out;
}

}  // namespace assur
