// Tables 4 and 5: other machines, with the energy that they take.
#include <algorithm>
#include <cmath>

#include "output/format.hpp"
#include "pictures/html.hpp"
#include "report/paper/conclusions.hpp"
#include "report/paper/figures.hpp"
#include "report/paper/parts.hpp"

namespace assur::report {
namespace {

using pictures::HtmlTable;
using Times = std::span<const PaperTiming>;

constexpr std::array<std::string_view, 4> kMachines = {"RP2", "RP3", "i5", "E5"};

std::string one_decimal(double value) {
  if (std::isnan(value)) return "-";
  return value < 9.95 ? output::fixed(value) : ratio_text(value);
}

const PaperEnergy& theirs(const PaperCell& cell, std::string_view machine) {
  const std::vector<PaperEnergy>& all = paper_energies();
  return *std::find_if(all.begin(), all.end(),
                       [&](const PaperEnergy& e) { return e.cell == cell && e.machine == machine; });
}

// How joules come about here.
struct Energy {
  bool counted = false;  // by the processor
  double watts = 0;      // else time x this
  std::string origin;    // of a measurement
  std::string sentence;

  Energy(const PaperResults& r, const PaperOptions& options) {
    if (options.meter.why_not().empty()) {
      counted = true;
      origin = "measured: RAPL, all packages, idle parts included";
      sentence = "Energy here: counted by the processor (RAPL), all packages with their idle parts.";
      return;
    }
    if (options.watts > 0) {
      watts = options.watts;
      origin = "estimated from time x " + output::number(watts) + " W (thermal design power, as given)";
      sentence = "Energy here is an estimate, time x " + output::number(watts) + " W as was given, for " +
                 options.meter.why_not() + ".";
      return;
    }
    const double watts_of_a_core = paper_machine("E5").watts / 6;
    watts = watts_of_a_core * r.threads;
    origin = "estimated from time x " + output::number(watts) + " W, an assumption (95 W for six cores)";
    sentence = "Energy here is an estimate by the paper's rule, time x thermal design power, for " +
               options.meter.why_not() +
               ". That power is not known here either: assumed are 95 W for six cores, as of "
               "the paper's E5, which makes " +
               ratio_text(watts) + " W for " + output::counted(r.threads, "thread") + ".";
  }

  // Of one step; NaN: not known.
  [[nodiscard]] double of(const PaperTiming* t) const {
    if (t == nullptr) return std::nan("");
    return counted ? t->joules : t->seconds * watts;
  }
};

// Versions of table 4 that are shown of this machine.
const PaperTiming* dense_of_table_4(const PaperResults& r, const PaperCell& cell) {
  return timing(r.times, cell, kDense, std::min(r.threads, 4), 1);
}

HtmlTable ratios_of_table_4(const PaperResults& r) {
  using enum HtmlTable::Column;
  HtmlTable table{{"T", "n", "RP2, theirs", "RP3, theirs", "i5, theirs", "E5, theirs", "GEOMP+MKL, here", "auto, here",
                   "auto over GEOMP+MKL"},
                  std::vector<HtmlTable::Column>(9, number),
                  {}};
  const PaperCell first = cells_of_table(4)[0];
  for (const PaperCell& cell : cells_of_table(4)) {
    HtmlTable::Row row{{std::to_string(cell.terminal), std::to_string(cell.n)}};
    for (const std::string_view m : kMachines) {
      row.cells.push_back(ratio_text(theirs(cell, m).seconds / theirs(first, m).seconds));
    }
    const double dense = seconds_of(dense_of_table_4(r, cell)), best = seconds_of(fastest(r.times, cell, kAuto));
    row.cells.push_back(ratio_or_dash(dense / seconds_of(dense_of_table_4(r, first))));
    row.cells.push_back(ratio_or_dash(best / seconds_of(fastest(r.times, first, kAuto))));
    row.cells.push_back(ratio_or_dash(dense / best));
    table.rows.push_back(std::move(row));
  }
  return table;
}

HtmlTable energies_of_table_4(const PaperResults& r, const Energy& energy, Section& section) {
  using enum HtmlTable::Column;
  HtmlTable table{{"T", "n"}, {number, number}, {}};
  for (const char* unit : {"s", "J"}) {
    for (const char* who : {"RP2", "RP3", "i5", "E5", "GEOMP+MKL, here", "auto, here"}) {
      table.titles.push_back(std::string(who) + ", " + unit);
      table.columns.push_back(number);
    }
  }
  for (const PaperCell& cell : cells_of_table(4)) {
    HtmlTable::Row row{{std::to_string(cell.terminal), std::to_string(cell.n)}};
    const PaperTiming* const here[2] = {dense_of_table_4(r, cell), fastest(r.times, cell, kAuto)};
    for (const std::string_view m : kMachines) row.cells.push_back(output::fixed(theirs(cell, m).seconds));
    for (const PaperTiming* t : here) row.cells.push_back(run_text(t, cell.steps));
    for (const std::string_view m : kMachines) row.cells.push_back(ratio_text(theirs(cell, m).joules));
    for (const PaperTiming* t : here) {
      const double joules = energy.of(t) * cell.steps;
      row.cells.push_back(one_decimal(joules));
      if (std::isnan(joules)) continue;
      Measurement m = measured(section.id, *t);
      m.quantity = "energy of 300 steps";
      m.unit = "J";
      m.value = joules;
      m.origin = energy.origin;
      if (energy.counted) {
        m.repetitions = 1;
        m.spread = 0;
      }
      section.measurements.push_back(std::move(m));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

void add_theirs_of_table_4(Section& section) {
  for (const PaperEnergy& e : paper_energies()) {
    PaperTiming t;
    t.cell = e.cell;
    t.version = kDense;
    t.p = e.machine == "E5" ? 6 : 4;
    t.seconds = e.seconds / e.cell.steps;
    Measurement time = of_the_paper(section.id, 4, t, e.machine), joules = time;
    joules.quantity = "energy of 300 steps";
    joules.unit = "J";
    joules.value = e.joules;
    section.measurements.push_back(std::move(time));
    section.measurements.push_back(std::move(joules));
  }
}

}  // namespace

Section paper_table_4(const PaperResults& r, const PaperOptions& options) {
  Section s{"paper-table-4", "Table 4: small machines, and energy", "", {}};
  const Energy energy(r, options);
  s.body += paragraph(
      "300 steps of 20 iterations, six groups. Theirs: LAPACK or MKL with four OpenMP threads (E5: six) on "
      "Raspberry Pi 2 and 3, Core i5-2400 and Xeon E5-2620. Here: " +
      r.stand_ins.dense + " with " + output::counted(std::min(r.threads, 4), "thread") +
      ". How the time grows from that of the first line:");
  s.body += tall(ratios_of_table_4(r));
  s.body += faint(
      "Absolute times (s) and energies (J) of 300 steps. Theirs: time x 4 W for RP2, 5 W for RP3 (their text "
      "says 4), 15 W for the i5, 95 W for the E5 (one of two processors).");
  s.body += paragraph(energy.sentence);
  s.body += small(energies_of_table_4(r, energy, s));
  s.body += faint(missing(r, cells_of_table(4)));
  add_theirs_of_table_4(s);
  add_details(s, r, cells_of_table(4));
  return s;
}

Section paper_table_5(const PaperResults& r) {
  using enum HtmlTable::Column;
  const auto [wide, narrow] = wide_and_narrow(r.threads);
  const auto pxq = [](const Split& split) { return std::to_string(split.p) + "x" + std::to_string(split.q); };
  Section s{"paper-table-5", "Table 5: large groups, CPU and GPU", "", {}};
  s.body += paragraph(
      "10 steps of 10 iterations, six groups. Theirs: OpenMP x MKL threads of two Xeon E5-2620 (12 cores) "
      "and MAGMA on a GTX 950. Here: " +
      pxq(wide) + " stands for 6x2, " + pxq(narrow) + " for 2x6, by " + output::counted(r.threads, "thread") +
      "; no GPU here. From n = 400 one reading is run only: they are 11 and 12 factorisations of a step. Ratios of "
      "times:");
  HtmlTable ratios{{"T", "n", "6x2/2x6, theirs", pxq(wide) + "/" + pxq(narrow) + ", here", "6x2/MAGMA, theirs",
                    "MAGMA, here", pxq(wide) + "/auto, here"},
                   {number, number, number, number, number, HtmlTable::Column::text, number},
                   {}};
  HtmlTable times{{"T", "n", "6x2, theirs", pxq(wide) + ", here", "2x6, theirs", pxq(narrow) + ", here",
                   "MAGMA, theirs", "auto, here"},
                  std::vector<HtmlTable::Column>(8, number),
                  {}};
  for (const PaperCell& cell : cells_of_table(5)) {
    const Times of_theirs = paper_times(5);
    const PaperTiming* const a = timing(of_theirs, cell, kDense, 6, 2);
    const PaperTiming* const b = timing(of_theirs, cell, kDense, 2, 6);
    const PaperTiming* const gpu = fastest(of_theirs, cell, "GEMAGMA");
    const PaperTiming* const here_a = timing(r.times, cell, kDense, wide.p, wide.q);
    const PaperTiming* const here_b = timing(r.times, cell, kDense, narrow.p, narrow.q);
    const PaperTiming* const ours = fastest(r.times, cell, kAuto);
    const std::vector<std::string> size = {std::to_string(cell.terminal), std::to_string(cell.n)};
    ratios.rows.push_back(
        {{size[0], size[1], ratio_or_dash(seconds_of(a) / seconds_of(b)),
          ratio_or_dash(seconds_of(here_a) / seconds_of(here_b)), ratio_or_dash(seconds_of(a) / seconds_of(gpu)),
          "no GPU here", ratio_or_dash(seconds_of(here_a) / seconds_of(ours))}});
    const auto seconds = [&](const PaperTiming* t) { return ratio_or_dash(seconds_of(t) * cell.steps); };
    times.rows.push_back(
        {{size[0], size[1], seconds(a), seconds(here_a), seconds(b), seconds(here_b), seconds(gpu), seconds(ours)}});
  }
  s.body += tall(ratios);
  s.body += faint("Absolute times, s for 10 steps.");
  s.body += small(times);
  s.body += faint(missing(r, cells_of_table(5)));
  for (const PaperTiming& t : paper_times(5)) {
    s.measurements.push_back(of_the_paper(s.id, 5, t, t.version == "GEMAGMA" ? "GTX" : "E5"));
  }
  add_details(s, r, cells_of_table(5));
  return s;
}

}  // namespace assur::report
