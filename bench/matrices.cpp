#include "matrices.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "measure/matrices.hpp"
#include "structure/grouped_system.hpp"

namespace assur::bench {
namespace {

constexpr int kDifferent = 8;  // different matrices; further ones repeat them

std::vector<test::Matrix> leg_jacobians(int count) {
  const GroupedSystem s = group_equations(sample("stewart:platforms=" + std::to_string((count + 5) / 6)));
  const auto leg = std::find_if(s.classes.begin(), s.classes.end(), [](const GroupClass& c) { return c.n == 15; });
  measure::Matrices legs = measure::jacobians(s, static_cast<std::int32_t>(leg - s.classes.begin()), count);
  std::vector<test::Matrix> all;
  for (auto& values : legs.values) all.push_back({legs.pattern, std::move(values)});
  return all;
}

}  // namespace

std::vector<test::Matrix> make_matrices(std::string_view kind, int n, int count) {
  if (kind == "legs") return leg_jacobians(count);
  test::Random random(static_cast<std::uint64_t>(n));
  std::vector<test::Matrix> all;
  for (int i = 0; i < std::min(count, kDifferent); ++i) {
    all.push_back(kind == "ring" ? test::ring(n, random) : test::dense(n, random));
  }
  while (static_cast<int>(all.size()) < count) all.push_back(all[all.size() - kDifferent]);
  return all;
}

}  // namespace assur::bench
