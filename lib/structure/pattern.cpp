#include <algorithm>

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

const Pattern& Structure::pattern(std::int32_t group_class) const { return classes[idx(group_class)].pattern; }

}  // namespace assur
