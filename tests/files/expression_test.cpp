#include "files/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace assur {
namespace {

using Findings = std::vector<Expressions::Finding>;

std::string text(const Findings& findings) {
  std::string lines;
  for (const auto& finding : findings) lines += finding.parameter + ": " + finding.what + "\n";
  return lines;
}

TEST(Expression, KnowsConstantsAndFunctionsInRad) {
  Expressions expressions;
  EXPECT_EQ(text(expressions.define({})), "");
  EXPECT_EQ(expressions.evaluate("pi").value, std::numbers::pi);
  EXPECT_EQ(expressions.evaluate("e").value, std::numbers::e);
  EXPECT_EQ(expressions.evaluate("sin(pi/6)").value, std::sin(std::numbers::pi / 6));
  EXPECT_EQ(expressions.evaluate("atan2(1, -1)").value, std::atan2(1.0, -1.0));
  EXPECT_EQ(expressions.evaluate(" -2^2 + 1e-3 ").value, -4 + 1e-3);
  EXPECT_EQ(expressions.evaluate("1 < 2 ? 3 : 4").value, 3);
}

TEST(Expression, ReadsParametersInAnyOrder) {
  Expressions expressions;
  const auto findings = expressions.define({{"a", "2*b"}, {"b", "c + 0.1"}, {"c", 0.8}});
  EXPECT_EQ(text(findings), "");
  EXPECT_EQ(expressions.evaluate("a").value, 2 * (0.8 + 0.1));
  EXPECT_EQ(expressions.evaluate("a + b*c").value, 2 * (0.8 + 0.1) + (0.8 + 0.1) * 0.8);
}

TEST(Expression, FollowsALongChainOfParameters) {
  std::vector<Expressions::Parameter> chain;
  constexpr int kLength = 20000;
  for (int i = 0; i < kLength; ++i) chain.push_back({"p" + std::to_string(i), "p" + std::to_string(i + 1) + " + 1"});
  chain.push_back({"p" + std::to_string(kLength), 0.5});
  Expressions expressions;
  EXPECT_EQ(text(expressions.define(chain)), "");
  EXPECT_EQ(expressions.evaluate("p0").value, kLength + 0.5);
}

TEST(Expression, NamesCyclesOnceAndMarksDependentParameters) {
  Expressions expressions;
  const auto findings =
      expressions.define({{"x", "y"}, {"a", "b"}, {"b", "2*c"}, {"c", "a"}, {"y", "a"}, {"s", "s+1"}});
  EXPECT_EQ(text(findings),
            "a: parameters define each other in a circle: a -> b -> c -> a\n"
            "s: parameters define each other in a circle: s -> s\n");
  const auto result = expressions.evaluate("x + 1");
  EXPECT_TRUE(result.follows);
  EXPECT_FALSE(result.ok());
  EXPECT_EQ(result.what, "");
}

TEST(Expression, DoesNotReportDependentsOfABrokenParameter) {
  Expressions expressions;
  EXPECT_EQ(text(expressions.define({{"a", "1/0"}, {"b", "a + q"}, {"c", "broken"}}, {"broken"})),
            "a: '=1/0' is inf; a finite number is wanted\nb: there is no parameter 'q'\n");
  EXPECT_TRUE(expressions.evaluate("a*2").follows);
  EXPECT_TRUE(expressions.evaluate("c").follows);
}

TEST(Expression, RefusesReservedNames) {
  Expressions expressions;
  EXPECT_EQ(text(expressions.define({{"pi", 3.0}, {"sqrt", 1.0}})),
            "pi: 'pi' is a constant or function of expressions; choose another name\n"
            "sqrt: 'sqrt' is a constant or function of expressions; choose another name\n");
  EXPECT_EQ(expressions.evaluate("pi").value, std::numbers::pi);
}

TEST(Expression, RefusesNamesThatAreTooLong) {
  const std::string longest(100, 'n'), longer(101, 'n'), far(255, 'm');
  Expressions expressions;
  EXPECT_EQ(text(expressions.define({{"a", "2*" + longest}, {longest, 0.5}, {longer, 1.0}, {far, "1 + 1"}})),
            far + ": '" + far.substr(0, 100) +
                "... (255 characters)' is too long for a parameter: 100 characters at most\n" + longer + ": '" +
                longer + "' is too long for a parameter: 100 characters at most\n");
  EXPECT_EQ(expressions.evaluate("a").value, 1);
  Expressions used;
  EXPECT_EQ(text(used.define({{longer, 1.0}, {"b", longer + " + 1"}, {"c", "b"}})),
            longer + ": '" + longer + "' is too long for a parameter: 100 characters at most\n");
  EXPECT_TRUE(used.evaluate("c").follows);
}

TEST(Expression, RefusesInvalidText) {
  Expressions expressions;
  EXPECT_EQ(text(expressions.define({{"crank", 0.8}})), "");
  EXPECT_EQ(expressions.evaluate("crnk").what, "there is no parameter 'crnk'; did you mean 'crank'?");
  EXPECT_EQ(expressions.evaluate("t").what, "there is no parameter 't'; expressions do not depend on time, laws do");
  EXPECT_EQ(expressions.evaluate("_pi").what, "there is no parameter '_pi'");
  EXPECT_EQ(expressions.evaluate("2*(coss(1))").what, "there is no function 'coss'; did you mean 'cos'?");
  EXPECT_EQ(expressions.evaluate("").what, "an expression is missing after '='");
  EXPECT_EQ(expressions.evaluate("1, 2").what, "'=1, 2' gives 2 numbers; one is wanted");
  EXPECT_EQ(expressions.evaluate("sqrt(-1)").what, "'=sqrt(-1)' is nan; a finite number is wanted");
  EXPECT_EQ(expressions.evaluate("2*").what, "'=2*' cannot be read: unexpected end of expression");
  EXPECT_EQ(expressions.evaluate("2 crank").what, "'=2 crank' cannot be read: unexpected variable \"crank\"");
  EXPECT_FALSE(expressions.evaluate("crank = 2").ok());
  EXPECT_FALSE(expressions.evaluate("\"text\"").ok());
  EXPECT_EQ(expressions.evaluate("crank").value, 0.8);  // the parser can be used afterwards
}

TEST(Expression, GivesTheSameValueEveryTime) {
  Expressions expressions;
  EXPECT_EQ(text(expressions.define({{"a", 0.3}})), "");
  const double first = expressions.evaluate("exp(a)*sinh(a)^3").value;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(expressions.evaluate("exp(a)*sinh(a)^3").value, first);
  EXPECT_FALSE(expressions.evaluate("rnd()").ok());
}

}  // namespace
}  // namespace assur
