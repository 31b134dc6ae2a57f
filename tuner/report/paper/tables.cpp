#include "report/paper/tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "backends/backends.hpp"
#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "report/paper/conclusions.hpp"

namespace assur::report {
namespace {

using enum HtmlTable::Column;
using pictures::Series;

std::string faint(const std::string& text) { return paragraph(text, "faint"); }
// A table with wrapped titles; small() in small type, for numbers that are valid only on one machine.
std::string tall(const HtmlTable& table) { return html(table, "tall"); }
std::string small(const HtmlTable& table) { return html(table, "small tall"); }

// ---- columns: a row for each cell of a table

using Column = pictures::ColumnOf<PaperCell>;
using TimeOf = std::function<double(const PaperCell&)>;  // time of one step, s; NaN if unknown

HtmlTable table_of_cells(int table, const std::vector<Column>& columns) {
  return pictures::table_of(cells_of_table(table), columns);
}

Column count(const std::string& title, int (*of)(const PaperCell&)) {
  return {title, number, [of](const PaperCell& cell) { return std::to_string(of(cell)); }};
}
Column total_size() {
  return count("total size", [](const PaperCell& c) { return c.total(); });
}
Column groups() {
  return count("nSG", [](const PaperCell& c) { return c.groups; });
}
Column terminal() {
  return count("T", [](const PaperCell& c) { return c.terminal; });
}
Column unknowns() {
  return count("n", [](const PaperCell& c) { return c.n; });
}

TimeOf time_of(Times times, std::string_view version, const Splits& splits = {}, Reading reading = Reading::shared) {
  return [=](const PaperCell& cell) { return best(times, cell, version, splits, reading); };
}
// The time in the first row of a table.
TimeOf at_first(int table, const TimeOf& of) {
  return [of, cell = cells_of_table(table)[0]](const PaperCell&) { return of(cell); };
}

// "3.83", or "-" if unknown.
std::string ratio_or_dash(double ratio) { return std::isnan(ratio) ? "-" : ratio_text(ratio); }

Column ratio(const std::string& title, const TimeOf& a, const TimeOf& b) {
  return {title, number, [=](const PaperCell& cell) { return ratio_or_dash(a(cell) / b(cell)); }};
}

bool has_gpu(const PaperResults& r) { return !r.stand_ins.devices.empty(); }

// "GPU here: cusolver (CUDA 13.0, ...)", or that there is none.
std::string gpu_here(const PaperResults& r) {
  std::vector<std::string> names;
  for (const std::string& id : r.stand_ins.devices) names.push_back(id + " (" + properties_of(id).version() + ")");
  return has_gpu(r) ? "GPU here: " + output::listed(names) + "; each time is that of the fastest way to use it."
                    : "No GPU here.";
}

// Seconds of all steps, as in the paper.
Column seconds(const std::string& title, const TimeOf& of) {
  return {title, number, [=](const PaperCell& cell) { return ratio_or_dash(of(cell) * cell.steps); }};
}
// The same for the fastest split, with its name: "0.53 (3x1)".
Column run(const std::string& title, Times times, std::string_view version, const Splits& splits = {}) {
  return {title, number, [=](const PaperCell& cell) -> std::string {
            const PaperTiming* const t = fastest(times, cell, version, splits);
            if (t == nullptr) return "-";
            return ratio_text(t->seconds * cell.steps) + (t->split == Split{} ? "" : " (" + text_of(t->split) + ")");
          }};
}

// The name of the fastest version; "-" if no time is known.
Column winner(const std::string& title, const std::vector<std::pair<std::string, TimeOf>>& times) {
  return {title, text, [=](const PaperCell& cell) {
            std::string name = "-";
            double least = kInfinity;
            for (const auto& [version, time] : times) {
              if (const double seconds = time(cell); seconds < least) {
                least = seconds;
                name = version;
              }
            }
            return name;
          }};
}

// ---- numbers with their origin

bool is_of_the_paper(const PaperTiming& t) { return t.version.starts_with("G"); }

std::string item(const PaperCell& cell) {
  return "total size " + std::to_string(cell.total()) + ": " + std::to_string(cell.groups) + " groups of " +
         std::to_string(cell.n) + ", terminal " + std::to_string(cell.terminal) +
         (cell.iterations > 1 ? ", " + std::to_string(cell.iterations) + " iterations" : "");
}

std::string stands_for(const PaperTiming& t) {
  if (!is_of_the_paper(t)) return "";
  return t.version + " " + text_of(t.split) + ", " + (t.reading == Reading::shared ? "shared" : "separate");
}

Measurement measured(const PaperTiming& t) {
  const std::string role = stands_for(t);
  return {item(t.cell),       t.strategy,
          "seconds per step", "s",
          t.seconds,          role.empty() ? "measured" : "measured, as " + role,
          t.rounds,           t.spread / t.seconds,
          t.deviation};
}

Measurement energy(Measurement of, const PaperCell& cell, double joules) {
  of.quantity = "energy of " + std::to_string(cell.steps) + " steps";
  of.unit = "J";
  of.value = joules;
  return of;
}

void add_theirs(Section& section, int table) {
  for (const PaperTiming& t : paper_times(table)) {
    const Measurement m{item(t.cell),
                        t.version + " " + text_of(t.split),
                        "seconds per step",
                        "s",
                        t.seconds,
                        "paper, table " + std::to_string(table) + ", " + std::string(paper_machine(t.machine).name)};
    section.measurements.push_back(m);
    if (!std::isnan(t.joules)) section.measurements.push_back(energy(m, t.cell, t.joules));
  }
}

HtmlTable details_table(const std::vector<const PaperTiming*>& rows) {
  using T = const PaperTiming*;
  return pictures::table_of<T>(
      rows,
      {{"total size", number, [](T t) { return std::to_string(t->cell.total()); }},
       {"groups x n", number, [](T t) { return std::to_string(t->cell.groups) + " x " + std::to_string(t->cell.n); }},
       {"version of the paper", text, [](T t) { return stands_for(*t); }},
       {"strategy", text, [](T t) { return t->strategy; }},
       {"step", number, [](T t) { return t->timed() ? output::duration(t->seconds) : "-"; }},
       {"spread", number, [](T t) { return t->rounds > 1 ? output::duration(t->spread) : "-"; }},
       {"rounds", number, [](T t) { return std::to_string(t->rounds); }},
       {"steps timed", number, [](T t) { return output::grouped(t->steps_timed); }},
       {"iterations", number, [](T t) { return t->newton > 0 ? output::fixed(t->newton) : "-"; }},
       {"deviation", number, [](T t) { return std::isnan(t->deviation) ? "-" : output::error_figure(t->deviation); }},
       {"", words, [](T t) { return t->why_not; }}});
}

// A sentence about cells without a time here; "" if there are none.
std::string missing(const PaperResults& results, const std::vector<PaperCell>& cells) {
  std::vector<std::string> sizes, parts;
  for (const PaperCell& cell : cells) {
    int timed = 0, left_out = 0;
    for (const PaperTiming& t : results.times) {
      if (t.cell.same_work(cell) && is_of_the_paper(t)) ++(t.timed() ? timed : left_out);
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
    const std::string why = results.interrupted ? "interrupted"
                            : results.quick     ? "not part of --quick"
                                                : "no time left";
    text = "Without times here (" + why + "): " + output::listed(sizes) + ". ";
  }
  if (!parts.empty()) {
    text += "Some strategies are left out (reasons in the list below) at " + output::listed(parts) + ".";
  }
  return text;
}

// Ends a table: sizes without times, the numbers, and all runs of these cells.
void finish(Section& section, const PaperResults& results, int table) {
  std::vector<PaperCell> cells = cells_of_table(table);
  section.body += faint(missing(results, cells));
  add_theirs(section, table);
  if (table == 3) std::erase_if(cells, [](const PaperCell& c) { return c.groups == 6; });  // table 2 has them
  std::vector<const PaperTiming*> rows;
  for (const PaperTiming& t : results.times) {
    if (std::none_of(cells.begin(), cells.end(), [&](const PaperCell& c) { return c.same_work(t.cell); })) continue;
    rows.push_back(&t);
    if (t.timed()) section.measurements.push_back(measured(t));
  }
  if (rows.empty()) return;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto* a, const auto* b) { return a->cell.total() < b->cell.total(); });
  section.body += "<details><summary>All runs on this machine: " + output::counted(rows.size(), "run") +
                  "</summary>\n" + small(details_table(rows)) + "</details>\n";
}

// ---- table 2

std::string how_it_was_run(const PaperResults& r) {
  const StandIns& by = r.stand_ins;
  const std::string threaded = by.threaded.empty() ? "" : ", groups/" + by.threaded + " PxQ";
  HtmlTable versions{{"version of the paper", "strategies here"}, {words, words}, {}};
  versions.rows = {
      {{"GMKL", "global/" + by.dense + " 1xQ" + (by.threaded.empty() ? "" : ", global/" + by.threaded + " 1xQ")}},
      {{"GMA27", "global/" + by.sparse + (by.ma27 ? " (and global/ma27, listed separately)" : "")}},
      {{"GEOMP+MKL; GEMKL where P = 1", "groups/" + by.dense + " Px1 and 1xQ" + threaded}},
      {{"GEOMP+MA27", "groups/" + by.sparse + " Px1" + (by.ma27 ? " (and groups/ma27, listed separately)" : "")}}};
  return paragraph(
             "Solvers of this library replace those of the paper: " + by.dense + " replaces MKL, and " + by.sparse +
             " MA27. P groups are solved at once, each with Q threads; the tables have the time of the fastest of all "
             "strategies and splits. The motion of each strategy is verified, and then all strategies of a size are "
             "timed in turn. " +
             "Splits use up to " + output::counted(r.threads, "thread") + " here; the machine of the paper has 4.") +
         html(versions);
}

Section table_2(const PaperResults& r) {
  const Times theirs = paper_times(2), here = r.times;
  std::vector<Column> ratios = {total_size(), unknowns()}, times = ratios;
  for (const std::string_view version : {kGlobalDense, kDense, kSparse}) {
    const auto over_base = [&](const std::string& whose, Times of, Reading reading) {
      ratios.push_back(ratio(std::string(version) + whose, time_of(of, kGlobalSparse, {}, reading),
                             time_of(of, version, {}, reading)));
    };
    over_base(", paper", theirs, Reading::shared);
    over_base(", here", here, Reading::shared);
    over_base(", separate", here, Reading::separate);
  }
  ratios.push_back(ratio("auto, here", time_of(here, kGlobalSparse), time_of(here, kAuto)));
  for (const auto& [title, of] : {std::pair("fastest, paper", theirs), {"fastest, here", here}}) {
    std::vector<std::pair<std::string, TimeOf>> all;
    for (const std::string_view v : {kGlobalSparse, kGlobalDense, kDense, kSparse}) all.emplace_back(v, time_of(of, v));
    ratios.push_back(winner(title, all));
  }
  for (const std::string_view version : {kGlobalDense, kGlobalSparse, kDense, kSparse}) {
    times.push_back(run(std::string(version) + ", paper", theirs, version));
    times.push_back(run(std::string(version) + ", here", here, version));
  }
  for (const std::string& own : ours()) times.push_back(run(own, here, own));

  Section s{"paper-table-2", "Table 2: global formulation and group equations, six groups"};
  s.body = how_it_was_run(r) +
           paragraph(
               "Speed-up over GMA27 by the fastest split of each version. Paper: Core i5-2400, 4 cores. In the columns "
               "\"separate\", velocity and acceleration have one factorisation each, in the others they share one, in "
               "addition "
               "to those of the Newton iterations; the paper does not say which it has. Positions take one iteration "
               "(tEnd2 = "
               "1); the global system is iterated until it converges, which also takes one iteration.") +
           tall(table_of_cells(2, ratios)) +
           faint(
               "Absolute times in s for the 20,000 steps of the paper, with the fastest split. Here some steps are "
               "timed and "
               "their time is scaled: cells that would take hours are run for two steps only.") +
           small(table_of_cells(2, times));
  finish(s, r, 2);
  return s;
}

// ---- figures 2 and 3

std::string size_text(double size) { return output::grouped(std::llround(size)); }

Series line(std::string name, int colour, Series::Mark mark) {
  return {.name = std::move(name), .points = {}, .colour = colour, .mark = mark, .line = Series::Line::straight};
}

void add(Series& s, const PaperCell& cell, double ratio) {
  const auto size = static_cast<double>(cell.total());
  s.points.push_back({size, ratio, s.name + ", total size " + size_text(size) + ": " + ratio_text(ratio), ""});
}

std::string figure_of(const std::string& title, const std::string& y, std::vector<Series> all) {
  std::erase_if(all, [](const Series& s) { return s.points.empty(); });
  return pictures::figure({.title = title,
                           .x = {"total size", true, size_text},
                           .y = {y, true, output::number},
                           .series = std::move(all),
                           .guides = {}});
}

Section figure_2(const PaperResults& r) {
  Section s{"paper-figure-2", "Figure 2: speed-up over the global formulation with MA27"};
  const auto speed_up = [&s](bool theirs, Times times, std::string_view version, int colour) {
    Series out = line(std::string(version) + (theirs ? ", paper (i5)" : ", here"), colour,
                      theirs ? Series::Mark::cross : Series::Mark::dot);
    for (const PaperCell& cell : cells_of_table(2)) {
      const double ratio = best(times, cell, kGlobalSparse) / best(times, cell, version);
      if (std::isnan(ratio)) continue;
      add(out, cell, ratio);
      const PaperTiming& t = *fastest(times, cell, version);
      s.measurements.push_back({"total size " + std::to_string(cell.total()),
                                theirs ? t.version + " " + text_of(t.split) : t.strategy, "speed-up over GMA27", "1",
                                ratio, theirs ? "from the paper's table 2, Core i5-2400" : "from table 2, here", 0, 0,
                                t.deviation});
    }
    return out;
  };
  s.body = figure_of("Speed-up over GMA27 against total size", "speed-up over GMA27",
                     {speed_up(true, paper_times(2), kDense, 0), speed_up(false, r.times, kDense, 0),
                      speed_up(true, paper_times(2), kSparse, 1), speed_up(false, r.times, kSparse, 1),
                      speed_up(false, r.times, kAuto, Series::kInk)}) +
           faint("From table 2: time of GMA27 over the time of each version with its fastest split.");
  return s;
}

Section figure_3(const PaperResults& r) {
  Section s{"paper-figure-3", "Figure 3: OpenMP x MKL threads"};
  if (r.threads < 2) {
    s.body = paragraph("One thread only: there are no splits to compare.");
    return s;
  }
  std::vector<Series> all;
  for (const Split& split : splits(r.threads, 6)) {
    if (split == Split{}) continue;
    Series& series =
        all.emplace_back(line(text_of(split), static_cast<int>(all.size()) % Series::kColours, Series::Mark::dot));
    for (const PaperCell& cell : cells_of_table(2)) {
      const PaperTiming* const t = fastest(r.times, cell, kDense, just(split));
      if (t == nullptr) continue;
      const double ratio = best(r.times, cell, kDense, just({})) / t->seconds;
      if (std::isnan(ratio)) continue;
      add(series, cell, ratio);
      s.measurements.push_back({"total size " + std::to_string(cell.total()), t->strategy, "speed-up over 1x1", "1",
                                ratio, "from table 2, here", t->rounds, t->spread / t->seconds, t->deviation});
    }
  }
  s.body =
      figure_of("Speed-up of GEOMP+MKL over one thread against total size", "speed-up over 1x1", std::move(all)) +
      faint(
          "The paper's text gives neither sizes nor base of this figure; here they are the sizes of table 2 and 1x1. "
          "The paper's figure shows two Xeon E5-2620 with 12 cores: OpenMP alone is the fastest for small sizes, "
          "OpenMP and MKL together for large ones. This machine: " +
          output::counted(r.threads, "thread") + ".");
  return s;
}

// ---- table 3

Section table_3(const PaperResults& r) {
  const Times theirs = paper_times(3), here = r.times;
  const int p = std::min(r.threads, 4);
  std::vector<Column> ratios = {groups(), unknowns()}, times = ratios;
  std::vector<std::pair<std::string, TimeOf>> all_theirs, all_here;
  struct Way {
    const char* name;
    std::string_view version;
    bool parallel;
  };
  for (const Way& way : {Way{"MKL", kDense, false}, Way{"MA27", kSparse, false}, Way{"GEOMP+MKL", kDense, true},
                         Way{"GEOMP+MA27", kSparse, true}}) {
    const auto add = [&](const std::string& whose, Times of, int threads, auto& all) {
      const Splits split = just({way.parallel ? threads : 1, 1});
      const TimeOf time = time_of(of, way.version, split);
      if (!all.empty()) ratios.push_back(ratio(way.name + whose, all[0].second, time));  // over MKL by one thread
      times.push_back(run(way.name + whose, of, way.version, split));
      all.emplace_back(way.name, time);
    };
    add(", paper", theirs, 4, all_theirs);
    add(", here", here, p, all_here);
  }
  ratios.push_back(ratio("auto, here", all_here[0].second, time_of(here, kAuto)));
  ratios.push_back(winner("fastest, paper", all_theirs));
  ratios.push_back(winner("fastest, here", all_here));
  times.push_back(run("auto", here, kAuto));

  Section s{"paper-table-3", "Table 3: number and size of groups"};
  s.body = paragraph(
               "Speed-up over MKL with one thread, one group after another. Paper: four OpenMP threads of a Core "
               "i5-2400; here: " +
               output::counted(p, "thread") + ".") +
           tall(table_of_cells(3, ratios)) + faint("Absolute times in s for 20,000 steps.") +
           small(table_of_cells(3, times));
  finish(s, r, 3);
  return s;
}

// ---- table 4

// The source of energies on this machine.
struct Energy {
  bool counted = false;  // read from the processor
  double watts = 0;      // otherwise energy = time x this power
  std::string origin;    // of a measurement
  std::string sentence;

  Energy(const PaperResults& r, const PaperOptions& options) {
    const std::string& why_not = options.meter.why_not();
    counted = why_not.empty();
    watts = options.watts > 0 ? options.watts : paper_machine("E5").watts / 6 * r.threads;
    const std::string estimate = "estimated from time x " + output::number(watts) + " W";
    if (counted) {
      origin = "measured: RAPL, all packages, idle parts included";
      sentence = "Energy here: counters of the processor (RAPL), all packages including idle parts.";
    } else if (options.watts > 0) {
      origin = estimate + " (thermal design power, as given)";
      sentence = "Energy here is an estimate, time x " + output::number(watts) + " W (given), because " + why_not + ".";
    } else {
      origin = estimate + ", an assumption (95 W for six cores)";
      sentence = "Energy here is an estimate by the rule of the paper, time x thermal design power, because " +
                 why_not +
                 ". The power of this processor is unknown; the assumption is 95 W for six cores, as for the E5 of the "
                 "paper: " +
                 ratio_text(watts) + " W for " + output::counted(r.threads, "thread") + ".";
    }
  }

  // Energy of all steps of a cell, J; NaN if unknown.
  [[nodiscard]] double of(const PaperTiming* t) const {
    return t == nullptr ? kNan : counted ? t->joules : t->seconds * watts * t->cell.steps;
  }
};

Section table_4(const PaperResults& r, const PaperOptions& options) {
  const Energy energies(r, options);
  const Splits split = just({std::min(r.threads, 4), 1});
  const TimeOf dense = time_of(r.times, kDense, split), own = time_of(r.times, kAuto);
  std::vector<Column> ratios = {terminal(), unknowns()}, times = ratios, joules;
  for (const std::string_view machine : {"RP2", "RP3", "i5", "E5"}) {
    const auto theirs = [machine](const PaperCell& cell) -> const PaperTiming& {
      const std::vector<PaperTiming>& all = paper_times(4);
      return *std::find_if(all.begin(), all.end(),
                           [&](const PaperTiming& t) { return t.cell == cell && t.machine == machine; });
    };
    const TimeOf time = [theirs](const PaperCell& cell) { return theirs(cell).seconds; };
    const std::string name(machine);
    ratios.push_back(ratio(name + ", paper", time, at_first(4, time)));
    times.push_back(
        {name + ", s", number, [time](const PaperCell& cell) { return output::fixed(time(cell) * cell.steps); }});
    joules.push_back(
        {name + ", J", number, [theirs](const PaperCell& cell) { return ratio_text(theirs(cell).joules); }});
  }
  ratios.push_back(ratio("GEOMP+MKL, here", dense, at_first(4, dense)));
  ratios.push_back(ratio("auto, here", own, at_first(4, own)));
  ratios.push_back(ratio("auto over GEOMP+MKL", dense, own));
  if (has_gpu(r)) {
    const TimeOf gpu = time_of(r.times, kGpu);
    ratios.push_back(ratio("GPU, here", gpu, at_first(4, gpu)));
    ratios.push_back(ratio("GEOMP+MKL over GPU", dense, gpu));
    times.push_back(run("GPU, here, s", r.times, kGpu));
  }
  for (const auto& [name, version, splits] :
       {std::tuple("GEOMP+MKL, here", kDense, split), {"auto, here", kAuto, {}}}) {
    times.push_back(run(std::string(name) + ", s", r.times, version, splits));
    joules.push_back(
        {std::string(name) + ", J", number, [&, version = version, splits = splits](const PaperCell& cell) {
           const double value = energies.of(fastest(r.times, cell, version, splits));
           return value < 9.95 ? output::fixed(value) : ratio_or_dash(value);
         }});
  }
  times.insert(times.end(), joules.begin(), joules.end());

  Section s{"paper-table-4", "Table 4: small machines, and energy"};
  s.body = paragraph(
               "300 steps of 20 iterations, six groups. Paper: LAPACK or MKL with four OpenMP threads (E5: six) on "
               "Raspberry Pi 2 and 3, Core i5-2400 and Xeon E5-2620. Here: " +
               r.stand_ins.dense + " with " + output::counted(std::min(r.threads, 4), "thread") +
               ". Times over the time in the first row:") +
           paragraph(gpu_here(r) + (has_gpu(r) ? " Its energy is not known." : "")) + tall(table_of_cells(4, ratios)) +
           faint(
               "Absolute times (s) and energies (J) of 300 steps. Paper: time x 4 W for RP2, 5 W for RP3 (4 W in its "
               "text), 15 W for the i5, 95 W for the E5 (one of two processors).") +
           paragraph(energies.sentence) + small(table_of_cells(4, times));
  for (const PaperCell& cell : cells_of_table(4)) {
    for (const PaperTiming* t : {fastest(r.times, cell, kDense, split), fastest(r.times, cell, kAuto)}) {
      const double value = energies.of(t);
      if (std::isnan(value)) continue;
      Measurement& m = s.measurements.emplace_back(energy(measured(*t), cell, value));
      m.origin = energies.origin;
      if (energies.counted) {
        m.repetitions = 1;
        m.spread = 0;
      }
    }
  }
  finish(s, r, 4);
  return s;
}

// ---- table 5

Section table_5(const PaperResults& r) {
  const Times theirs = paper_times(5), here = r.times;
  const auto [wide, narrow] = wide_and_narrow(r.threads);
  const std::string w = text_of(wide), n = text_of(narrow);
  const TimeOf six_two = time_of(theirs, kDense, just({6, 2})), two_six = time_of(theirs, kDense, just({2, 6})),
               gpu = time_of(theirs, kGpu), here_wide = time_of(here, kDense, just(wide)),
               here_narrow = time_of(here, kDense, just(narrow)), own = time_of(here, kAuto),
               gpu_here_times = time_of(here, kGpu);
  std::vector<Column> times = {terminal(),
                               unknowns(),
                               seconds("6x2, paper", six_two),
                               seconds(w + ", here", here_wide),
                               seconds("2x6, paper", two_six),
                               seconds(n + ", here", here_narrow),
                               seconds("MAGMA, paper", gpu)};
  if (has_gpu(r)) times.push_back(seconds("GPU, here", gpu_here_times));
  times.push_back(seconds("auto, here", own));
  Section s{"paper-table-5", "Table 5: large groups, CPU and GPU"};
  s.body = paragraph(
               "10 steps of 10 iterations, six groups. Paper: OpenMP x MKL threads of two Xeon E5-2620 (12 cores) and "
               "MAGMA on a GTX 950. Here: " +
               w + " replaces 6x2, and " + n + " replaces 2x6, with " + output::counted(r.threads, "thread") +
               ". From n = 400 on, only the variant with 11 instead of 12 factorisations in a step is run. Ratios of "
               "times:") +
           paragraph(gpu_here(r)) +
           tall(table_of_cells(
               5, {terminal(), unknowns(), ratio("6x2/2x6, paper", six_two, two_six),
                   ratio(w + "/" + n + ", here", here_wide, here_narrow), ratio("6x2/MAGMA, paper", six_two, gpu),
                   has_gpu(r) ? ratio(w + "/GPU, here", here_wide, gpu_here_times)
                              : Column{"GPU, here", text, [](const PaperCell&) { return "no GPU here"; }},
                   ratio(w + "/auto, here", here_wide, own)})) +
           faint("Absolute times in s for 10 steps.") + small(table_of_cells(5, times));
  add_device_parts(s, r.device_parts, cpu_beside_device(r.stand_ins.dense, r.threads));
  finish(s, r, 5);
  return s;
}

// ---- conclusions

Section paper_conclusions(const PaperResults& r) {
  Section s{"paper-conclusions", "The paper's conclusions, on this machine"};
  HtmlTable table{
      {"section", "conclusion of the paper", "paper", "here", "verdict"}, {text, words, words, words, words}, {}};
  std::array<int, 3> count{};
  for (const Conclusion& c : conclusions(r.times, r.threads)) {
    ++count[static_cast<std::size_t>(c.verdict)];
    table.rows.push_back({{c.where, c.claim, c.theirs, c.here, std::string(verdict_text(c.verdict))},
                          c.verdict == Verdict::does_not_hold ? "strong" : ""});
  }
  s.body = paragraph(std::to_string(count[0]) + " hold here, " + std::to_string(count[1]) + " do not, " +
                     std::to_string(count[2]) +
                     " cannot be tested here. One rule decides each conclusion, from the times of " +
                     "the paper and from those measured here.") +
           html(table);
  const Backend& sparse = properties_of(r.stand_ins.sparse);
  if (sparse.keeps_pivots && !sparse.fills_lanes) {
    s.body +=
        faint(r.stand_ins.sparse +
              ", which replaces MA27, chooses its pivots once for a pattern and keeps them in all steps; KLU also "
              "finds the groups in the global matrix (block triangular form). All times are with one factorisation "
              "for velocity and acceleration.");
  }
  return s;
}

}  // namespace

std::vector<Section> paper_sections(const PaperResults& r, const PaperOptions& options) {
  std::vector<Section> out = {table_2(r),          figure_2(r), table_3(r),          figure_3(r),
                              table_4(r, options), table_5(r),  paper_conclusions(r)};
  if (r.noise.quiet != measure::Quiet::yes) {
    out[0].body = paragraph("The machine was not quiet: " + r.noise.reason + ".") + out[0].body;
  }
  if (r.interrupted) out[0].body = paragraph("Interrupted: only the results so far are shown.") + out[0].body;
  return out;
}

std::vector<Section> reproduce_paper(const PaperOptions& options) {
  return paper_sections(run_the_paper(options), options);
}

}  // namespace assur::report
