#include "tuning/tuning_report.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "numbers.hpp"
#include "output/format.hpp"

namespace assur::output {
std::string short_text(const Strategy& strategy) {
  const std::string text = to_string(strategy);
  return text.substr(text.find('/') + 1);
}

namespace {

using tuning::Cell;
using tuning::CellResult;

constexpr int kSolutions = 3;    // solutions for one factorisation, as in a step
constexpr int kSideBySide = 16;  // groups
constexpr std::size_t kMostFailures = 5;

// The fastest candidate with no more lanes than `groups`.
std::optional<Winner> fastest(const CellResult& cell, Kernel kernel, int groups) {
  Winner best;
  best.seconds = kInfinity;
  for (const tuning::Result& r : cell.results) {
    const Sample& s = r.sample;
    if (s.kernel != kernel || (kernel != Kernel::step && s.strategy.solver.lanes > groups)) continue;
    double seconds = s.seconds;
    if (kernel == Kernel::factor) {
      const auto solve = std::find_if(cell.results.begin(), cell.results.end(), [&](const tuning::Result& other) {
        return other.sample.kernel == Kernel::solve && other.sample.strategy == s.strategy;
      });
      if (solve == cell.results.end()) continue;
      seconds += kSolutions * solve->sample.seconds;
    }
    if (kernel != Kernel::step) seconds /= s.strategy.solver.lanes;
    if (seconds >= best.seconds) continue;
    best = {cell.cell.family,       kernel, kernel == Kernel::factor && groups > 1, s.shape.n, cell.cell.groups,
            short_text(s.strategy), seconds};
  }
  if (best.strategy.empty()) return std::nullopt;
  if (best.side_by_side) best.family += ", side by side";
  if (kernel == Kernel::pack) best.family += ", n = " + number(best.n) + ", steps by groups";
  if (kernel == Kernel::step) best.family += ", whole steps";
  return best;
}

// "lanes:16 up to 83, lapack from 144": numbers of unknowns, or of groups, within one family.
std::string crossovers(std::span<const Winner> family) {
  const auto size = [](const Winner& w) { return number(w.kernel == Kernel::pack ? w.groups : w.n); };
  std::string text;
  for (std::size_t begin = 0, end = 0; begin < family.size(); begin = end) {
    while (end < family.size() && family[end].strategy == family[begin].strategy) ++end;
    const std::string first = size(family[begin]), last = size(family[end - 1]);
    text += (begin == 0 ? "" : ", ") + family[begin].strategy;
    if (first == size(family.front()) && last == size(family.back())) {
      if (first != last) text += " from " + first + " to " + last;
    } else if (end == family.size()) {
      text += " from " + first;
    } else {
      text += first == last ? " at " + first : " up to " + last;
    }
  }
  return text;
}

void print_proofs(Page& page, const std::vector<tuning::Proof>& proofs) {
  if (proofs.empty()) return;
  using enum Table::Align;
  page.gap();
  page.fact("proof", "whole steps of mechanisms that the model has no samples of, one thread");
  Table table({left, left, right, right, right, left});
  table.row({"mechanism", "expected to be fastest", "step", "/expected", "regret", "fastest"});
  for (const tuning::Proof& p : proofs) {
    table.row({p.scene, p.chosen, duration(p.seconds), fixed(p.seconds / p.expected_seconds),
               number(std::round(100 * p.regret())) + " %", p.regret() > 0 ? p.fastest : ""});
  }
  page.table(table);
}

}  // namespace

std::vector<Winner> winners(std::span<const CellResult> cells) {
  std::vector<Winner> out;
  for (const CellResult& cell : cells) {
    const auto add = [&](Kernel kernel, int groups) {
      if (std::optional<Winner> w = fastest(cell, kernel, groups)) out.push_back(std::move(*w));
    };
    switch (cell.cell.kind) {
      case Cell::Kind::matrix:
        add(Kernel::factor, 1);
        add(Kernel::factor, kSideBySide);
        break;
      case Cell::Kind::packs:
      case Cell::Kind::together:
        add(Kernel::pack, cell.cell.groups);
        break;
      case Cell::Kind::steps:
        if (cell.cell.only.empty()) add(Kernel::step, 0);
        break;
      case Cell::Kind::around:
      case Cell::Kind::crowd:
      case Cell::Kind::meeting:
        break;
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const Winner& a, const Winner& b) {
    return std::tie(a.family, a.n, a.groups) < std::tie(b.family, b.n, b.groups);
  });
  return out;
}

void print(Page& page, const TuningSummary& s) {
  page.title("Tuning run" + (s.run ? " " + std::to_string(*s.run) : std::string()) + ", " + s.profile);
  const auto count = [](std::size_t cells) { return grouped(cells); };
  std::string samples = grouped(s.figures.samples) + " of " + count(s.figures.measured) + " cells in " +
                        duration(s.seconds) + "; " + count(s.figures.planned) + " planned";
  if (s.figures.passes > 1) samples += ", each measured up to " + count(s.figures.passes) + " times";
  if (s.figures.cut_short > 0) samples += ", " + count(s.figures.cut_short) + " cut short";
  samples += "; timed calls took " + duration(s.figures.race.timed);
  if (s.figures.earlier > 0) samples += ", " + count(s.figures.earlier) + " from the interrupted run";
  page.fact("samples", samples);
  if (s.figures.interrupted) {
    page.fact("interrupted", s.database.empty() ? "the cells measured so far are shown"
                                                : "the samples are kept; the same command continues the run");
  }
  page.fact("grade", s.grade + (s.reason.empty() ? "" : ": " + s.reason));
  if (s.regret.questions > 0) {
    const auto percent = [](double share) { return number(std::round(1000 * share) / 10) + " %"; };
    page.fact("choices", "on held-out cells they are " + percent(s.regret.median) + " (median), " +
                             percent(s.regret.p95) + " (95th percentile), " + percent(s.regret.max) +
                             " (max) slower than the best");
  }
  page.fact("stored in", s.database.empty() ? "nothing: no database" : s.database);
  for (const auto& [backend, why] : s.failed) page.fact(backend, "left out: " + why);
  std::vector<std::string> failures = s.figures.failures;
  if (failures.size() > kMostFailures) failures.resize(kMostFailures);
  page.list("not measured", failures);

  print_proofs(page, s.proofs);

  page.gap();
  const std::vector<Winner> all = winners(s.cells);
  std::string label = "fastest";
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].family == all[begin].family) ++end;
    page.fact(std::exchange(label, ""),
              all[begin].family + ": " + crossovers(std::span(all).subspan(begin, end - begin)));
  }
}

Json to_json(const TuningSummary& s) {
  Json list = Json::array();
  for (const Winner& w : winners(s.cells)) {
    list.push_back({{"family", w.family},
                    {"kernel", name(w.kernel)},
                    {"n", w.n},
                    {"groups", w.groups},
                    {"side_by_side", w.side_by_side},
                    {"strategy", w.strategy},
                    {"seconds", w.seconds}});
  }
  Json proofs = Json::array();
  for (const tuning::Proof& p : s.proofs) {
    proofs.push_back({{"scene", p.scene},
                      {"strategy", p.chosen},
                      {"seconds", p.seconds},
                      {"expected_seconds", p.expected_seconds},
                      {"fastest", p.fastest},
                      {"fastest_seconds", p.fastest_seconds},
                      {"regret", p.regret()}});
  }
  Json failed = Json::array();
  for (const auto& [backend, why] : s.failed) failed.push_back({{"backend", backend}, {"why_not", why}});
  const bool judged = s.regret.questions > 0;
  return {{"tuning_run", or_null(s.run)},
          {"database", or_null(s.database)},
          {"profile", s.profile},
          {"grade", s.grade},
          {"reason", s.reason},
          {"samples", s.figures.samples},
          {"passes", s.figures.passes},
          {"seconds", s.seconds},
          {"timed_seconds", s.figures.race.timed},
          {"coverage", s.figures.coverage()},
          {"cells",
           {{"planned", s.figures.planned},
            {"measured", s.figures.measured},
            {"cut_short", s.figures.cut_short},
            {"of_interrupted_run", s.figures.earlier}}},
          {"held_out_regret",
           {{"median", or_null(judged, s.regret.median)},
            {"p95", or_null(judged, s.regret.p95)},
            {"max", or_null(judged, s.regret.max)}}},
          {"proof", std::move(proofs)},
          {"interrupted", s.figures.interrupted},
          {"left_out", std::move(failed)},
          {"not_measured", s.figures.failures},
          {"winners", std::move(list)}};
}

}  // namespace assur::output
