#include "matrices.hpp"

#include <algorithm>
#include <string>

#include "assur/structure.hpp"
#include "equations/evaluator.hpp"

namespace assur::bench {
namespace {

constexpr int kDifferent = 8;  // different matrices; further ones repeat them
constexpr int kLegUnknowns = 15;

std::vector<test::Matrix> leg_jacobians(int count) {
  const Structure s = analyze(sample("stewart:platforms=" + std::to_string((count + 5) / 6)));
  std::vector<test::Matrix> legs;
  for (const Group& g : s.groups) {
    if (static_cast<int>(legs.size()) == count) break;
    if (static_cast<int>(g.unknowns.size()) != kLegUnknowns) continue;
    const GroupClass& c = s.classes[static_cast<std::size_t>(g.group_class)];
    const Program program = compile(c, s.pattern(g.group_class));
    const auto gather = [](const std::vector<std::int32_t>& from, const std::vector<double>& values) {
      std::vector<double> out;
      for (const std::int32_t i : from) out.push_back(values[static_cast<std::size_t>(i)]);
      return out;
    };
    std::vector<double> coefficients(program.coefficients.size());
    bind_coefficients(program, gather(g.constants, s.system->constants), coefficients.data(), 1);
    const auto evaluator = make_evaluator(*s.system, program, 1);
    evaluator->set_inputs(coefficients.data(), gather(g.inputs, s.start).data());
    test::Matrix& leg = legs.emplace_back();
    leg.pattern = program.pattern;
    leg.values.resize(program.pattern.row.size());
    std::vector<double> phi(kLegUnknowns);
    evaluator->evaluate(gather(g.unknowns, s.start).data(), phi.data(), leg.values.data());
  }
  return legs;
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
