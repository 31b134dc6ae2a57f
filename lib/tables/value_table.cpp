#include "tables/value_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "assur/ensemble.hpp"
#include "equations/lowering.hpp"
#include "equations/outputs.hpp"
#include "equations/own_values.hpp"
#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "plan/prepare_at.hpp"
#include "program/needs.hpp"
#include "scene/names.hpp"
#include "scene/scene_source.hpp"
#include "start/assembly.hpp"
#include "start/directions.hpp"
#include "start/frame_axes.hpp"
#include "start/walk_path.hpp"
#include "structure/same_structure.hpp"
#include "tables/walk_in_lanes.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostTried = 16;    // members that are prepared before the scene as written is
constexpr std::size_t kMostRecorded = 8;  // members at which the computation may be recorded
// Tiles of members for which machine code that assembles them is made: of a Stewart platform it takes 8 ms and saves
// 0.13 ms for each tile.
constexpr std::size_t kWorthCode = 64;

// Internal units. The end of a walk is rounded to multiples of this, from which all lanes take the same iterations.
constexpr double kGrain = 0x1p-26;
constexpr double kAsGuessed = 1e-12;  // internal units
constexpr double kAsDrawn = 1e-9;     // relative residual of a posture as written that is closed but for rounding

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

// True if another mechanism has the same structure, outputs and start time.
bool alike(const Preparation& a, const GroupedSystem& b, const TimeGrid& time) {
  return same_structure(*a.structure, b) && a.structure->system->outputs == b.system->outputs &&
         same_bits(a.time.start, time.start);
}

}  // namespace

// Replays the recorded computation for the members in the lanes of one tile.
class ValueTable::Binder : public MemberBinder {
 public:
  Binder(const ValueTable& table, std::size_t lanes)
      : table_(table), replay_(*table.program_, lanes, code_for(table, lanes)) {
    const GroupedSystem& structure = *table.structure_;
    near_.reserve(structure.system->coordinates.size());
    for (const SolvedGroup& g : structure.groups) near_.insert(near_.end(), g.unknowns.begin(), g.unknowns.end());
    lanes_.reserve(lanes);
    for (std::size_t l = 0; l < lanes; ++l) lanes_.emplace_back(table);
    find_way(lanes_[0]);
    from_guess_ = near_;
    find_frames(structure);
    find_static_equations(structure);
    parameters_.resize(lanes * table.varying_.size());
    pointers_.resize(lanes);
    for (std::size_t l = 0; l < lanes; ++l) pointers_[l] = parameters_.data() + l * table.varying_.size();
    if (!table.assembly_ || !can_take(Path::walk_in_lanes, needs_of(structure))) return;
    in_lanes_ = WalkInLanes::make(table.assembly_->system, table.assembly_->parts, structure.start,
                                  static_cast<int>(lanes), code_for(table, lanes));
  }

  void bind(std::span<const std::size_t> members, std::span<const Variant*> variants) override {
    for (std::size_t l = 0; l < members.size(); ++l) {
      const auto row = table_.row(members[l]);
      double* const to = parameters_.data() + l * table_.varying_.size();
      for (std::size_t k = 0; k < table_.varying_.size(); ++k) to[k] = row[table_.varying_[k]];
    }
    replay_.run(std::span(pointers_).first(members.size()));
    std::vector<std::size_t> open;
    for (std::size_t l = 0; l < members.size(); ++l) {
      variants[l] = nullptr;
      if (!replay_.holds(l) || !table_.has_constants(members[l])) continue;
      lanes_[l].set(replay_, l, *this);
      if (table_.recipe_->has_drivers() && is_another_way(lanes_[l])) find_way(lanes_[l]);
      variants[l] = &lanes_[l].variant;
      if (!starts_as_written(lanes_[l])) open.push_back(l);
    }
    for (const std::size_t l : in_lanes_ && !open.empty() ? walk_together(open) : open) {
      if (!assemble(l)) variants[l] = nullptr;
    }
  }

  bool assemble(std::size_t i) override {
    if (!table_.assembly_) return false;
    const std::vector<WalkedPart>& parts = table_.assembly_->parts;
    Lane& lane = lanes_[i];
    std::vector<double> q;
    if (!place_as_written(i, q) || !close(lane.open->system, parts, q)) return false;
    const DriversWay& drivers = way_of(lane);
    if (drivers.moves && walk(lane.open->system, parts, drivers.way, q).end != Walked::End::arrived) return false;
    return arrive(lane, [&](Index c) { return q[idx(c)]; });
  }

  [[nodiscard]] bool is_start(const Variant& guess, std::span<const double> posture) const override {
    // In the plane, every lever that stays positive determines its angle.
    const System& s = *guess.system;
    if (s.dimension == 3 && !(undefined_driver(s, posture).empty() && wrong_axis(s, posture).empty())) return false;
    const auto is_near = [&](Index c) { return std::abs(posture[idx(c)] - guess.posture[idx(c)]) <= kNearGuess; };
    return std::all_of(near_.begin(), near_.end(), is_near) &&
           std::all_of(frames_.begin(), frames_.end(), [&](std::size_t f) {
             const FrameAxes axes = frame_axes(*guess.system, guess.system->frames[f], posture);
             return !axes.mirrored && axes.skew <= kSkew;
           });
  }

 private:
  // The equations before presolve, with the numbers of one member.
  struct OneMember {
    explicit OneMember(const Assembly& of) : system(of.system), target(of.recipe, system) {}

    System system;
    Recipe::Target target;
  };

  // The way of the drivers from the posture as written to their laws.
  struct DriversWay {
    bool exists = true;  // false: a law has no value at the start
    bool moves = false;  // the drivers do
    WalkPath way;
    std::vector<double> begin, end;  // coordinates, of which those of inputs are set
    std::vector<double> written;     // values of all drivers, from which it begins
  };

  // The systems of a lane, whose numbers are those of its member.
  struct Lane {
    explicit Lane(const ValueTable& table)
        : system(std::make_shared<System>(*table.structure_->system)),
          target(*table.recipe_, *system),
          variant{system,
                  table.structure_->start,
                  table.first_->time.start,
                  {},
                  {},
                  Variant::Changes{table.recipe_->has_outputs(), table.recipe_->has_laws(),
                                   table.recipe_->has_assignments()}} {
      if (table.assembly_) open.emplace(*table.assembly_);
    }

    // The posture does not depend on the member that the lane had before.
    void set(const Replay& replay, std::size_t lane, const Binder& binder) {
      target.set(replay, lane);
      const GroupedSystem& recorded = *binder.table_.structure_;
      for (const Index c : recorded.static_coordinates) variant.posture[idx(c)] = recorded.start[idx(c)];
      for (const Index c : binder.from_guess_) variant.posture[idx(c)] = system->guess[idx(c)];
    }

    std::shared_ptr<System> system;
    Recipe::Target target;
    Variant variant;
    std::optional<OneMember> open;
    DriversWay way;               // see way_of()
    std::vector<double> at_laws;  // the guess of `open`, with the drivers at their laws
  };

  // It is that of all members unless the recipe has numbers of drivers.
  [[nodiscard]] const DriversWay& way_of(const Lane& lane) const {
    return table_.recipe_->has_drivers() ? lane.way : lanes_[0].way;
  }
  [[nodiscard]] bool is_another_way(const Lane& lane) const {
    if (table_.recipe_->has_laws()) return true;
    auto known = lane.way.written.begin();
    for (const DriverInput& in : lane.system->inputs) {
      for (const Number& value : in.written) {
        if (known == lane.way.written.end() || !same_bits(*known++, value)) return true;
      }
    }
    return false;
  }
  void find_way(Lane& lane) const {
    const System& s = *lane.system;
    const double time = table_.first_->time.start;
    DriversWay& to = lane.way;
    to.written.clear();
    for (const DriverInput& in : s.inputs) to.written.insert(to.written.end(), in.written.begin(), in.written.end());
    to.end = s.guess;
    to.exists = drive(s, time, to.end.data(), nullptr, nullptr).ok();
    if (!to.exists) return;
    to.way = way_to_laws(s, to.end, time);
    to.moves = is_moving(s, to.way);
    to.begin = to.end;
    if (to.moves) drive_by_values(s, to.way.from, to.begin);
  }

  // Puts the known coordinates where they are with these inputs.
  static void place(const System& s, const std::vector<double>& inputs, std::vector<double>& q) {
    for (const DriverInput& in : s.inputs) std::copy_n(inputs.begin() + in.first, in.count, q.begin() + in.first);
    for (const Assignment& a : s.assignments) q[idx(a.coordinate)] = form_value<double>(s, a.form, q);
  }

  // Equations between coordinates that are at rest. They are not solved in the lanes: such a coordinate is where its
  // guess is, if that is where it was assembled, or where it was at the recorded member.
  void find_static_equations(const GroupedSystem& structure) {
    const System& s = *structure.system;
    std::vector<std::uint8_t> is_static(s.coordinates.size(), 0);
    for (const Index c : structure.static_coordinates) {
      is_static[idx(c)] = 1;
      if (std::abs(structure.start[idx(c)] - s.guess[idx(c)]) <= kAsGuessed) from_guess_.push_back(c);
    }
    std::vector<Index> mentioned;
    for (Index e = 0; e < static_cast<Index>(s.equations.size()); ++e) {
      s.mentioned(e, mentioned);
      const bool rests = std::all_of(mentioned.begin(), mentioned.end(), [&](Index c) {
        return is_static[idx(c)] != 0 || s.coordinates[idx(c)].role != Role::unknown;
      });
      if (rests && std::any_of(mentioned.begin(), mentioned.end(), [&](Index c) { return is_static[idx(c)] != 0; })) {
        static_equations_.push_back(e);
      }
    }
  }

  // Sets the equations of a lane, and q to the posture as written. False if a law has no value at the start.
  [[nodiscard]] bool place_as_written(std::size_t i, std::vector<double>& q) {
    Lane& lane = lanes_[i];
    lane.open->target.set(replay_, i, table_.recipe_->wanted().size());
    const System& s = lane.open->system;
    const DriversWay& drivers = way_of(lane);
    if (!drivers.exists) return false;
    lane.at_laws = s.guess;
    place(s, drivers.end, lane.at_laws);
    q = lane.at_laws;
    if (drivers.moves) place(s, drivers.begin, q);
    return true;
  }

  // Gives the lane the posture at the end of its way, where the coordinates are at(coordinate). False if that is not
  // the start that prepare() would find, because drivers have not the values of their laws.
  template <class At>
  [[nodiscard]] bool arrive(Lane& lane, const At& at) {
    const System& s = lane.open->system;
    std::vector<double>& q = lane.at_laws;
    for (const WalkedPart& p : table_.assembly_->parts) {
      for (const Index u : p.unknowns) q[idx(u)] = at(u);
    }
    const auto is_right = [&](const DriverInput& in) { return has_its_value(s, in, q); };
    if (!std::all_of(s.inputs.begin(), s.inputs.end(), is_right)) return false;
    std::vector<double>& posture = lane.variant.posture;
    const bool rests = !table_.structure_->static_coordinates.empty();  // what they read is not solved again
    for (const Index c : near_) posture[idx(c)] = rests ? q[idx(c)] : std::round(q[idx(c)] / kGrain) * kGrain;
    for (const Index c : table_.structure_->static_coordinates) posture[idx(c)] = q[idx(c)];
    return true;
  }

  // The drivers of members on their way.
  class Drivers final : public WalkInLanes::Drivers {
   public:
    explicit Drivers(const Binder& binder) : binder_(binder) {}
    void move(std::size_t lane, double before, double share, std::vector<double>& q,
              std::vector<double>& strays) override {
      const Lane& l = binder_.lanes_[lane];
      const System& s = l.open->system;
      const WalkPath& way = binder_.way_of(l).way;
      set_strays(s, way, share - before, strays);
      if (share == 1) {
        q = l.at_laws;
        return;
      }
      DriverValues values = way.from;
      for (std::size_t i = 0; i < values.size(); ++i) {
        for (std::size_t k = 0; k < values[i].size(); ++k) values[i][k] += share * way.change[i][k];
      }
      drive_by_values(s, values, q);
    }
    [[nodiscard]] bool hold(std::size_t lane, const std::vector<double>& q) override {
      const Lane& l = binder_.lanes_[lane];
      return drivers_hold(l.open->system, binder_.way_of(l).way, q);
    }

   private:
    const Binder& binder_;
  };

  // Assembles those members side by side that can be; returns the others.
  std::vector<std::size_t> walk_together(const std::vector<std::size_t>& lanes) {
    for (const std::size_t l : lanes) {
      if (place_as_written(l, drawing_)) in_lanes_->set(l, lanes_[l].open->system, drawing_, way_of(lanes_[l]).moves);
    }
    Drivers drivers(*this);
    in_lanes_->run(drivers);
    std::vector<std::size_t> others;
    for (const std::size_t l : lanes) {
      const auto at = [&](Index c) { return in_lanes_->at(idx(c), l); };
      if (!in_lanes_->arrived(l) || !arrive(lanes_[l], at)) others.push_back(l);
    }
    return others;
  }

  static StepCode* code_for(const ValueTable& table, std::size_t lanes) {
    return table.count() >= kWorthCode * lanes ? table.first_->code.get() : nullptr;
  }

  // True if the posture as written is closed and the laws begin there. Equations at rest must hold to rounding, because
  // they are not solved again.
  [[nodiscard]] bool starts_as_written(Lane& lane) const {
    Variant& v = lane.variant;
    const System& s = *v.system;
    const DriversWay& drivers = way_of(lane);
    if (!drivers.exists) return false;
    place(s, drivers.end, v.posture);
    if (drivers.moves) return false;
    const auto holds = [&](Index e, double within) {
      return std::abs(residual<double>(s, e, v.posture)) <= within * residual_scale(s, e, v.posture);
    };
    for (const SolvedGroup& g : table_.structure_->groups) {
      if (!std::all_of(g.equations.begin(), g.equations.end(), [&](Index e) { return holds(e, kAsDrawn); }))
        return false;
    }
    return std::all_of(static_equations_.begin(), static_equations_.end(),
                       [&](Index e) { return holds(e, kSatisfied); });
  }

  // Frames of which all coordinates are computed.
  void find_frames(const GroupedSystem& structure) {
    const System& s = *structure.system;
    std::vector<std::uint8_t> computed(s.coordinates.size(), 0);
    for (std::size_t c = 0; c < computed.size(); ++c) computed[c] = s.coordinates[c].role != Role::unknown;
    for (const Index c : near_) computed[idx(c)] = 1;
    for (std::size_t f = 0; f < s.frames.size(); ++f) {
      const auto& items = s.frames[f].item;
      const bool all = std::all_of(std::begin(items), std::end(items), [&](Index item) {
        const auto& forms = s.items[idx(item)].form;
        return std::all_of(std::begin(forms), std::end(forms), [&](Index form) {
          const auto terms = s.form(form);
          return std::all_of(terms.begin(), terms.end(),
                             [&](const Term& t) { return computed[idx(t.coordinate)] != 0; });
        });
      });
      if (all) frames_.push_back(f);
    }
  }

  const ValueTable& table_;
  Replay replay_;
  std::vector<Index> near_;          // unknowns of the groups
  std::vector<std::size_t> frames_;  // indices into System::frames
  std::vector<Index> from_guess_;    // coordinates that begin at their guess
  std::vector<Index> static_equations_;
  std::unique_ptr<WalkInLanes> in_lanes_;  // null: each member walks alone
  std::vector<double> drawing_;            // of one lane, all coordinates
  std::vector<Lane> lanes_;
  std::vector<double> parameters_;       // lanes x varying columns
  std::vector<const double*> pointers_;  // lanes
};

ValueTable::ValueTable(const Scene& scene, std::vector<std::string> names, std::vector<double> values,
                       const PrepareOptions& options, AtRest at_rest)
    : scene_(scene), names_(std::move(names)), values_(std::move(values)), options_(options), at_rest_(at_rest) {
  if (names_.empty()) throw Error(Error::Kind::input, "a table of values needs at least one name");
  std::unordered_set<std::string_view> seen;
  for (const std::string& name : names_) {
    if (!seen.insert(name).second) throw Error(Error::Kind::input, in_quotes(name) + " names two columns of the table");
  }
  SceneSource::check_names(scene_, names_);
  check_size(values_.size());
  prepare_first();
  record();
}

void ValueTable::check_size(std::size_t values) const {
  if (values > 0 && values % names_.size() == 0) return;
  throw Error(Error::Kind::input, "a table with " + std::to_string(names_.size()) +
                                      " names needs as many values for each member, and at least one member; " +
                                      std::to_string(values) + " values are no whole rows");
}

Scene ValueTable::scene_at(std::size_t member, ParameterTape* tape) const {
  Parameters values;
  for (std::size_t k = 0; k < names_.size(); ++k) {
    const bool varies = std::find(varying_.begin(), varying_.end(), k) != varying_.end();
    const double value = row(member)[k];
    values.emplace(names_[k], tape != nullptr && varies ? tape->parameter(value) : Number(value));
  }
  return scene_.with_values(values);
}

KnownStart ValueTable::known_start() const {
  KnownStart start;
  start.at_rest = at_rest_;
  return start;
}

Preparation ValueTable::prepare(const Scene& scene) const {
  return prepare_at(scene, options_, known_start(), first_ ? &*first_ : nullptr);
}

// Tries members, then the scene as written, then the other members.
void ValueTable::prepare_first() {
  std::optional<Error> error;  // the last one
  const auto attempt = [&](const auto& make) {
    try {
      first_ = make();
    } catch (const Error& e) {
      if (e.kind() == Error::Kind::environment) throw;
      error.emplace(e);
    }
    return first_.has_value();
  };
  const std::size_t some = std::min(count(), kMostTried);
  for (first_member_ = 0; first_member_ < some; ++first_member_) {
    if (attempt([&] { return prepare(first_member_); })) return;
  }
  if (attempt([&] { return prepare(scene_); })) {
    first_member_ = 0;
    return;
  }
  const std::optional<Error> as_written = error;
  for (; first_member_ < count(); ++first_member_) {
    if (attempt([&] { return prepare(first_member_); })) return;
  }
  first_member_ = 0;
  if (as_written->kind() == Error::Kind::input) throw Error(*as_written);
}

std::vector<std::string> ValueTable::columns() const {
  return column_names(first_ ? *first_->structure->system : *group_equations(scene_).system);
}

// True if the columns that the computation does not vary have their recorded values.
bool ValueTable::has_constants(std::size_t member) const {
  const auto here = row(member);
  std::size_t v = 0;
  for (std::size_t k = 0; k < here.size(); ++k) {
    if (v < varying_.size() && varying_[v] == k) {
      ++v;
    } else if (!same_bits(here[k], recorded_[k])) {
      return false;
    }
  }
  return true;
}

void ValueTable::record() {
  depends_on_values_ = false;
  why_not_ = first_ ? assur::why_not(Path::table, needs_of(*first_->structure)) : "";
  if (!why_not_.empty()) return;
  recorded_.assign(row(0).begin(), row(0).end());
  varying_.clear();
  for (std::size_t k = 0; k < names_.size(); ++k) {
    for (std::size_t i = 1; i < count(); ++i) {
      if (same_bits(row(i)[k], recorded_[k])) continue;
      varying_.push_back(k);
      break;
    }
  }
  const std::size_t stride = std::max<std::size_t>(count() / kMostRecorded, 1);
  std::vector<std::size_t> members = {first_member_ < count() ? first_member_ : 0};
  for (std::size_t i = 0; i < count(); i += stride) {
    if (i != members[0]) members.push_back(i);
  }
  for (const std::size_t i : members) {
    if (!first_) break;
    if (record_at(i)) return;
    if (!why_not_.empty()) return;
  }
  recipe_.reset();
  depends_on_values_ = true;
  why_not_ = "no member was found from whose equations those of the others follow";
}

// False if this mechanism is not like the first one.
bool ValueTable::record_at(std::size_t member) {
  ParameterTape tape;
  try {
    const Tape::Recording recording(&tape);
    const Scene scene = scene_at(member, &tape);
    structure_ = structure_like(scene, options_, known_start(), *first_);
    if (!alike(*first_, *structure_, scene.time())) return false;
    record_assembly(scene, tape);
  } catch (const Error& e) {
    if (e.kind() == Error::Kind::environment) throw;
    return false;
  }
  why_not_ = tape.lost();
  recipe_.emplace(tape, *structure_->system);
  std::vector<Number> wanted = recipe_->wanted();
  if (assembly_) wanted.insert(wanted.end(), assembly_->recipe.wanted().begin(), assembly_->recipe.wanted().end());
  program_ = tape.program(wanted);
  return why_not_.empty();
}

void ValueTable::record_assembly(const Scene& scene, const Tape& tape) {
  assembly_.reset();
  const bool groups = structure_->formulation != Formulation::irreducible;
  System s = lower(std::make_shared<const Scene>(scene), options_.controlled, groups);
  std::vector<Index> unknowns, equations, mentioned;
  const auto is_unknown = [&](Index c) { return s.coordinates[idx(c)].role == Role::unknown; };
  for (Index c = 0; c < static_cast<Index>(s.coordinates.size()); ++c) {
    if (is_unknown(c)) unknowns.push_back(c);
  }
  for (Index e = 0; e < static_cast<Index>(s.equations.size()); ++e) {
    s.mentioned(e, mentioned);
    if (std::any_of(mentioned.begin(), mentioned.end(), is_unknown)) equations.push_back(e);
  }
  const Blocks blocks = decompose(s, equations, unknowns);
  Recipe recipe(tape, s);
  if (!blocks.square() || s.coordinates.size() != structure_->system->coordinates.size()) return;
  std::vector<WalkedPart> parts;
  for (Index b = 0; b < blocks.size(); ++b) {
    const auto own = blocks.equations_of(b), solved = blocks.unknowns_of(b);
    parts.push_back({{own.begin(), own.end()}, {solved.begin(), solved.end()}});
  }
  assembly_.emplace(Assembly{std::move(s), std::move(parts), std::move(recipe)});
}

std::unique_ptr<MemberBinder> ValueTable::binder(std::size_t lanes) const {
  return std::make_unique<Binder>(*this, lanes);
}

// Whether members can be bound does not depend on the order of tables, unless a column that did not vary now does.
bool ValueTable::take(std::vector<double> values) {
  check_size(values.size());
  values_ = std::move(values);
  if (recipe_ ? has_constants(0) : !depends_on_values_) return false;
  if (!first_) prepare_first();
  record();
  return true;
}

Ensemble::Ensemble(const Scene& scene, std::vector<std::string> names, std::vector<double> values,
                   const PrepareOptions& options, StepSettings settings)
    : Ensemble(std::make_unique<ValueTable>(
                   scene, std::move(names), std::move(values), options,
                   settings.iterations > 0 ? AtRest::left_out : AtRest::in_front),  // levels decide who takes them
               settings) {}

}  // namespace assur
