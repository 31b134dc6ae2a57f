// The conclusions of the paper, and whether they hold on this machine. The same rules decide for measured times and for
// the times of the paper.
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
  std::string where;  // section of the paper: "5.1"
  std::string claim;
  std::string theirs;  // figures of the paper
  std::string here;    // figures of this machine, or the reason why there are none
  Verdict verdict = Verdict::cannot_be_tested;
};

// The conclusions for times of this machine, in the order of the paper. threads: budget of these times.
[[nodiscard]] std::vector<Conclusion> conclusions(Times times, int threads);

// The conclusions for the times of the paper, by the same rules.
[[nodiscard]] std::vector<Conclusion> conclusions_of_the_paper();

}  // namespace assur::report
