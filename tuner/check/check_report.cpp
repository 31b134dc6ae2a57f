#include "check/check_report.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "output/format.hpp"

namespace assur::output {
namespace {

using check::Case;
using check::Result;
using check::Run;

constexpr std::size_t kMostStrategies = 5;  // listed for a failed case

Json or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

std::string or_dash(const std::optional<double>& value) { return value ? error_figure(*value) : "-"; }

std::string exact(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string file_of(const Case& c) {
  std::string name;
  for (const char letter : c.name) name += letter == ' ' || letter == '=' ? '_' : letter;
  return name + ".json";
}

// A row of the table: the results of a family of cases.
struct Family {
  std::int64_t cases = 0, failed = 0, runs = 0;
  std::optional<double> forward_error;  // largest of the runs that end as "pass"
};

std::vector<std::pair<std::string, Family>> by_family(const CheckSummary& s) {
  std::vector<std::pair<std::string, Family>> families;
  for (const Result& r : s.results) {
    auto at = std::find_if(families.begin(), families.end(), [&](const auto& f) { return f.first == r.what.family; });
    if (at == families.end()) at = families.insert(families.end(), {r.what.family, {}});
    Family& f = at->second;
    ++f.cases;
    f.failed += r.passed() ? 0 : 1;
    f.runs += r.runs;
    if (r.verdict == "pass" && r.forward_error && !(f.forward_error && *f.forward_error >= *r.forward_error)) {
      f.forward_error = r.forward_error;
    }
  }
  return families;
}

void print_failure(Page& page, const Result& r) {
  page.gap();
  page.title(r.what.family + ": " + r.what.name);
  page.fact("about", r.what.about);
  page.fact("expected", to_string(r.what.expected) +
                            (r.what.expected.message.empty() ? "" : " with \"" + r.what.expected.message + "\""));
  page.fact("unexpected", grouped(static_cast<std::int64_t>(r.unexpected.size())) + " of " + counted(r.runs, "run"));
  for (std::size_t i = 0; i < std::min(r.unexpected.size(), kMostStrategies); ++i) {
    const Run& run = r.unexpected[i];
    page.fact(run.strategy, run.verdict + (run.message.empty() ? "" : ": " + run.message) + "; forward error " +
                                or_dash(run.forward_error) + ", backward error " + or_dash(run.backward_error));
  }
  if (r.unexpected.size() > kMostStrategies) {
    page.fact("", "and " + grouped(static_cast<std::int64_t>(r.unexpected.size() - kMostStrategies)) + " more");
  }
  page.fact("condition", or_dash(r.condition) + ", bound of the forward error " + or_dash(r.bound));
  page.list("notes", r.notes);
  page.list("left out", {r.left_out.begin(), r.left_out.end()});
  if (!r.what.scene.empty()) page.fact(file_of(r.what), r.what.scene);
  if (const std::string how = r.unexpected.empty() ? "" : how_to_repeat(r.what, r.unexpected[0].strategy);
      !how.empty()) {
    page.fact("repeat", how);
  }
}

}  // namespace

std::int64_t CheckSummary::passed() const {
  return std::count_if(results.begin(), results.end(), [](const Result& r) { return r.passed(); });
}

std::vector<std::string> CheckSummary::left_out() const {
  std::set<std::string> all;
  for (const Result& r : results) all.insert(r.left_out.begin(), r.left_out.end());
  return {all.begin(), all.end()};
}

std::int64_t CheckSummary::runs() const {
  std::int64_t sum = 0;
  for (const Result& r : results) sum += r.runs;
  return sum;
}

std::string how_to_repeat(const Case& c, const std::string& strategy) {
  if (c.text.empty() && c.scene.empty()) return "assur check --case '" + c.name + "'";
  std::string line = "assur run '" + (c.text.empty() ? file_of(c) : c.text) + "'";
  for (const auto& [name, value] : c.set) line += " --set " + name + "=" + exact(value);
  for (const auto& folder : c.tables) line += " --tables " + folder.string();
  if (c.time) {
    line += " --start " + exact(c.time->start) + " --dt " + exact(c.time->step) + " --steps " +
            std::to_string(c.time->steps());
  }
  for (std::size_t i = 0; i < c.outputs.size(); ++i) line += (i == 0 ? " --outputs " : ",") + c.outputs[i];
  if (c.iterations > 0) line += " --iterations " + std::to_string(c.iterations);
  if (strategy.find('/') != std::string::npos) line += " --strategy '" + strategy + "'";
  if (c.accuracy > 0) line += " --accuracy " + exact(c.accuracy);
  return line + " --reference";
}

Json to_json(const CheckSummary& s) {
  Json cases = Json::array();
  for (const Result& r : s.results) {
    cases.push_back({{"name", r.what.name},
                     {"expected", to_string(r.what.expected)},
                     {"verdict", r.verdict},
                     {"forward_error", or_null(r.forward_error)},
                     {"backward_error", or_null(r.backward_error)},
                     {"condition", or_null(r.condition)},
                     {"bound", or_null(r.bound)}});
  }
  return {{"cases", std::move(cases)}, {"passed", s.passed()}, {"failed", s.failed()}, {"left_out", s.left_out()}};
}

void print(Page& page, const CheckSummary& s) {
  using enum Table::Align;
  Table table({left, right, right, right, right});
  table.row({"family", "cases", "unexpected", "runs", "worst error"});
  for (const auto& [name, f] : by_family(s)) {
    table.row({name, grouped(f.cases), grouped(f.failed), grouped(f.runs), or_dash(f.forward_error)});
  }
  page.table(table);
  page.gap();
  page.fact("worst error", "largest true forward error of runs with a clean status");
  page.fact("in all", counted(static_cast<std::int64_t>(s.results.size()), "case") + ", " + counted(s.runs(), "run") +
                          " in " + duration(s.seconds) + (s.interrupted ? "; interrupted" : ""));
  page.fact("unexpected", s.failed() == 0 ? "nothing" : counted(s.failed(), "case"));
  page.list("left out", s.left_out());
}

void print_failures(Page& page, const CheckSummary& s) {
  for (const Result& r : s.results) {
    if (!r.passed()) print_failure(page, r);
  }
}

}  // namespace assur::output
