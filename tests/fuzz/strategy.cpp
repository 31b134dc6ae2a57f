#include "assur/strategy.hpp"

#include "fuzz/targets.hpp"

namespace assur::fuzz {

bool strategy(std::string_view bytes) {
  return accepts([&] {
    const Strategy strategy = parse_strategy(bytes);
    require(parse_strategy(to_string(strategy)) == strategy,
            "the text of a strategy must be read back as the same strategy");
  });
}

}  // namespace assur::fuzz
