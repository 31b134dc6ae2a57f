// Results of the members of an ensemble.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "assur/ensemble.hpp"
#include "assur/scene.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

struct Members {
  struct Failure {
    std::int64_t member = 0;  // counted from 1, as in the CSV
    Parameters parameters;
    std::optional<Code> status;  // empty: it could not start
    double reached = 0;          // s, if it started
    std::string why;
  };
  struct Event {
    std::int64_t member = 0;
    assur::Event event;
    bool is_told = false;  // true: the failure of that member reports it already
  };

  std::int64_t all = 0, done = 0;
  std::int64_t interrupted = 0;
  std::int64_t alone = 0;       // members that left the lockstep with others
  std::int64_t inaccurate = 0;  // members among the failed ones that arrived, but missed the required accuracy
  std::vector<Failure> failed;
  std::vector<Event> events;

  // Status of all members: ok, interrupted, or that of the first failed member; inaccurate if no member failed
  // otherwise.
  [[nodiscard]] Code code() const;
  [[nodiscard]] std::int64_t stopped() const { return static_cast<std::int64_t>(failed.size()) - inaccurate; }
  // "3 of 8 members failed, 2 inaccurate"
  [[nodiscard]] std::string failures() const;
};

// `variants`: the parameters of each member.
[[nodiscard]] Members members_of(const std::vector<Ensemble::Outcome>& outcomes,
                                 const std::vector<Parameters>& variants);

// "member 3 (crank = 0.4): t = 1.3 s, group C: the mechanism cannot move further (fold)"
[[nodiscard]] std::string to_string(const Members::Failure& failure);

// [{"member", "parameters", "status", "reached", "why"}]; status and reached are null if it could not start.
[[nodiscard]] Json to_json(const std::vector<Members::Failure>& failed);

void print_counts(Page& page, const Members& members);

// Failures and events of members, one by one.
void print_outcomes(Page& page, const Members& members);

}  // namespace assur::output
