#include "tuning/replay.hpp"

#include <algorithm>

#include "tuning/refinement.hpp"

namespace assur::tuning {
namespace {

Cell::Kind kind_of(const Sample& s) {
  switch (s.kernel) {
    case Kernel::evaluate:
    case Kernel::factor:
    case Kernel::solve:
      return Cell::Kind::matrix;
    case Kernel::pack:
      if (s.strategy.run.together) return Cell::Kind::together;
      return s.strategy.run.threads > 1 ? Cell::Kind::crowd : Cell::Kind::packs;
    case Kernel::meeting:
      return Cell::Kind::meeting;
    case Kernel::around:
      return Cell::Kind::around;
    case Kernel::step:
      break;
  }
  return Cell::Kind::steps;
}

double timed(const CellResult& cell) {
  double sum = 0;
  for (const Result& r : cell.results) sum += r.sample.seconds * static_cast<double>(r.sample.repetitions);
  return sum;
}

}  // namespace

std::vector<CellResult> cells_of(std::span<const Sample> samples) {
  std::vector<CellResult> cells;
  for (const Sample& s : samples) {
    const Cell::Kind kind = kind_of(s);
    const auto same = [&](const CellResult& c) {
      return c.cell.kind == kind && c.results.front().sample.shape == s.shape;
    };
    // The samples of a cell follow each other, because it is stored as a whole.
    auto at = std::find_if(cells.rbegin(), cells.rend(), same);
    if (at == cells.rend()) {
      CellResult fresh;
      fresh.cell.kind = kind;
      fresh.cell.n = s.shape.n;
      fresh.cell.groups = s.shape.groups;
      const bool judges = kind != Cell::Kind::crowd && kind != Cell::Kind::together;
      fresh.cell.held_out = judges && is_held_out(s.kernel, s.shape);
      cells.push_back(std::move(fresh));
      at = cells.rbegin();
    }
    add(at->results, Result(s));
  }
  return cells;
}

std::vector<Stage> replay(std::span<const CellResult> cells, int most) {
  double all = 0;
  for (const CellResult& c : cells) all += c.cell.held_out ? 0 : timed(c);
  std::vector<Stage> stages;
  std::vector<CellResult> judges, known;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(judges), [](const auto& c) { return c.cell.held_out; });
  double spent = 0;
  std::size_t samples = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].cell.held_out) continue;
    known.push_back(cells[i]);
    samples += cells[i].results.size();
    spent += timed(cells[i]);
    const bool last = std::all_of(cells.begin() + static_cast<std::ptrdiff_t>(i) + 1, cells.end(),
                                  [](const auto& c) { return c.cell.held_out; });
    if (!last && spent * most < all * static_cast<double>(stages.size() + 1)) continue;
    stages.push_back({known.size(), samples, spent / all, regret(model_of(known), judges)});
  }
  return stages;
}

}  // namespace assur::tuning
