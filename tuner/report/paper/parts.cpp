#include "report/paper/parts.hpp"

#include <algorithm>
#include <cmath>

#include "output/format.hpp"
#include "pictures/html.hpp"
#include "report/paper/conclusions.hpp"
#include "report/paper/figures.hpp"

namespace assur::report {
namespace {

bool is_of(const PaperTiming& t, const std::vector<PaperCell>& cells) {
  return std::any_of(cells.begin(), cells.end(), [&](const PaperCell& c) { return c.same_work(t.cell); });
}

bool is_of_the_paper(const PaperTiming& t) { return t.version.starts_with("G"); }

std::string item(const PaperCell& cell) {
  return "total size " + std::to_string(cell.total()) + ": " + std::to_string(cell.groups) + " groups of " +
         std::to_string(cell.n) + ", terminal " + std::to_string(cell.terminal);
}

std::string reading_text(Reading reading) { return reading == Reading::shared ? "shared" : "separate"; }

std::string stands_for(const PaperTiming& t) {
  if (!is_of_the_paper(t)) return "";
  return t.version + " " + split_text(t) + ", " + reading_text(t.reading);
}

pictures::HtmlTable details_table(const std::vector<const PaperTiming*>& rows) {
  using enum pictures::HtmlTable::Column;
  pictures::HtmlTable table{{"total size", "groups x n", "stands for", "strategy", "step", "spread", "rounds",
                             "steps timed", "iterations", "deviation", ""},
                            {number, number, text, text, number, number, number, number, number, number, words},
                            {}};
  for (const PaperTiming* t : rows) {
    const bool timed = t->timed();
    table.rows.push_back(
        {{std::to_string(t->cell.total()), std::to_string(t->cell.groups) + " x " + std::to_string(t->cell.n),
          stands_for(*t), t->strategy, timed ? output::duration(t->seconds) : "-",
          t->rounds > 1 ? output::duration(t->spread) : "-", std::to_string(t->rounds), output::grouped(t->steps_timed),
          t->newton > 0 ? output::fixed(t->newton) : "-",
          std::isnan(t->deviation) ? "-" : output::error_figure(t->deviation), t->why_not}});
  }
  return table;
}

}  // namespace

std::string faint(std::string_view text) { return "<p class=\"faint\">" + pictures::escaped(text) + "</p>\n"; }
std::string tall(const pictures::HtmlTable& table) { return "<div class=\"tall\">\n" + html(table) + "</div>\n"; }
std::string small(const pictures::HtmlTable& table) {
  return "<div class=\"small tall\">\n" + html(table) + "</div>\n";
}

std::string ratio_or_dash(double ratio) { return std::isnan(ratio) ? "-" : ratio_text(ratio); }

double seconds_of(const PaperTiming* timing) { return timing == nullptr ? std::nan("") : timing->seconds; }

std::string run_text(const PaperTiming* timing, int steps) {
  if (timing == nullptr) return "-";
  std::string text = ratio_text(timing->seconds * steps);
  if (timing->p * timing->q > 1) text += " (" + split_text(*timing) + ")";
  return text;
}

Measurement measured(const std::string& section, const PaperTiming& t) {
  const std::string role = stands_for(t);
  return {
      .section = section,
      .item = item(t.cell) + (t.cell.iterations > 1 ? ", " + std::to_string(t.cell.iterations) + " iterations" : ""),
      .strategy = t.strategy,
      .quantity = "seconds per step",
      .unit = "s",
      .value = t.seconds,
      .repetitions = t.rounds,
      .spread = t.spread / t.seconds,
      .error = t.deviation,
      .origin = role.empty() ? "measured" : "measured, stands for " + role};
}

Measurement of_the_paper(const std::string& section, int table, const PaperTiming& t, std::string_view machine) {
  return {
      .section = section,
      .item = item(t.cell) + (t.cell.iterations > 1 ? ", " + std::to_string(t.cell.iterations) + " iterations" : ""),
      .strategy = t.version + " " + split_text(t),
      .quantity = "seconds per step",
      .unit = "s",
      .value = t.seconds,
      .repetitions = 0,
      .spread = 0,
      .error = std::nan(""),
      .origin = "paper, table " + std::to_string(table) + ", " + std::string(paper_machine(machine).name)};
}

void add_details(Section& section, const PaperResults& results, const std::vector<PaperCell>& cells) {
  std::vector<const PaperTiming*> rows;
  for (const PaperTiming& t : results.times) {
    if (!is_of(t, cells)) continue;
    rows.push_back(&t);
    if (t.timed()) section.measurements.push_back(measured(section.id, t));
  }
  if (rows.empty()) return;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto* a, const auto* b) { return a->cell.total() < b->cell.total(); });
  section.body +=
      "<details><summary>All that was tried here: " + output::counted(static_cast<std::int64_t>(rows.size()), "run") +
      "</summary>\n" + small(details_table(rows)) + "</details>\n";
}

std::string missing(const PaperResults& results, const std::vector<PaperCell>& cells) {
  std::vector<std::string> sizes, parts;
  for (const PaperCell& cell : cells) {
    int timed = 0, left_out = 0;
    for (const PaperTiming& t : results.times) {
      if (!t.cell.same_work(cell) || !is_of_the_paper(t)) continue;
      ++(t.timed() ? timed : left_out);
    }
    const std::string size = std::to_string(cell.groups) + " x " + std::to_string(cell.n);
    if (timed == 0) {
      sizes.push_back(size);
    } else if (left_out > 0) {
      parts.push_back(size);
    }
  }
  std::string text;
  if (!sizes.empty()) {
    const std::string why = results.interrupted ? "interrupted" : results.quick ? "not run in quick" : "no time for it";
    text = "Without times here (" + why + "): " + output::listed(sizes) + ". ";
  }
  if (!parts.empty()) {
    text += "Some strategies are left out (the list below says why) at " + output::listed(parts) + ".";
  }
  return text;
}

}  // namespace assur::report
