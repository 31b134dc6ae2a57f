#include "motion/layout.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "index.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

std::vector<Pack> fill_packs(const GroupedSystem& structure, const std::vector<std::unique_ptr<GroupSolver>>& solvers) {
  std::vector<Pack> packs;
  std::vector<std::int32_t> open(structure.classes.size(), -1);  // the pack of each class with a free lane
  std::int32_t level = -1;
  for (std::size_t g = 0; g < structure.groups.size(); ++g) {
    const SolvedGroup& group = structure.groups[g];
    if (group.level != level) {
      std::fill(open.begin(), open.end(), -1);
      level = group.level;
    }
    std::int32_t& pack = open[idx(group.group_class)];
    if (pack < 0 || packs[idx(pack)].used == solvers[idx(group.group_class)]->lanes()) {
      pack = static_cast<std::int32_t>(packs.size());
      packs.emplace_back();
      packs.back().group_class = group.group_class;
      packs.back().level = level;
      packs.back().used = 0;
    }
    packs[idx(pack)].groups.push_back(static_cast<std::int32_t>(g));
    ++packs[idx(pack)].used;
  }
  return packs;
}

// Coordinates that are driven as copies of others have their addresses.
void share_addresses(const System& system, std::vector<std::int32_t>& address) {
  for (const Assignment& a : system.assignments) {
    const std::span<const Term> terms = system.form(a.form);
    if (terms.size() != 1 || terms[0].constant != kPlus || terms[0].coordinate == kOne) continue;
    address[idx(a.coordinate)] = address[idx(terms[0].coordinate)];
  }
}

// For each input: how the addresses of the lanes follow each other.
std::vector<InputRow> input_rows(const std::vector<std::int32_t>& addresses, std::size_t count, std::size_t lanes) {
  std::vector<InputRow> rows(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t* at = addresses.data() + i * lanes;
    const auto step_by = [&](std::int32_t step) {
      for (std::size_t l = 1; l < lanes; ++l) {
        if (at[l] != at[l - 1] + step) return false;
      }
      return true;
    };
    rows[i] = {at[0], step_by(0)   ? InputRow::Kind::same
                      : step_by(1) ? InputRow::Kind::consecutive
                                   : InputRow::Kind::scattered};
  }
  return rows;
}

}  // namespace

std::vector<std::unique_ptr<GroupSolver>> make_solvers(const Preparation& prepared, int lanes, StepCode* code) {
  std::vector<std::unique_ptr<GroupSolver>> solvers;
  for (Plan::Choice choice : prepared.plan.choices) {
    if (lanes > 0) choice.solver.lanes = lanes;
    solvers.push_back(std::make_unique<GroupSolver>(*prepared.structure->system, *prepared.structure,
                                                    choice.group_class, choice, prepared.table));
    if (code != nullptr) solvers.back()->use(*code);
  }
  return solvers;
}

Layout lay_out(const Preparation& prepared) {
  const GroupedSystem& structure = *prepared.structure;
  const System& system = *structure.system;
  Layout out;
  const bool together = prepared.plan.run.together;
  out.solvers = make_solvers(prepared, together ? 1 : 0, nullptr);
  out.packs = fill_packs(structure, out.solvers);

  out.address.assign(system.coordinates.size(), -1);
  for (std::size_t c = 0; c < out.address.size(); ++c) {
    if (system.coordinates[c].role != Role::unknown) out.address[c] = static_cast<std::int32_t>(c);
  }
  for (const std::int32_t c : structure.static_coordinates) out.address[idx(c)] = c;
  share_addresses(system, out.address);
  out.first_unknown = out.size = lane_place(system.coordinates.size(), idx(kMostLanes));
  std::vector<std::size_t> order(out.packs.size());
  std::iota(order.begin(), order.end(), 0);
  if (together) {
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return out.packs[a].group_class < out.packs[b].group_class; });
  }
  for (const std::size_t p : order) {
    Pack& pack = out.packs[p];
    const GroupSolver& solver = *out.solvers[idx(pack.group_class)];
    const std::size_t w = idx(solver.lanes());
    pack.unknowns = lane_place(out.size, w);
    out.size = pack.unknowns + idx(solver.group_class().n) * w;
    for (std::size_t lane = 0; lane < pack.groups.size(); ++lane) {
      const SolvedGroup& g = structure.groups[idx(pack.groups[lane])];
      for (std::size_t i = 0; i < g.unknowns.size(); ++i) {
        out.address[idx(g.unknowns[i])] = static_cast<std::int32_t>(pack.unknowns + i * w + lane);
      }
    }
  }
  for (Pack& pack : out.packs) {
    GroupSolver& solver = *out.solvers[idx(pack.group_class)];
    const std::size_t w = idx(solver.lanes()), count = idx(solver.group_class().inputs);
    pack.inputs.resize(count * w);
    for (std::size_t lane = 0; lane < w; ++lane) {
      const SolvedGroup& g = structure.groups[idx(pack.groups[lane < pack.groups.size() ? lane : 0])];
      for (std::size_t i = 0; i < count; ++i) pack.inputs[i * w + lane] = out.address[idx(g.inputs[i])];
    }
    pack.input_rows = input_rows(pack.inputs, count, w);
    solver.size(pack);
    solver.bind(pack, [&](std::size_t lane) {
      return std::tie(system, structure.groups[idx(pack.groups[lane < pack.groups.size() ? lane : 0])]);
    });
  }
  out.change_points.resize(out.packs.size());
  return out;
}

Layout lay_out_side_by_side(const Preparation& prepared, int lanes) {
  const GroupedSystem& structure = *prepared.structure;
  const System& system = *structure.system;
  const std::size_t w = idx(lanes);
  Layout out;
  out.solvers = make_solvers(prepared, lanes, prepared.code.get());
  out.address.assign(system.coordinates.size(), -1);
  for (std::size_t c = 0; c < out.address.size(); ++c) {
    if (system.coordinates[c].role != Role::unknown) out.address[c] = static_cast<std::int32_t>(c * w);
  }
  for (const std::int32_t c : structure.static_coordinates) out.address[idx(c)] = c * lanes;
  share_addresses(system, out.address);
  out.first_unknown = out.size = lane_place(system.coordinates.size() * w, w);
  std::vector<std::int32_t> each(w);
  std::iota(each.begin(), each.end(), 0);
  for (const SolvedGroup& group : structure.groups) {
    const bool at_rest = out.first_unknown == out.size && rests(structure.classes[idx(group.group_class)]);
    Pack& pack = out.packs.emplace_back();
    pack.group_class = group.group_class;
    pack.level = group.level;
    pack.groups = each;
    pack.unknowns = out.size;
    for (std::size_t i = 0; i < group.unknowns.size(); ++i) {
      out.address[idx(group.unknowns[i])] = static_cast<std::int32_t>(out.size + i * w);
    }
    out.size += idx(out.solvers[idx(group.group_class)]->group_class().n) * w;
    if (at_rest) out.first_unknown = out.size;  // solved at the start, and known from then on
  }
  for (std::size_t g = 0; g < out.packs.size(); ++g) {
    Pack& pack = out.packs[g];
    for (const std::int32_t c : structure.groups[g].inputs) {
      for (int lane = 0; lane < lanes; ++lane) pack.inputs.push_back(out.address[idx(c)] + lane);
    }
    pack.input_rows = input_rows(pack.inputs, structure.groups[g].inputs.size(), w);
    out.solvers[idx(pack.group_class)]->size(pack);
  }
  out.change_points.resize(out.packs.size());
  return out;
}

}  // namespace assur
