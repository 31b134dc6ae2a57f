// Output of `assur check`: cases by family, and unexpected results with the command that repeats them.
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
  // Backends that failed to start in some case, each with the reason.
  [[nodiscard]] std::vector<std::string> left_out() const;
};

[[nodiscard]] Json to_json(const CheckSummary& summary);

void print(Page& page, const CheckSummary& summary);

// Each failed case with its strategies, its scene and how to repeat it.
void print_failures(Page& page, const CheckSummary& summary);

// "assur run 'four_bar:3' --set 'omega=2' --strategy 'groups/klu' --reference". For a scene of the suite, with the name
// of a file to save it as; "" if no file can hold the scene.
[[nodiscard]] std::string how_to_repeat(const check::Case& c, const std::string& strategy);

}  // namespace assur::output
