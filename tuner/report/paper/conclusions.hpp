// What the paper concludes, and whether it is so here: decided by the times that were measured, each by the same rule
// as the paper's own times.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "report/paper/paper.hpp"

namespace assur::report {

enum class Verdict : std::uint8_t { holds, does_not_hold, cannot_be_tested };

[[nodiscard]] std::string_view verdict_text(Verdict verdict) noexcept;  // "holds here", ...

struct Conclusion {
  std::string where;  // in the paper: "5.1"
  std::string claim;
  std::string theirs;  // in numbers
  std::string here;    // in numbers, or why there are none
  Verdict verdict = Verdict::cannot_be_tested;
};

// times: of this machine; threads: that they could use. In the order of the paper.
[[nodiscard]] std::vector<Conclusion> conclusions(Times times, int threads);

// The same rules asked of the paper's own tables.
[[nodiscard]] std::vector<Conclusion> conclusions_of_the_paper();

}  // namespace assur::report
