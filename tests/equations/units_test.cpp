// Scaling all lengths of a scene by a power of two keeps its equations bitwise.
#include <gtest/gtest.h>

#include "equations/lowering.hpp"
#include "evaluation/coefficients.hpp"
#include "references/scaled.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

using enum Formulation;

std::vector<double> coefficients(const GroupedSystem& s, const SolvedGroup& g) {
  const GroupClass& program = look::class_of(s, g);
  std::vector<double> constants, out(program.coefficients.size());
  for (const Index k : g.constants) constants.push_back(s.system->constants[static_cast<std::size_t>(k)]);
  bind_coefficients(program, constants.data(), out.data(), 1);
  return out;
}

class Units : public testing::TestWithParam<const char*> {};

TEST_P(Units, PowersOfTwoKeepResultsBitwise) {
  const Scene drawn = sample(GetParam());
  const Scene scene = references::scaled(drawn, 0);  // built again as well, which normalises vectors
  const System plain = lower(std::make_shared<const Scene>(scene));
  for (const int k : {-20, -1, 3, 20}) {
    const Scene other = references::scaled(drawn, k);
    const System scaled = lower(std::make_shared<const Scene>(other));
    EXPECT_EQ(scaled.length_exponent, plain.length_exponent + k);
    EXPECT_EQ(scaled.constants, plain.constants);
    EXPECT_EQ(scaled.guess, plain.guess);
    EXPECT_EQ(scaled.form_start, plain.form_start);
    for (const Formulation f : {global, groups, irreducible}) {
      const GroupedSystem a = look::structure(scene, f), b = look::structure(other, f);
      EXPECT_EQ(a.start, b.start);
      EXPECT_EQ(a.system->constants, b.system->constants);
      ASSERT_EQ(a.groups.size(), b.groups.size());
      for (std::size_t g = 0; g < a.groups.size(); ++g) {
        EXPECT_EQ(look::class_of(a, a.groups[g]), look::class_of(b, b.groups[g]));
        EXPECT_EQ(coefficients(a, a.groups[g]), coefficients(b, b.groups[g]));
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Samples, Units,
                         testing::Values("stewart", "andrews", "four_bar:3", "slider_crank:offset=0.05", "gough",
                                         "rings:legs=1,n=12"),
                         [](const auto& row) {
                           return std::string(row.param).substr(0, std::string(row.param).find(':'));
                         });

// Typical lengths are about 1 in internal units, for every unit of the scene.
TEST(Units, TypicalLengthsAreOne) {
  for (const char* name : {"stewart", "andrews", "four_bar", "slider_crank", "gough"}) {
    const System s = lower(std::make_shared<const Scene>(sample(name)));
    std::vector<double> lengths;
    for (const Constraint& c : s.scene->constraints()) {
      if (const auto* d = c.as<Distance>()) lengths.push_back(d->value.value_or(1) / s.unit(1));
    }
    for (const double x : lengths) {
      EXPECT_GT(x, 0.1) << name;
      EXPECT_LT(x, 10) << name;
    }
  }
}

}  // namespace
}  // namespace assur
