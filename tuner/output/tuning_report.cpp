#include "output/tuning_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "output/format.hpp"

namespace assur::output {
namespace {

using tuning::Cell;
using tuning::CellResult;

constexpr int kSolutions = 3;    // of one factorisation, as a step has them
constexpr int kSideBySide = 16;  // groups
constexpr std::size_t kMostFailures = 5;

// Without the formulation, which a bare matrix has not.
std::string short_text(const Strategy& strategy) {
  const std::string text = to_string(strategy);
  return text.substr(text.find('/') + 1);
}

std::optional<Winner> fastest(const CellResult& cell, Kernel kernel, int groups) {
  Winner best;
  best.seconds = std::numeric_limits<double>::infinity();
  for (const tuning::Result& r : cell.results) {
    const Sample& s = r.sample;
    if (s.kernel != kernel || s.strategy.lanes > groups) continue;
    double seconds = s.seconds;
    if (kernel == Kernel::factor) {
      const auto solve = std::find_if(cell.results.begin(), cell.results.end(), [&](const tuning::Result& other) {
        return other.sample.kernel == Kernel::solve && other.sample.strategy == s.strategy;
      });
      if (solve == cell.results.end()) continue;
      seconds += kSolutions * solve->sample.seconds;
    }
    if (kernel != Kernel::step) seconds /= s.strategy.lanes;
    if (seconds < best.seconds) best = {cell.cell.family, groups > 1, cell.cell.n, short_text(s.strategy), seconds};
  }
  return best.strategy.empty() ? std::nullopt : std::optional(best);
}

// "lanes:16 up to 83, lapack from 144"
std::string crossovers(const std::vector<Winner>& winners, std::size_t begin, std::size_t end) {
  std::string text;
  for (std::size_t i = begin; i < end; ++i) {
    const std::string& here = winners[i].strategy;
    if (i > begin && here == winners[i - 1].strategy) continue;
    std::size_t last = i;
    while (last + 1 < end && winners[last + 1].strategy == here) ++last;
    text += (i == begin ? "" : ", ") + here;
    if (end - begin == 1) return text;
    if (last + 1 == end) {
      text += i == begin ? " from " + number(winners[begin].n) + " to " + number(winners[last].n)
                         : " from " + number(winners[i].n);
    } else {
      text += last == i ? " at " + number(winners[i].n) : " up to " + number(winners[last].n);
    }
  }
  return text;
}

Json or_null(bool there, double value) { return there ? Json(value) : Json(nullptr); }

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
        add(Kernel::pack, std::max(cell.cell.groups, 1));
        if (!out.empty() && out.back().family == cell.cell.family) {
          out.back().family += ", steps of " + counted(cell.cell.groups, "group");
        }
        break;
      case Cell::Kind::steps:
        add(Kernel::step, std::numeric_limits<int>::max());
        if (!out.empty() && out.back().family == cell.cell.family) out.back().family += ", whole steps";
        break;
      case Cell::Kind::meeting:
        break;
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const Winner& a, const Winner& b) {
    return std::tie(a.family, a.side_by_side, a.n) < std::tie(b.family, b.side_by_side, b.n);
  });
  return out;
}

void print(Page& page, const TuningSummary& s) {
  page.title("Tuning run" + (s.run ? " " + std::to_string(*s.run) : std::string()) + ", " + s.profile);
  page.fact("samples", grouped(s.figures.samples) + " of " +
                           counted(static_cast<std::int64_t>(s.figures.measured), "cell") + " (" +
                           grouped(static_cast<std::int64_t>(s.figures.planned)) + " planned" +
                           (s.figures.earlier > 0 ? ", " + grouped(static_cast<std::int64_t>(s.figures.earlier)) +
                                                        " of them by the run that was interrupted"
                                                  : "") +
                           ") in " + duration(s.seconds));
  page.fact("grade", s.grade + (s.reason.empty() ? "" : ": " + s.reason));
  if (s.regret.questions > 0) {
    const auto percent = [](double share) { return number(std::round(1000 * share) / 10) + " %"; };
    page.fact("choices", "on what was held out they lose " + percent(s.regret.median) + " (median), " +
                             percent(s.regret.p95) + " (95 of 100), " + percent(s.regret.max) + " (most)");
  }
  page.fact("stored in", s.database.empty() ? "nothing: no database" : s.database);
  for (const auto& [backend, why] : s.failed) page.fact(backend, "left out: " + why);
  std::vector<std::string> failures = s.figures.failures;
  if (failures.size() > kMostFailures) failures.resize(kMostFailures);
  page.list("not measured", failures);

  page.gap();
  page.fact("fastest", "one factorisation and three solutions, or a step; by unknowns");
  const std::vector<Winner> all = winners(s.cells);
  for (std::size_t begin = 0; begin < all.size();) {
    std::size_t end = begin;
    while (end < all.size() && all[end].family == all[begin].family &&
           all[end].side_by_side == all[begin].side_by_side) {
      ++end;
    }
    const bool matrices = all[begin].family.find("step") == std::string::npos;
    page.fact("", all[begin].family + (matrices && all[begin].side_by_side ? ", side by side" : "") + ": " +
                      crossovers(all, begin, end));
    begin = end;
  }
}

Json to_json(const TuningSummary& s) {
  Json list = Json::array();
  for (const Winner& w : winners(s.cells)) {
    list.push_back({{"family", w.family},
                    {"side_by_side", w.side_by_side},
                    {"n", w.n},
                    {"strategy", w.strategy},
                    {"seconds", w.seconds}});
  }
  Json failed = Json::array();
  for (const auto& [backend, why] : s.failed) failed.push_back({{"backend", backend}, {"why_not", why}});
  const bool judged = s.regret.questions > 0;
  return {{"tuning_run", s.run ? Json(*s.run) : Json(nullptr)},
          {"database", s.database.empty() ? Json(nullptr) : Json(s.database)},
          {"profile", s.profile},
          {"grade", s.grade},
          {"reason", s.reason},
          {"samples", s.figures.samples},
          {"seconds", s.seconds},
          {"coverage", s.coverage()},
          {"held_out_regret",
           {{"median", or_null(judged, s.regret.median)},
            {"p95", or_null(judged, s.regret.p95)},
            {"max", or_null(judged, s.regret.max)}}},
          {"interrupted", s.figures.interrupted},
          {"left_out", std::move(failed)},
          {"not_measured", s.figures.failures},
          {"winners", std::move(list)}};
}

}  // namespace assur::output
