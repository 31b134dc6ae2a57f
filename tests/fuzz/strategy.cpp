#include "assur/strategy.hpp"

#include "fuzz/targets.hpp"

namespace assur::fuzz {

bool strategy(std::string_view bytes) {
  return accepts([&] {
    const Strategy strategy = parse_strategy(bytes);
    require(parse_strategy(to_string(strategy)) == strategy, "a strategy is what its text says");
  });
}

}  // namespace assur::fuzz
