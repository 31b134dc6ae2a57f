#include "program/mechanism_step.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "equations/drive.hpp"
#include "index.hpp"
#include "program/group_step.hpp"
#include "program/step_graph.hpp"

namespace assur {
namespace {

constexpr Memory kState[] = {Memory::state, Memory::state_rates, Memory::state_accelerations};
constexpr Memory kLaws[] = {Memory::laws, Memory::law_rates, Memory::law_accelerations};
constexpr Memory kInputs[] = {Memory::inputs, Memory::input_rates, Memory::input_accelerations};
constexpr Value Jet<Value>::*kParts[] = {&Jet<Value>::value, &Jet<Value>::rate, &Jet<Value>::acceleration};

class MechanismWriter {
 public:
  explicit MechanismWriter(const MechanismOutline& outline) : of_(outline) {}

  [[nodiscard]] MechanismStep write(std::size_t most) {
    std::size_t instructions = 0;
    for (std::size_t g = 0; g < of_.groups.size(); ++g) {
      Graph graph;
      if (g == 0) {
        drive(graph);
        if (reads_driven_apart(g)) {  // which must be stored first
          out_.program.phases.push_back(graph.take_phase());
          out_.program.phases.back().lanes = of_.lanes;
          driven_.clear();
        }
      }
      const MechanismOutline::Groups& groups = of_.groups[g];
      const GroupBegin begin{graph, static_cast<std::uint16_t>(g), find_inputs(graph, g), predict(graph, g)};
      GroupProgram step = group_step(groups.group_class, groups.reads, &begin);
      out_.work = std::max(out_.work, step.work);
      for (Phase& phase : step.program.phases) {
        instructions += phase.code.size();
        phase.lanes = groups.lanes;
        out_.program.phases.push_back(std::move(phase));
      }
      if (instructions > most) return {};
      driven_.clear();
    }
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::span<const std::int32_t> addresses(std::size_t group, std::int32_t input) const {
    const std::size_t w = idx(of_.groups[group].lanes);
    return of_.groups[group].inputs.subspan(idx(input) * w, w);
  }
  static Slot one(Memory memory, std::int32_t index) { return {memory, static_cast<std::uint32_t>(index), Reach::one}; }
  // A coordinate.
  [[nodiscard]] Slot coordinate(std::size_t derivative, std::int32_t address) const {
    Slot slot = one(kState[derivative], address);
    if (of_.lanes > 1) slot.reach = Reach::from;
    return slot;
  }
  static bool moves(const MechanismOutline::Groups& groups, std::int32_t input) {
    return groups.group_class.input_moves[idx(input)] != 0;
  }

  // ---- driven coordinates

  void drive(Graph& graph) {
    const DrivenOutline& d = of_.driven;
    std::map<std::int32_t, Jet<Value>> of_slot;
    const auto law = [&](std::int32_t slot) {
      return Jet<Value>{graph.load(one(kLaws[0], slot)), graph.load(one(kLaws[1], slot)),
                        graph.load(one(kLaws[2], slot))};
    };
    const auto turn = [&](std::int32_t angle) {
      return cos_sin<Value>(law(angle), graph.load(one(Memory::cosines, angle)), graph.load(one(Memory::sines, angle)));
    };
    for (const auto& [angle, result] : d.directions) {
      const CosSin<Value> both = turn(angle);
      of_slot[result] = both.cosine;
      of_slot[result + 1] = both.sine;
    }
    for (const auto& [angle, result] : d.frames) {
      Jet<Value> r[9];
      euler_zyx(turn(angle), turn(angle + 1), turn(angle + 2), r);
      for (std::int32_t k = 0; k < 9; ++k) of_slot[result + k] = r[k];
    }
    const auto put = [&](std::int32_t address, const Jet<Value>& at) {
      driven_[address] = at;
      for (std::size_t k = 0; k < 3; ++k) graph.store(coordinate(k, address), at.*kParts[k]);
    };
    for (const DrivenOutline::Copy& c : d.copies) put(c.address, c.slot < d.laws ? law(c.slot) : of_slot.at(c.slot));
    for (const DrivenOutline::Sum& s : d.sums) {
      Jet<Value> total;
      for (const DrivenOutline::Term& t : s.terms) {
        const Value factor = graph.load(one(Memory::factors, factor_++));
        const Jet<Value> at = state(graph, t.address);
        for (const auto part : kParts) total.*part = total.*part + factor * (at.*part);
      }
      put(s.address, total);
    }
    Value sum = Value::set(0);
    for (std::int32_t slot = 0; slot < d.laws; ++slot) {
      for (const auto part : kParts) sum = sum + law(slot).*part;
    }
    graph.store(kUndefined, sum - sum);
  }
  // The same number for all lanes of one mechanism.
  [[nodiscard]] Jet<Value> state(Graph& graph, std::int32_t address) const {
    if (const auto driven = driven_.find(address); driven != driven_.end()) return driven->second;
    return {graph.load(coordinate(0, address)), graph.load(coordinate(1, address)), graph.load(coordinate(2, address))};
  }

  // ---- groups

  // Inputs that move, which are stored for later phases, too.
  [[nodiscard]] std::array<std::vector<Value>, 3> find_inputs(Graph& graph, std::size_t group) {
    const MechanismOutline::Groups& groups = of_.groups[group];
    std::array<std::vector<Value>, 3> values;
    values.fill(std::vector<Value>(idx(groups.group_class.inputs)));
    for (std::int32_t i = 0; i < groups.group_class.inputs; ++i) {
      if (!moves(groups, i)) continue;
      const Jet<Value> input = gathered(graph, addresses(group, i));
      for (std::size_t d = 0; d <= idx(groups.group_class.derivatives); ++d) {
        values[d][idx(i)] = input.*kParts[d];
        graph.store({kInputs[d], static_cast<std::uint32_t>(i), Reach::row, static_cast<std::uint16_t>(group)},
                    input.*kParts[d]);
      }
    }
    return values;
  }
  [[nodiscard]] std::vector<Value> predict(Graph& graph, std::size_t group) const {
    const MechanismOutline::Groups& groups = of_.groups[group];
    std::vector<Value> unknowns;
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(groups.group_class.n); ++j) {
      Value sum = Value::set(0);
      for (std::uint32_t k = 0; k < of_.weights; ++k) {
        const auto memory = static_cast<Memory>(static_cast<std::uint32_t>(Memory::past) + k);
        sum.add_product(
            graph.load({Memory::weights, k, Reach::one}),
            graph.load({memory, groups.unknowns + j * static_cast<std::uint32_t>(groups.lanes), Reach::from}));
      }
      unknowns.push_back(sum);
    }
    return unknowns;
  }

  // True if the addresses of the lanes follow each other at this distance.
  [[nodiscard]] static bool are_apart(std::span<const std::int32_t> lanes, std::int32_t by) {
    return std::adjacent_find(lanes.begin(), lanes.end(), [&](auto a, auto b) { return b != a + by; }) == lanes.end();
  }
  // True if lanes read different driven coordinates.
  [[nodiscard]] bool reads_driven_apart(std::size_t group) const {
    if (of_.lanes > 1) return false;
    for (std::int32_t i = 0; i < of_.groups[group].group_class.inputs; ++i) {
      const std::span<const std::int32_t> from = addresses(group, i);
      const auto is_driven = [&](std::int32_t a) { return driven_.count(a) != 0; };
      if (!are_apart(from, 0) && std::any_of(from.begin(), from.end(), is_driven)) return true;
    }
    return false;
  }
  [[nodiscard]] Jet<Value> gathered(Graph& graph, std::span<const std::int32_t> from) {
    if (of_.lanes > 1 || are_apart(from, 0)) return state(graph, from[0]);
    Slot slot{Memory::state, static_cast<std::uint32_t>(from[0]), Reach::from};
    if (!are_apart(from, 1)) slot = {Memory::state, add_addresses(from), Reach::scattered};
    Jet<Value> out;
    for (std::size_t k = 0; k < 3; ++k) {
      slot.memory = kState[k];
      out.*kParts[k] = graph.load(slot);
    }
    return out;
  }

  std::uint32_t add_addresses(std::span<const std::int32_t> lanes) {
    std::vector<std::int32_t>& all = out_.program.addresses;
    const std::size_t begin = all.size();
    all.insert(all.end(), lanes.begin(), lanes.end());
    return static_cast<std::uint32_t>(begin);
  }

  const MechanismOutline& of_;
  MechanismStep out_;
  std::int32_t factor_ = 0;                    // the next one
  std::map<std::int32_t, Jet<Value>> driven_;  // by address, in the first phase
};

}  // namespace

MechanismStep mechanism_step(const MechanismOutline& outline, std::size_t most) {
  return MechanismWriter(outline).write(most);
}

}  // namespace assur
