// The fields of a saved plan in the order of the file, for writing and reading. Parts of system and structure that no
// simulator reads are left out.
#pragma once

#include <string>
#include <vector>

#include "assur/strategy.hpp"
#include "equations/system.hpp"
#include "joints/gear.hpp"
#include "plan/plan_text.hpp"
#include "plan/preparation.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// ---- laws and strategies, whose own functions check them

// Function parts have no text, and are refused before this call.
void fields(PlanWriter& write, const Law& law);
void fields(PlanReader& read, Law& law);

inline void fields(PlanWriter& write, const Strategy& strategy) { write(to_string(strategy)); }
inline void fields(PlanReader& read, Strategy& strategy) {
  std::string text;
  read(text);
  strategy = parse_strategy(text);
}

inline void fields(auto& a, Either<Harmonic> auto& h) { a(h.amplitude, h.frequency, h.phase); }
inline void fields(auto& a, Either<TimeGrid> auto& t) { a(t.start, t.end, t.step); }

// ---- system

inline void fields(auto& a, Either<Coordinate> auto& c) { a(c.role, c.moving, c.item, c.component, c.dimension); }
inline void fields(auto& a, Either<Term> auto& t) { a(t.coordinate, t.constant); }
inline void fields(auto& a, Either<Product> auto& p) { a(p.a, p.b, p.constant); }
inline void fields(auto& a, Either<Equation> auto& e) {
  a(e.products_begin, e.products_end, e.linear, e.source, e.callback);  // a gear has one row
}
inline void fields(auto& a, Either<Source> auto& s) { a(s.name); }
inline void fields(auto& a, Either<Assignment> auto& x) { a(x.coordinate, x.form); }
inline void fields(auto& a, Either<Item> auto& i) {
  a(i.name, i.components, i.form[0], i.form[1], i.form[2], i.dimension, i.hidden, i.fixed);
}
inline void fields(auto& a, Either<MeasureForms::SumTerm> auto& t) { a(t.measure, t.factor); }
inline void fields(auto& a, Either<MeasureForms> auto& m) {
  a(m.name, m.kind, m.forms, m.dimension, m.terms, m.constant);
}
inline void fields(auto& a, Either<Bound> auto& b) { a(b.measure, b.value, b.is_max, b.ends, b.input); }
inline void fields(auto& a, Either<DriverInput> auto& i) {
  a(i.driver, i.kind, i.first, i.count, i.dimension, i.must_not_vanish, i.laws, i.zero);
}
inline void fields(auto& a, Either<Positive> auto& p) { a(p.coordinate, p.driver, p.dimension); }
inline void fields(auto& a, Either<System> auto& s) {
  a.label("system", s.dimension, s.length_exponent);
  a.label("coordinates", s.coordinates);
  a.label("guess", s.guess);
  a.label("constants", s.constants);
  a.label("forms", s.form_start);
  a.label("terms", s.terms);
  a.label("products", s.products);
  a.label("equations", s.equations);
  a.label("sources", s.sources);
  a.label("assignments", s.assignments);
  a.label("items", s.items);
  a.label("measures", s.measures);
  a.label("bounds", s.bounds);
  a.label("outputs", s.outputs);
  a.label("drivers", s.drivers);
  a.label("inputs", s.inputs);
  a.label("positive", s.positive);
  a.label("teeth", s.teeth);
}

// A gear, the only equation with functions that a plan can hold.
struct SavedGear {
  std::vector<Index> coordinates;
  std::vector<double> unit;
  GearNumbers numbers;
};
inline void fields(auto& a, Either<GearNumbers::Side> auto& s) { a(s.is_angle, s.dimension, s.factor); }
inline void fields(auto& a, Either<SavedGear> auto& g) {
  a(g.coordinates, g.unit, g.numbers.sides, g.numbers.is_periodic, g.numbers.teeth);
}

// ---- structure

inline void fields(auto& a, Either<Pattern> auto& p) { a(p.n, p.column_start, p.row); }
inline void fields(auto& a, Either<GroupClass::Coefficient> auto& k) {
  a(k.literal, k.constant[0], k.constant[1], k.constant[2]);
}
inline void fields(auto& a, Either<GroupClass::Operand> auto& o) { a(o.coefficient, o.reg); }
inline void fields(auto& a, Either<GroupClass::Product> auto& p) { a(p.coefficient, p.a, p.b); }
inline void fields(auto& a, Either<GroupClass::Range> auto& r) { a(r.begin, r.end); }
inline void fields(auto& a, Either<GroupClass::Form> auto& f) { a(f.reg, f.begin, f.moving, f.unknowns, f.end); }
inline void fields(auto& a, Either<GroupClass::Equation> auto& e) {
  a(e.linear, e.products, e.input_linear, e.input_products, e.curvature, e.factors, e.gear);
}
inline void fields(auto& a, Either<GroupClass::Gear::Side> auto& s) { a(s.factor, s.arguments); }
inline void fields(auto& a, Either<GroupClass::Gear> auto& g) {
  a(g.sides, g.is_periodic, g.unit, g.arguments, g.first, g.first_angle);
}
inline void fields(auto& a, Either<GroupClass::GearEntry> auto& e) { a(e.nonzero, e.gear, e.argument, e.coefficient); }
inline void fields(auto& a, Either<GroupClass> auto& c) {
  a(c.n, c.inputs, c.constants, c.blocks, c.derivatives, c.first_wanted);
  a.label("input_moves", c.input_moves);
  a.label("blocks", c.unknown_block, c.equation_block);
  a.label("pattern", c.pattern);
  a.label("coefficients", c.coefficients);
  a.label("forms", c.forms, c.operands);
  a.label("equations", c.equations);
  a.label("sums", c.linear, c.input_linear);
  a.label("products", c.products, c.input_products, c.curvature);
  a.label("entries", c.entries, c.entry_operands);
  a.label("gears", c.gear_arguments, c.gear_angles, c.gears, c.gear_entries);  // the only callbacks
}
inline void fields(auto& a, Either<SolvedGroup> auto& g) {
  a(g.name, g.of, g.level, g.group_class, g.derivatives, g.wanted_derivatives);
  a(g.unknowns, g.equations, g.inputs, g.constants);
  if constexpr (std::remove_reference_t<decltype(a)>::kReads) g.n = static_cast<std::int32_t>(g.unknowns.size());
}
inline void fields(auto& a, Either<Watched> auto& w) { a(w.name, w.is_length); }
inline void fields(auto& a, Either<GroupedSystem> auto& s) {
  a.label("structure", s.formulation, s.levels);
  a.label("classes", s.classes);
  a.label("groups", s.groups);
  a.label("watch", s.watch, s.watch_class);
  a.label("watched", s.watched);
  a.label("checks", s.checks);
  a.label("static", s.static_coordinates);
  a.label("start", s.start);
}

// ---- plan

// Without Shape::one_program, which only predicts times: a saved plan has them.
inline void fields(auto& a, Either<Shape> auto& s) {
  a(s.n, s.nnz, s.groups, s.rhs, s.fill, s.operations, s.depth, s.terms, s.pattern);
}
inline void fields(auto& a, Either<Plan::Choice> auto& c) {
  Strategy text{{.threads = c.threads}, c.solver};  // settings for all classes are in Plan::run
  a(c.group_class, text, c.expected_seconds, c.origin, c.reason, c.shape);
  if constexpr (std::remove_reference_t<decltype(a)>::kReads) {
    c.solver = text.solver;
    c.threads = text.run.threads;
  }
}
inline void fields(auto& a, Either<Plan> auto& p) {
  a.label("plan", p.run.formulation, p.run.predictor.kind, p.run.predictor.order, p.lanes, p.run.chunks, p.run.threads,
          p.run.together);
  a.label("level_threads", p.level_threads);
  a.label("accuracy", p.accuracy);
  a.label("expected", p.expected_seconds, p.meeting_seconds, p.reason);
  a.label("choices", p.choices);
}

// The whole file.
inline void fields(auto& a, Either<Preparation> auto& prepared, Either<System> auto& system,
                   Either<std::vector<SavedGear>> auto& gears, Either<GroupedSystem> auto& structure) {
  a.label("scene", prepared.name);
  a.label("time", prepared.time, prepared.start_time);
  a.label("controlled", prepared.controlled);
  fields(a, prepared.plan);
  fields(a, structure);
  fields(a, system);
  a.label("gears", gears);
}

}  // namespace assur
