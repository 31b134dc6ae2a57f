#include "plan/check_plan.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "dispatch/together_rules.hpp"
#include "equations/outputs.hpp"
#include "equations/system.hpp"
#include "index.hpp"
#include "joints/gear.hpp"

namespace assur {
namespace {

constexpr int kLargestExponent = 1074;  // of the smallest double
constexpr int kLargestPower = 2;        // of length
constexpr Index kNever = -1;            // level of coordinates that no group computes

bool within(Index i, std::size_t size) { return i >= 0 && idx(i) < size; }
bool all_within(const std::vector<Index>& indices, std::size_t size) {
  return std::all_of(indices.begin(), indices.end(), [&](Index i) { return within(i, size); });
}

// True for starts of consecutive ranges in a list: they begin with 0, ascend, and end with the list's size.
bool are_starts(const std::vector<Index>& starts, std::size_t size) {
  return !starts.empty() && starts.front() == 0 && idx(starts.back()) == size &&
         std::is_sorted(starts.begin(), starts.end());
}

class PlanCheck {
 public:
  explicit PlanCheck(const Preparation& prepared)
      : prepared_(prepared), structure_(*prepared.structure), system_(*structure_.system) {}

  void run() {
    coordinates();
    forms();
    items();
    equations_of_system();
    measures();
    bounds();
    inputs();
    assignments();
    positive();
    gears();
    for (std::size_t c = 0; c < structure_.classes.size(); ++c) {
      part("classes", c);
      equations(structure_.classes[c], structure_.classes[c].n);
      blocks(structure_.classes[c]);
    }
    groups();
    watch();
    outputs();
    plan();
    time();
  }

 private:
  // Sets the place that the next requirements name.
  void part(const char* list, std::size_t i) {
    list_ = list;
    index_ = i;
  }
  void part(const char* name) { part(name, kWhole); }
  void require(bool fits, std::string_view what) const {
    if (fits) return;
    const std::string where = std::string(list_) + (index_ == kWhole ? "" : "/" + std::to_string(index_));
    throw Error(Error::Kind::input, {{where, std::string(what) + " is invalid; save the plan again"}}, "saved plan");
  }
  void require_power(int power) const { require(std::abs(power) <= kLargestPower, "the dimension"); }

  void coordinates() {
    part("system");
    require(system_.dimension == 2 || system_.dimension == 3, "the dimension");
    require(std::abs(system_.length_exponent) <= kLargestExponent, "the unit of length");
    const std::size_t size = system_.coordinates.size();
    require(size > 0 && system_.guess.size() == size && structure_.start.size() == size, "the number of coordinates");
    for (std::size_t c = 0; c < size; ++c) {
      part("coordinates", c);
      const Role role = system_.coordinates[c].role;
      require(c == 0 ? role == Role::one : role == Role::driven || role == Role::unknown, "the role");
      const Coordinate& of = system_.coordinates[c];
      require(of.item == -1 || within(of.item, system_.items.size()), "the item");
      require(-1 <= of.component && (of.component < system_.dimension || role == Role::driven), "the component");
      require_power(of.dimension);
    }
    known_.assign(size, 0);
    for (std::size_t c = 0; c < size; ++c) known_[c] = system_.coordinates[c].role != Role::unknown;
  }

  void forms() {
    part("forms");
    require(are_starts(system_.form_start, system_.terms.size()), "the starts of forms");
    forms_ = idx(system_.forms());
    for (std::size_t t = 0; t < system_.terms.size(); ++t) {
      part("terms", t);
      require(within(system_.terms[t].coordinate, known_.size()), "the coordinate");
      require(within(system_.terms[t].constant, system_.constants.size()), "the constant");
    }
  }

  void items() {
    for (std::size_t i = 0; i < system_.items.size(); ++i) {
      part("items", i);
      const Item& item = system_.items[i];
      require(item.components == 1 || item.components == system_.dimension, "the number of components");
      for (int k = 0; k < item.components; ++k) require(within(item.form[k], forms_), "the form");
      require_power(item.dimension);
    }
  }

  void equations_of_system() {
    const auto is_form = [&](Index f) { return within(f, forms_); };
    for (std::size_t p = 0; p < system_.products.size(); ++p) {
      part("products", p);
      const Product& product = system_.products[p];
      require(is_form(product.a) && is_form(product.b), "the form");
      require(within(product.constant, system_.constants.size()), "the constant");
    }
    for (std::size_t i = 0; i < system_.equations.size(); ++i) {
      part("equations", i);
      const Equation& e = system_.equations[i];
      require(0 <= e.products_begin && e.products_begin <= e.products_end &&
                  idx(e.products_end) <= system_.products.size() && (e.linear == -1 || is_form(e.linear)),
              "the terms");
      require(within(e.source, system_.sources.size()), "the source");
      require(e.callback == -1 || within(e.callback, system_.callbacks.size()), "the gear");
    }
    part("checks");
    require(all_within(structure_.checks, system_.equations.size()), "an equation");
  }

  void measures() {
    const int d = system_.dimension;
    for (std::size_t i = 0; i < system_.measures.size(); ++i) {
      part("measures", i);
      const MeasureForms& m = system_.measures[i];
      require(all_within(m.forms, forms_), "the form");
      require_power(m.dimension);
      const auto takes = [&](MeasureForms::Kind kind, int forms) {
        return m.kind == kind && std::ssize(m.forms) == forms;
      };
      using Kind = MeasureForms::Kind;
      require(
          takes(Kind::form, 1) || takes(Kind::distance, d) || takes(Kind::absolute_angle, 2) ||
              takes(Kind::signed_angle, d == 2 ? 4 : 9) || (d == 3 && takes(Kind::unsigned_angle, 6)) ||
              (d == 3 && (is_quaternion(m.kind) || (is_turn(m.kind) && m.kind <= Kind::turn_z)) && takes(m.kind, 9)) ||
              takes(Kind::sum, 0) || takes(Kind::sum_of_angles, 0),
          "the kind of measure");
      require(m.is_sum() || m.terms.empty(), "the terms");
      for (const MeasureForms::SumTerm& t : m.terms) {
        require(within(t.measure, system_.measures.size()) && !system_.measures[idx(t.measure)].is_sum(), "the terms");
      }
    }
  }

  void bounds() {
    for (std::size_t i = 0; i < system_.bounds.size(); ++i) {
      part("bounds", i);
      const Bound& b = system_.bounds[i];
      require(within(b.measure, system_.measures.size()) && !is_turn(system_.measures[idx(b.measure)].kind),
              "the measure");
      require(
          b.input == -1 || (within(b.input, system_.inputs.size()) && system_.inputs[idx(b.input)].laws.size() == 1),
          "the driver");
    }
  }

  void inputs() {
    using Kind = DriverInput::Kind;
    const Index d = system_.dimension;
    for (std::size_t i = 0; i < system_.inputs.size(); ++i) {
      part("inputs", i);
      const DriverInput& in = system_.inputs[i];
      require(within(in.driver, system_.drivers.size()), "the driver");
      require_power(in.dimension);
      const auto takes = [&](Kind kind, Index coordinates, Index laws) {
        return in.kind == kind && in.count == coordinates && std::ssize(in.laws) == laws;
      };
      require(takes(Kind::scalar, 1, 1) || takes(Kind::direction, 2, 1) || takes(Kind::frame, d, d) ||
                  (d == 2 ? takes(Kind::frame, 4, 3) : takes(Kind::frame, 12, 6)),
              "the kind of driver");
      for (Index k = 0; k < in.count; ++k) require(in.first >= 0 && is_driven(in.first, k), "the coordinate");
    }
  }
  [[nodiscard]] bool is_driven(Index first, Index k) const {
    const std::size_t c = idx(first) + idx(k);
    return c < known_.size() && system_.coordinates[c].role == Role::driven;
  }

  void assignments() {
    for (std::size_t i = 0; i < system_.assignments.size(); ++i) {
      part("assignments", i);
      const Assignment& a = system_.assignments[i];
      require(a.coordinate >= 0 && is_driven(a.coordinate, 0), "the coordinate");
      require(within(a.form, forms_), "the form");
      for (const Term& t : system_.form(a.form)) require(known_[idx(t.coordinate)] != 0, "the form");
    }
  }

  void positive() {
    for (std::size_t i = 0; i < system_.positive.size(); ++i) {
      part("positive", i);
      const Positive& p = system_.positive[i];
      require(within(p.coordinate, known_.size()) && known_[idx(p.coordinate)] == 0, "the coordinate");
      require(within(p.driver, system_.drivers.size()), "the driver");
      require_power(p.dimension);
    }
  }

  void gears() {
    part("system");
    require(1 <= system_.teeth && system_.teeth <= kMostTeeth, "the number of teeth");
    for (std::size_t i = 0; i < system_.callbacks.size(); ++i) {
      part("gears", i);
      const CallbackBlock& block = system_.callbacks[i];
      std::size_t arguments = 0;
      const GearNumbers numbers = numbers_of(*block.callback).value_or(GearNumbers{});
      for (const GearNumbers::Side& side : numbers.sides) {
        require(side.dimension == system_.dimension || (!side.is_angle && side.dimension == 2), "the dimension");
        arguments += side.arguments();
      }
      require(arguments <= kMostGearArguments && block.coordinates.size() == arguments &&
                  block.unit.size() == arguments && all_within(block.coordinates, forms_),
              "the arguments");
      require(1 <= block.callback->teeth && block.callback->teeth <= system_.teeth, "the number of teeth");
    }
  }

  // ---- structure

  // The program of a class reads and writes nothing outside its lists.
  void equations(const GroupClass& c, Index unknowns) {
    require(unknowns >= 0 && c.inputs >= 0 && c.constants >= 0 && c.input_moves.size() == idx(c.inputs),
            "the number of inputs");
    const std::size_t count = c.equations.size(), nonzeros = c.pattern.row.size();
    require(c.pattern.n == unknowns && c.pattern.column_start.size() == idx(unknowns) + 1 &&
                are_starts(c.pattern.column_start, nonzeros) && all_within(c.pattern.row, count) &&
                c.entries.size() == nonzeros,
            "the pattern");
    for (const GroupClass::Coefficient& k : c.coefficients) {
      require(std::all_of(std::begin(k.constant), std::end(k.constant),
                          [&](Index i) { return i == -1 || within(i, idx(c.constants)); }),
              "a coefficient");
    }
    const std::size_t registers = idx(c.registers());
    const auto is_coefficient = [&](Index k) { return within(k, c.coefficients.size()); };
    const auto are_operands = [&](const std::vector<GroupClass::Operand>& list) {
      return std::all_of(list.begin(), list.end(), [&](const GroupClass::Operand& o) {
        return is_coefficient(o.coefficient) && within(o.reg, registers);
      });
    };
    const auto are_products = [&](const std::vector<GroupClass::Product>& list) {
      return std::all_of(list.begin(), list.end(), [&](const GroupClass::Product& p) {
        return is_coefficient(p.coefficient) && within(p.a, registers) && within(p.b, registers);
      });
    };
    const auto is_range = [](const GroupClass::Range& r, std::size_t size) {
      return 0 <= r.begin && r.begin <= r.end && idx(r.end) <= size;
    };
    for (std::size_t f = 0; f < c.forms.size(); ++f) {
      const GroupClass::Form& form = c.forms[f];
      require(idx(form.reg) == idx(c.one()) + 1 + f && is_range({form.begin, form.moving}, c.operands.size()) &&
                  is_range({form.moving, form.unknowns}, c.operands.size()) &&
                  is_range({form.unknowns, form.end}, c.operands.size()),
              "a form");
      require(std::all_of(c.operands.begin() + form.begin, c.operands.begin() + form.end,
                          [&](const GroupClass::Operand& o) { return o.reg <= c.one(); }),
              "a form");
    }
    require(are_operands(c.operands) && are_operands(c.linear) && are_operands(c.input_linear) &&
                are_operands(c.entry_operands),
            "a sum");
    require(are_products(c.products) && are_products(c.input_products) && are_products(c.curvature), "a product");
    for (const GroupClass::Range& r : c.entries) require(is_range(r, c.entry_operands.size()), "an entry");
    for (const GroupClass::Equation& e : c.equations) {
      require(is_range(e.linear, c.linear.size()) && is_range(e.products, c.products.size()) &&
                  is_range(e.input_linear, c.input_linear.size()) &&
                  is_range(e.input_products, c.input_products.size()) && is_range(e.curvature, c.curvature.size()) &&
                  is_range({e.linear.begin, e.factors}, c.linear.size()) && e.factors <= e.linear.end &&
                  (e.gear == -1 || within(e.gear, c.gears.size())),
              "an equation");
    }
    gears(c, registers);
  }

  void gears(const GroupClass& c, std::size_t registers) {
    Index arguments = 0, angles = 0;
    for (const GroupClass::Gear& gear : c.gears) {
      require(gear.first == arguments && gear.first_angle == angles && gear.unit.size() == gear.arguments.size(),
              "a gear");
      std::size_t own = 0;
      for (const GroupClass::Gear::Side& side : gear.sides) {
        require(side.arguments == 1 || side.arguments == (system_.dimension == 2 ? 4 : 9), "a gear");
        own += idx(side.arguments);
        angles += side.arguments > 1 ? 1 : 0;
      }
      require(
          own == gear.arguments.size() &&
              std::all_of(gear.arguments.begin(), gear.arguments.end(),
                          [&](Index a) { return a >= 0 ? within(a, registers) : within(~a, c.coefficients.size()); }),
          "a gear");
      arguments += static_cast<Index>(own);
    }
    require(arguments == c.gear_arguments && angles == c.gear_angles, "the number of arguments of gears");
    require(std::is_sorted(c.gear_entries.begin(), c.gear_entries.end(),
                           [](const auto& a, const auto& b) { return a.nonzero < b.nonzero; }),
            "the entries of gears");
    for (const GroupClass::GearEntry& e : c.gear_entries) {
      require(within(e.nonzero, c.pattern.row.size()) && within(e.gear, c.gears.size()) &&
                  within(e.argument, c.gears[idx(e.gear)].arguments.size()) &&
                  within(e.coefficient, c.coefficients.size()),
              "the entries of gears");
    }
  }

  // Checks that equations and unknowns are equally many, in the group and in each irreducible block.
  void blocks(const GroupClass& c) {
    const std::size_t n = idx(c.n);
    require(n > 0 && c.equations.size() == n && c.unknown_block.size() == n && c.equation_block.size() == n,
            "the number of equations");
    require(c.blocks > 0 && c.blocks <= c.n && all_within(c.unknown_block, idx(c.blocks)) &&
                all_within(c.equation_block, idx(c.blocks)),
            "the blocks");
    std::vector<Index> unknowns(idx(c.blocks), 0), equations(idx(c.blocks), 0);
    for (const Index b : c.unknown_block) ++unknowns[idx(b)];
    for (const Index b : c.equation_block) ++equations[idx(b)];
    require(unknowns == equations && std::count(unknowns.begin(), unknowns.end(), 0) == 0, "the blocks");
    require(0 <= c.derivatives && c.derivatives <= 2 && 0 <= c.first_wanted && c.first_wanted <= c.n,
            "the wanted derivatives");
  }

  // level_: the level on which each coordinate is computed; known coordinates come before all levels.
  void groups() {
    level_.assign(known_.size(), kNever);
    std::vector<std::uint8_t> used(structure_.classes.size(), 0);
    part("static");
    require(all_within(structure_.static_coordinates, known_.size()), "a coordinate");
    for (const Index c : structure_.static_coordinates) {
      require(known_[idx(c)] == 0, "a coordinate");
      known_[idx(c)] = 1;
    }
    Index before = 0;
    for (std::size_t g = 0; g < structure_.groups.size(); ++g) {
      part("groups", g);
      const SolvedGroup& group = structure_.groups[g];
      require(group.level >= before && group.level < structure_.levels, "the level");
      before = group.level;
      require(within(group.group_class, structure_.classes.size()), "the class");
      used[idx(group.group_class)] = 1;
      const GroupClass& c = structure_.classes[idx(group.group_class)];
      require(group.unknowns.size() == idx(c.n) && all_within(group.unknowns, known_.size()), "the unknowns");
      require(group.equations.size() == idx(c.n) && all_within(group.equations, system_.equations.size()),
              "the equations");
      for (const Index u : group.unknowns) {
        require(known_[idx(u)] == 0 && level_[idx(u)] == kNever, "the unknowns");
        level_[idx(u)] = group.level;
      }
      slots(group, c);
      for (const Index i : group.inputs) {
        require(known_[idx(i)] != 0 || (level_[idx(i)] != kNever && level_[idx(i)] < group.level), "the inputs");
      }
    }
    part("classes");
    require(std::count(used.begin(), used.end(), 0) == 0, "a class without groups");
  }

  void slots(const SolvedGroup& group, const GroupClass& c) const {
    require(group.inputs.size() == idx(c.inputs) && all_within(group.inputs, known_.size()), "the inputs");
    require(group.constants.size() == idx(c.constants) && all_within(group.constants, system_.constants.size()),
            "the constants");
  }

  [[nodiscard]] bool is_computed(Index coordinate) const {
    return known_[idx(coordinate)] != 0 || level_[idx(coordinate)] != kNever;
  }

  void watch() {
    part("watch");
    const SolvedGroup& group = structure_.watch;
    const GroupClass& c = structure_.watch_class;
    require(structure_.watched.size() == c.equations.size(), "the number of names");
    if (c.equations.empty() && group.inputs.empty()) return;
    require(c.n == 0, "the number of unknowns");
    equations(c, 0);
    slots(group, c);
    require(std::all_of(group.inputs.begin(), group.inputs.end(), [&](Index i) { return is_computed(i); }),
            "the inputs");
  }

  void outputs() {
    part("outputs");
    for (const std::vector<Output>& list : {wanted_outputs(system_), limited_outputs(system_)}) {
      for (const Output& output : list) {
        for (const OutputPart& p : output.parts()) {
          for (const Index f : p.forms) {
            for (const Term& t : system_.form(f)) require(is_computed(t.coordinate), "an output");
          }
        }
      }
    }
  }

  // ---- plan

  void plan() {
    const Plan& plan = prepared_.plan;
    part("plan");
    require(plan.run.formulation <= Formulation::irreducible && structure_.formulation == plan.run.formulation,
            "the formulation");
    require(plan.run.threads > 0 && plan.run.chunks > 0, "the number of threads or chunks");
    // The text of a strategy bounds the orders of `past` and `hermite`, so a valid text is enough.
    Strategy all;
    all.solver.lanes = plan.lanes;
    all.run.predictor = plan.run.predictor;
    require(plan.run.predictor.kind != Predictor::Kind::automatic && has_text(all), "the predictor or the lanes");
    require(plan.level_threads.empty() || plan.level_threads.size() == idx(structure_.levels), "the threads of levels");
    for (const Index p : plan.level_threads) require(0 < p && p <= plan.run.threads, "the threads of a level");
    require(plan.choices.size() == structure_.classes.size(), "the number of choices");
    require(!plan.run.together || why_not_together(structure_).empty(), "the option together");
    for (std::size_t c = 0; c < plan.choices.size(); ++c) {
      part("choices", c);
      require(plan.choices[c].group_class == static_cast<Index>(c), "the class");
      require(plan.choices[c].origin <= Origin::prior, "the origin");
      require(!plan.run.together || why_not_together(plan.strategy(plan.choices[c])).empty(), "the option together");
    }
  }
  static bool has_text(const Strategy& strategy) {
    try {
      return parse_strategy(to_string(strategy)) == strategy;
    } catch (const Error&) {
      return false;
    }
  }

  void time() {
    part("time");
    const TimeGrid& t = prepared_.time;
    require(t.step >= 0 && t.end >= t.start && (t.step > 0 ? (t.end - t.start) / t.step < 0x1p53 : true),
            "the time grid");
  }

  static constexpr std::size_t kWhole = static_cast<std::size_t>(-1);

  const Preparation& prepared_;
  const GroupedSystem& structure_;
  const System& system_;
  const char* list_ = "";
  std::size_t index_ = kWhole;
  std::size_t forms_ = 0;
  std::vector<std::uint8_t> known_;  // coordinates: 1 if known before the first group
  std::vector<Index> level_;         // coordinates: level of the group that solves it
};

}  // namespace

void check_plan(const Preparation& prepared) { PlanCheck(prepared).run(); }

}  // namespace assur
