// What `assur check` says: cases by family, and what was unexpected, with the command that repeats it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "check/result.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

struct CheckSummary {
  std::vector<check::Result> results;
  double seconds = 0;
  bool interrupted = false;

  [[nodiscard]] std::int64_t passed() const;
  [[nodiscard]] std::int64_t failed() const { return static_cast<std::int64_t>(results.size()) - passed(); }
  [[nodiscard]] std::int64_t runs() const;
};

[[nodiscard]] Json to_json(const CheckSummary& summary);

void print(Page& page, const CheckSummary& summary);

// Each failed case with its strategies, its scene and how to repeat it.
void print_failures(Page& page, const CheckSummary& summary);

// "assur run 'four_bar:3' --set 'omega=2' --strategy 'groups/klu' --reference"; for a scene of the suite's own the file
// that it is to be saved as; "" for what no file can say.
[[nodiscard]] std::string how_to_repeat(const check::Case& c, const std::string& strategy);

}  // namespace assur::output
