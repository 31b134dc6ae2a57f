// The core alone: laws, strategies and the solvers that it brings with it.
#include <cstdio>
#include <string>

#include <assur/backend.hpp>
#include <assur/law.hpp>
#include <assur/strategy.hpp>

int main() {
  const assur::Strategy strategy = assur::parse_strategy("irreducible/eigen+once 1x1");
  const std::string text = assur::to_string(strategy);
  const assur::Motion motion = assur::Law::polynomial({1, 2, 3})(2);
  std::printf("%s, %g %g %g, %zu solver(s)\n", text.c_str(), motion.value, motion.rate, motion.acceleration,
              assur::core_backends().size());
  const bool right = assur::parse_strategy(text) == strategy && motion.value == 17 && motion.rate == 14 &&
                     motion.acceleration == 6 && !assur::core_backends().empty();
  return right ? 0 : 1;
}
