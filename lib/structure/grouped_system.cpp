#include "structure/grouped_system.hpp"

#include <algorithm>

#include "index.hpp"

namespace assur {

Shape GroupedSystem::shape(const SolvedGroup& group) const {
  const GroupClass& c = classes[idx(group.group_class)];
  Shape s;
  s.n = c.n;
  s.nnz = pattern(group.group_class).nnz();
  s.groups = static_cast<Index>(std::count_if(
      groups.begin(), groups.end(), [&](const SolvedGroup& g) { return g.group_class == group.group_class; }));
  s.rhs = 1 + group.derivatives;
  return s;
}

const Pattern& GroupedSystem::pattern(std::int32_t group_class) const { return classes[idx(group_class)].pattern; }

std::vector<ClassSize> class_sizes(const GroupedSystem& s) {
  std::vector<ClassSize> sizes(s.classes.size());
  std::vector<std::int32_t> on_level(s.classes.size(), 0), level(s.classes.size(), -1);
  for (const SolvedGroup& g : s.groups) {  // in the order of levels
    const std::size_t c = idx(g.group_class);
    on_level[c] = level[c] == g.level ? on_level[c] + 1 : 1;
    level[c] = g.level;
    ++sizes[c].groups;
    sizes[c].side_by_side = std::max(sizes[c].side_by_side, on_level[c]);
  }
  return sizes;
}

Structure::Structure(std::shared_ptr<const GroupedSystem> parts) : parts_(std::move(parts)) {}

Formulation Structure::formulation() const { return parts_->formulation; }
std::vector<Group> Structure::groups() const { return {parts_->groups.begin(), parts_->groups.end()}; }
std::int32_t Structure::classes() const { return static_cast<Index>(parts_->classes.size()); }
std::int32_t Structure::levels() const { return parts_->levels; }
const StructureCounts& Structure::counts() const { return *parts_; }
const std::vector<std::string>& Structure::undetermined() const { return parts_->undetermined; }
const std::vector<Redundancy>& Structure::redundant() const { return parts_->redundant; }
const LeftOut& Structure::left_out() const { return parts_->left_out; }
const std::vector<Diagnostic>& Structure::notes() const { return parts_->notes; }
const std::string& Structure::cannot_assemble() const { return parts_->cannot_assemble; }
std::string Structure::name_of(Place place) const { return parts_->name_of(place); }
Shape Structure::shape(std::int32_t group) const { return parts_->shape(parts_->groups[idx(group)]); }
const Pattern& Structure::pattern(std::int32_t group_class) const { return parts_->pattern(group_class); }

}  // namespace assur
