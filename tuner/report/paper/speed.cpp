// Tables 2 and 3, figures 2 and 3: which version is how much faster.
#include <array>
#include <cmath>

#include "output/format.hpp"
#include "pictures/html.hpp"
#include "pictures/plot.hpp"
#include "report/paper/conclusions.hpp"
#include "report/paper/figures.hpp"
#include "report/paper/parts.hpp"

namespace assur::report {
namespace {

using pictures::HtmlTable;
using Times = std::span<const PaperTiming>;

constexpr std::string_view kBase = "GMA27";
constexpr std::array<std::string_view, 3> kVersions = {"GMKL", kDense, kSparse};  // of table 2, beside its base

double best(Times times, const PaperCell& cell, std::string_view version, Reading reading = Reading::shared) {
  return seconds_of(fastest(times, cell, version, reading));
}

// The name of the least of these times, as far as there are any.
std::string winner(const std::vector<std::pair<std::string, double>>& times) {
  std::string name = "-";
  double least = HUGE_VAL;
  for (const auto& [version, seconds] : times) {
    if (seconds < least) {
      least = seconds;
      name = version;
    }
  }
  return name;
}

std::string size_text(double size) { return output::grouped(std::llround(size)); }

pictures::Series series(std::string name, int colour, bool theirs) {
  pictures::Series s;
  s.name = std::move(name);
  s.colour = colour;
  s.mark = theirs ? pictures::Series::Mark::cross : pictures::Series::Mark::dot;
  s.line = pictures::Series::Line::straight;
  return s;
}

void add(pictures::Series& s, const PaperCell& cell, double ratio) {
  if (std::isnan(ratio)) return;
  const auto size = static_cast<double>(cell.total());
  s.points.push_back({size, ratio, s.name + ", total size " + size_text(size) + ": " + ratio_text(ratio), ""});
}

std::string figure_of(const std::string& title, const std::string& y, std::vector<pictures::Series> all) {
  std::erase_if(all, [](const pictures::Series& s) { return s.points.empty(); });
  pictures::Plot plot;
  plot.title = title;
  plot.x = {"total size", true, size_text};
  plot.y = {y, true, [](double v) { return output::number(v); }};
  plot.series = std::move(all);
  return pictures::figure(plot);
}

HtmlTable versions(const StandIns& by) {
  using enum HtmlTable::Column;
  const std::string threaded = by.threaded.empty() ? "" : ", groups/" + by.threaded + " PxQ";
  HtmlTable table{{"their version", "run here by"}, {words, words}, {}};
  table.rows = {
      {{"GMKL", "global/" + by.dense + " 1xQ" + (by.threaded.empty() ? "" : ", global/" + by.threaded + " 1xQ")}},
      {{"GMA27", "global/" + by.sparse + (by.ma27 ? " (and global/ma27, listed apart)" : "")}},
      {{"GEOMP+MKL; GEMKL where P = 1", "groups/" + by.dense + " Px1 and 1xQ" + threaded}},
      {{"GEOMP+MA27", "groups/" + by.sparse + " Px1" + (by.ma27 ? " (and groups/ma27, listed apart)" : "")}}};
  return table;
}

std::string how_it_was_run(const PaperResults& r) {
  return paragraph(
             "The paper's versions are run by the solvers of this library: " + r.stand_ins.dense + " stands for MKL, " +
             r.stand_ins.sparse +
             " for MA27. P groups are solved at once, each with Q "
             "threads; of several strategies and splits the fastest counts. All strategies of a size are measured "
             "in turns, each after its motion was found to be right. There " +
             (r.threads == 1 ? "is " : "are ") + output::counted(r.threads, "thread") +
             " here, and splits go no further; the paper's machine has 4.") +
         html(versions(r.stand_ins));
}

HtmlTable ratios_of_table_2(const PaperResults& r) {
  using enum HtmlTable::Column;
  HtmlTable table{{"total size", "n"}, {number, number}, {}};
  for (const std::string_view version : kVersions) {
    for (const char* whose : {", theirs", ", here", ", separate"}) {
      table.titles.push_back(std::string(version) + whose);
      table.columns.push_back(number);
    }
  }
  for (const char* title : {"auto, here", "fastest, theirs", "fastest, here"}) {
    table.titles.emplace_back(title);
    table.columns.push_back(title[0] == 'a' ? number : text);
  }
  for (const PaperCell& cell : cells_of_table(2)) {
    HtmlTable::Row row{{std::to_string(cell.total()), std::to_string(cell.n)}};
    std::vector<std::pair<std::string, double>> theirs, here;
    const auto note = [&](std::string_view version) {
      theirs.emplace_back(version, best(paper_times(2), cell, version));
      here.emplace_back(version, best(r.times, cell, version));
    };
    note(kBase);
    for (const std::string_view version : kVersions) {
      const auto ratio = [&](Times times, Reading reading) {
        return ratio_or_dash(best(times, cell, kBase, reading) / best(times, cell, version, reading));
      };
      row.cells.push_back(ratio(paper_times(2), Reading::shared));
      row.cells.push_back(ratio(r.times, Reading::shared));
      row.cells.push_back(ratio(r.times, Reading::separate));
      note(version);
    }
    row.cells.push_back(ratio_or_dash(best(r.times, cell, kBase) / best(r.times, cell, kAuto)));
    row.cells.push_back(winner(theirs));
    row.cells.push_back(winner(here));
    table.rows.push_back(std::move(row));
  }
  return table;
}

HtmlTable times_of_table_2(const PaperResults& r) {
  using enum HtmlTable::Column;
  HtmlTable table{{"total size", "n"}, {number, number}, {}};
  for (const std::string_view version : {std::string_view("GMKL"), kBase, kDense, kSparse}) {
    table.titles.push_back(std::string(version) + ", theirs");
    table.titles.push_back(std::string(version) + ", here");
    table.columns.insert(table.columns.end(), 2, number);
  }
  for (const char* ours : {"auto", "groups/lanes:8", "irreducible/lanes:8"}) {
    table.titles.emplace_back(ours);
    table.columns.push_back(number);
  }
  for (const PaperCell& cell : cells_of_table(2)) {
    HtmlTable::Row row{{std::to_string(cell.total()), std::to_string(cell.n)}};
    for (const std::string_view version : {std::string_view("GMKL"), kBase, kDense, kSparse}) {
      row.cells.push_back(run_text(fastest(paper_times(2), cell, version), cell.steps));
      row.cells.push_back(run_text(fastest(r.times, cell, version), cell.steps));
    }
    for (const char* ours : {"auto", "groups/lanes:8", "irreducible/lanes:8"}) {
      row.cells.push_back(run_text(fastest(r.times, cell, ours), cell.steps));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

void add_theirs(Section& section, int table, std::string_view machine) {
  for (const PaperTiming& t : paper_times(table)) {
    section.measurements.push_back(of_the_paper(section.id, table, t, machine));
  }
}

}  // namespace

Section paper_table_2(const PaperResults& r) {
  Section s{"paper-table-2", "Table 2: global formulation and group equations, six groups", "", {}};
  s.body += how_it_was_run(r);
  s.body += paragraph(
      "Speed-up over GMA27 by the fastest split of each version. Theirs: Core i5-2400, 4 cores. In the columns "
      "\"separate\" velocity and acceleration have a factorisation each, else one for both, besides that of each "
      "Newton "
      "iteration: the paper does not say which. Position by one iteration (tEnd2 = 1); the global system is iterated "
      "until it converges, which takes one as well.");
  s.body += tall(ratios_of_table_2(r));
  s.body += faint(
      "Absolute times, s for the paper's 20,000 steps, and the threads that were fastest. Here some of the "
      "steps are timed and scaled: cells that would take hours are run for two steps only.");
  s.body += small(times_of_table_2(r));
  s.body += faint(missing(r, cells_of_table(2)));
  add_theirs(s, 2, "i5");
  add_details(s, r, cells_of_table(2));
  return s;
}

Section paper_figure_2(const PaperResults& r) {
  Section s{"paper-figure-2", "Figure 2: speed-up over the global formulation with MA27", "", {}};
  const auto line = [&s](Times times, std::string_view version, int colour, bool theirs) {
    pictures::Series out = series(std::string(version) + (theirs ? ", theirs (i5)" : ", here"), colour, theirs);
    for (const PaperCell& cell : cells_of_table(2)) {
      const double ratio = best(times, cell, kBase) / best(times, cell, version);
      if (std::isnan(ratio)) continue;
      add(out, cell, ratio);
      const PaperTiming& t = *fastest(times, cell, version);
      s.measurements.push_back({s.id, "total size " + std::to_string(cell.total()),
                                theirs ? t.version + " " + split_text(t) : t.strategy, "speed-up over GMA27", "1",
                                ratio, 0, 0, t.deviation,
                                theirs ? "from the paper's table 2, Core i5-2400" : "from table 2, here"});
    }
    return out;
  };
  s.body = figure_of(
      "Speed-up over GMA27 against total size", "speed-up over GMA27",
      {line(paper_times(2), kDense, 0, true), line(r.times, kDense, 0, false), line(paper_times(2), kSparse, 1, true),
       line(r.times, kSparse, 1, false), line(r.times, kAuto, pictures::Series::kInk, false)});
  s.body += faint("From table 2: time of GMA27 over the time of the version, the fastest split of each.");
  return s;
}

Section paper_table_3(const PaperResults& r) {
  using enum HtmlTable::Column;
  const int p = std::min(r.threads, 4);
  Section s{"paper-table-3", "Table 3: number and size of groups", "", {}};
  s.body += paragraph(
      "Speed-up over MKL by one thread, groups one after the other. Theirs: four OpenMP threads of a Core "
      "i5-2400; here: " +
      output::counted(p, "thread") + ".");
  HtmlTable table{{"nSG", "n", "MA27, theirs", "MA27, here", "GEOMP+MKL, theirs", "GEOMP+MKL, here",
                   "GEOMP+MA27, theirs", "GEOMP+MA27, here", "auto, here", "fastest, theirs", "fastest, here"},
                  {number, number, number, number, number, number, number, number, number, text, text},
                  {}};
  HtmlTable times{{"nSG", "n", "MKL, theirs", "MKL, here", "MA27, theirs", "MA27, here", "GEOMP+MKL, theirs",
                   "GEOMP+MKL, here", "GEOMP+MA27, theirs", "GEOMP+MA27, here", "auto"},
                  {number, number, number, number, number, number, number, number, number, number, number},
                  {}};
  struct Column {
    const char* name;
    std::string_view version;
    bool parallel;
  };
  constexpr std::array kColumns = {Column{"MKL", kDense, false}, Column{"MA27", kSparse, false},
                                   Column{"GEOMP+MKL", kDense, true}, Column{"GEOMP+MA27", kSparse, true}};
  for (const PaperCell& cell : cells_of_table(3)) {
    HtmlTable::Row ratios{{std::to_string(cell.groups), std::to_string(cell.n)}}, seconds{ratios};
    std::vector<std::pair<std::string, double>> all_theirs, all_here;
    const double base_theirs = seconds_of(timing(paper_times(3), cell, kDense, 1, 1));
    const double base_here = seconds_of(timing(r.times, cell, kDense, 1, 1));
    for (const Column& c : kColumns) {
      const PaperTiming* const theirs = timing(paper_times(3), cell, c.version, c.parallel ? 4 : 1, 1);
      const PaperTiming* const here = timing(r.times, cell, c.version, c.parallel ? p : 1, 1);
      seconds.cells.push_back(run_text(theirs, cell.steps));
      seconds.cells.push_back(run_text(here, cell.steps));
      all_theirs.emplace_back(c.name, seconds_of(theirs));
      all_here.emplace_back(c.name, seconds_of(here));
      if (&c == kColumns.data()) continue;  // the base
      ratios.cells.push_back(ratio_or_dash(base_theirs / seconds_of(theirs)));
      ratios.cells.push_back(ratio_or_dash(base_here / seconds_of(here)));
    }
    ratios.cells.push_back(ratio_or_dash(base_here / best(r.times, cell, kAuto)));
    ratios.cells.push_back(winner(all_theirs));
    ratios.cells.push_back(winner(all_here));
    seconds.cells.push_back(run_text(fastest(r.times, cell, kAuto), cell.steps));
    table.rows.push_back(std::move(ratios));
    times.rows.push_back(std::move(seconds));
  }
  s.body += tall(table);
  s.body += faint("Absolute times, s for 20,000 steps.");
  s.body += small(times);
  s.body += faint(missing(r, cells_of_table(3)));
  add_theirs(s, 3, "i5");
  std::vector<PaperCell> own;  // those with six groups are in table 2
  for (const PaperCell& cell : cells_of_table(3)) {
    if (cell.groups != 6) own.push_back(cell);
  }
  add_details(s, r, own);
  return s;
}

Section paper_figure_3(const PaperResults& r) {
  Section s{"paper-figure-3", "Figure 3: OpenMP x MKL threads", "", {}};
  if (r.threads < 2) {
    s.body = paragraph("One thread here: there is no split to compare.");
    return s;
  }
  std::vector<pictures::Series> all;
  for (const Split& split : splits(r.threads, 6)) {
    if (split.p * split.q == 1) continue;
    const std::string name = std::to_string(split.p) + "x" + std::to_string(split.q);
    pictures::Series line = series(name, static_cast<int>(all.size()) % pictures::Series::kColours, false);
    for (const PaperCell& cell : cells_of_table(2)) {
      const PaperTiming* const t = timing(r.times, cell, kDense, split.p, split.q);
      const double ratio = seconds_of(timing(r.times, cell, kDense, 1, 1)) / seconds_of(t);
      add(line, cell, ratio);
      if (std::isnan(ratio)) continue;
      s.measurements.push_back({s.id, "total size " + std::to_string(cell.total()), t->strategy, "speed-up over 1x1",
                                "1", ratio, t->rounds, t->spread / t->seconds, t->deviation, "from table 2, here"});
    }
    all.push_back(std::move(line));
  }
  s.body = figure_of("Speed-up of GEOMP+MKL over one thread against total size", "speed-up over 1x1", std::move(all));
  s.body += faint(
      "Sizes ours (those of table 2), base 1x1: neither is in the paper's text. Its figure shows two Xeon "
      "E5-2620 with 12 cores; there OpenMP alone wins for small sizes, OpenMP and MKL together for large "
      "ones. Here there are " +
      output::counted(r.threads, "thread") + ".");
  return s;
}

}  // namespace assur::report
