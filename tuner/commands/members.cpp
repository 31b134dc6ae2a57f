#include "commands/members.hpp"

#include "output/format.hpp"
#include "status_text.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kMostParameters = 4;  // number of parameters shown for one member

Members::Failure failure_of(const Ensemble::Outcome& outcome) {
  Members::Failure failure;
  if (!outcome.cannot.empty()) {
    failure.why = outcome.cannot;
    return failure;
  }
  failure.status = outcome.status.code;
  failure.reached = outcome.reached;
  failure.why = why_stopped(outcome.status, outcome.events, outcome.reached);
  return failure;
}

}  // namespace

Code Members::code() const {
  if (interrupted > 0) return Code::interrupted;
  for (const Failure& f : failed) {
    const Code of = f.status.value_or(Code::not_assembled);
    if (of != Code::inaccurate) return of;
  }
  return failed.empty() ? Code::ok : Code::inaccurate;
}

std::string Members::failures() const {
  const std::string of_all = " of " + counted(all, "member") + ' ';
  if (stopped() == 0) return grouped(inaccurate) + of_all + "inaccurate";
  return grouped(stopped()) + of_all + "failed" + (inaccurate > 0 ? ", " + grouped(inaccurate) + " inaccurate" : "");
}

Members members_of(const std::vector<Ensemble::Outcome>& outcomes, const std::vector<Parameters>& variants) {
  Members members;
  members.all = static_cast<std::int64_t>(outcomes.size());
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const Ensemble::Outcome& outcome = outcomes[i];
    const auto member = static_cast<std::int64_t>(i) + 1;
    for (const assur::Event& event : outcome.events) {
      members.events.push_back({member, event, event.kind == outcome.status.code});
    }
    members.alone += outcome.alone && outcome.cannot.empty() ? 1 : 0;
    if (outcome.cannot.empty() && outcome.status.ok()) {
      ++members.done;
    } else if (outcome.cannot.empty() && outcome.status.code == Code::interrupted) {
      ++members.interrupted;
    } else {
      members.failed.push_back(failure_of(outcome));
      if (members.failed.back().status == Code::inaccurate) ++members.inaccurate;
      members.failed.back().member = member;
      members.failed.back().parameters = variants[i];
    }
  }
  return members;
}

std::string to_string(const Members::Failure& failure) {
  std::vector<std::string> values;
  for (const auto& [name, value] : failure.parameters) values.push_back(name + " = " + number(value));
  return "member " + grouped(failure.member) + " (" + listed(values, kMostParameters) + "): " + one_line(failure.why);
}

Json to_json(const std::vector<Members::Failure>& failed) {
  Json list = Json::array();
  for (const Members::Failure& f : failed) {
    list.push_back({{"member", f.member},
                    {"parameters", f.parameters},
                    {"status", f.status ? Json(name(*f.status)) : Json(nullptr)},
                    {"reached", or_null(f.status.has_value(), f.reached)},
                    {"why", f.why}});
  }
  return list;
}

void print_counts(Page& page, const Members& m) {
  std::string text = grouped(m.done) + " done";
  if (m.stopped() > 0) text += ", " + grouped(m.stopped()) + " failed";
  if (m.inaccurate > 0) text += ", " + grouped(m.inaccurate) + " inaccurate";
  if (m.interrupted > 0) text += ", " + grouped(m.interrupted) + " interrupted";
  if (m.alone > 0) text += "; " + grouped(m.alone) + " continued alone";
  page.fact("members", text);
}

void print_outcomes(Page& page, const Members& m) {
  std::vector<std::string> failed, events;
  for (const Members::Failure& f : m.failed) failed.push_back(to_string(f));
  for (const auto& [member, e, is_told] : m.events) {
    if (is_told) continue;
    events.push_back("member " + grouped(member) + ", " + time_of(e) + place_of(e) + ": " + explained(e.kind));
  }
  page.list("failed", failed);
  page.list("events", events);
}

}  // namespace assur::output
