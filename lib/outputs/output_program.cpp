#include "outputs/output_program.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <utility>

#include "evaluation/angles-inl.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "outputs/dual.hpp"
#include "program/step_graph.hpp"

namespace assur {
namespace {

constexpr std::size_t kLeastInRow = 4;    // fewer forms are evaluated one by one
constexpr std::ptrdiff_t kOpenRows = 16;  // rows that wait for their next form

template <class T>
std::span<const T> share(const std::vector<T>& list, std::size_t part, std::size_t parts) {
  if (parts == 1) return list;
  const std::size_t begin = list.size() * part / parts, end = list.size() * (part + 1) / parts;
  return std::span(list).subspan(begin, end - begin);
}

}  // namespace

void OutputProgram::bind(const System& s, std::span<const std::int32_t> address, const std::vector<Output>& outputs) {
  dimension_ = s.dimension;
  one_ = address[kOne];
  rows_.clear();
  row_terms_.clear();
  sums_.clear();
  sum_terms_.clear();
  terms_.clear();
  form_start_.assign(1, 0);
  parts_.clear();
  angles_.clear();
  totals_.clear();
  total_terms_.clear();
  of_sums_.clear();
  of_forms_.clear();
  std::int32_t next = 0;                                               // column
  std::map<std::pair<std::string_view, int>, std::int32_t> column_of;  // of measures, if there are sums
  const bool has_sums =
      std::any_of(s.measures.begin(), s.measures.end(), [](const MeasureForms& m) { return m.is_sum(); });
  for (const Output& o : outputs) {
    const auto parts = static_cast<std::int32_t>(o.part_count);
    std::int32_t first[3];  // column of the first part
    for (int d = 0; d < 3; ++d) {
      first[d] = o.wanted[d] ? next : -1;
      if (o.wanted[d]) next += parts;
      if (has_sums && o.wanted[d] && o.component < 0) column_of[{o.name, d}] = first[d];
    }
    for (int d = 0; o.sum != nullptr && d < 3; ++d) {
      if (!o.wanted[d]) continue;
      const auto begin = static_cast<std::int32_t>(total_terms_.size());
      for (const auto& [measure, factor] : o.sum->terms) {
        total_terms_.push_back({column_of.at({s.measures[static_cast<std::size_t>(measure)].name, d}), factor.value()});
      }
      totals_.push_back(
          {begin, static_cast<std::int32_t>(total_terms_.size()), first[d], d == 0 ? o.sum->constant.value() : 0});
    }
    if (o.sum != nullptr) continue;
    for (std::int32_t k = 0; k < parts; ++k) {
      const auto column = [&](int d) { return first[d] < 0 ? -1 : first[d] + k; };
      add(s, address, o.all_parts[static_cast<std::size_t>(k)], {column(0), column(1), column(2)});
    }
  }
  columns_ = idx(next);
}

void OutputProgram::add(const System& s, std::span<const std::int32_t> address, const OutputPart& m,
                        const std::array<std::int32_t, 3>& column) {
  const auto term_at = [&](const Term& t) {
    return TermAt{address[static_cast<std::size_t>(t.coordinate)], s.constants[static_cast<std::size_t>(t.constant)]};
  };
  const double unit = s.unit(m.dimension);
  if (m.kind == MeasureForms::Kind::form) {
    const auto begin = static_cast<std::int32_t>(sum_terms_.size());
    for (const Term& t : s.form(m.forms[0])) {
      sum_terms_.push_back(term_at(t));
      sum_terms_.back().factor *= unit;  // a power of two
    }
    sums_.push_back({begin, static_cast<std::int32_t>(sum_terms_.size()), column});
    of_sums_.push_back({m.forms[0], unit});
    return;
  }
  Measured part{m.kind, static_cast<std::int32_t>(form_start_.size()) - 1, 0, unit, column};
  for (const Index f : m.forms) {
    for (const Term& t : s.form(f)) terms_.push_back(term_at(t));
    form_start_.push_back(static_cast<std::int32_t>(terms_.size()));
    of_forms_.push_back(f);
  }
  part.forms_end = static_cast<std::int32_t>(form_start_.size()) - 1;
  const bool is_signed = part.is_signed_angle();
  if (is_signed) part.arm = add_arm(part);
  if (is_signed && column[0] >= 0) {
    part.angle = static_cast<std::int32_t>(angles_.size());
    angles_.push_back(parts_.size());
  }
  parts_.push_back(part);
}

bool OutputProgram::renew(const System& s) {
  if (!rows_.empty() || !totals_.empty()) return false;
  const auto renew_terms = [&](Index form, double unit, TermAt* to) {
    for (const Term& t : s.form(form)) (to++)->factor = s.constants[idx(t.constant)] * unit;
  };
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    renew_terms(of_sums_[i].form, of_sums_[i].unit, sum_terms_.data() + sums_[i].begin);
  }
  for (std::size_t f = 0; f < of_forms_.size(); ++f) {
    if (of_forms_[f] >= 0) renew_terms(of_forms_[f], 1, terms_.data() + form_start_[f]);
  }
  return std::all_of(parts_.begin(), parts_.end(), [this](const Measured& p) { return renew_arm(p); });
}

// An output with all derivatives that is linear in coordinates.
struct OutputProgram::Form {
  std::size_t number;  // among sums_
  std::int32_t column, step;
  std::int32_t first;  // address of the first coordinate
  std::vector<TermAt> terms;
};

// Forms whose terms read neighbouring numbers.
struct OutputProgram::Neighbours {
  std::vector<const Form*> forms;
  std::vector<std::int32_t> apart;  // terms: from one form to the next; 0 to 3

  // Adds the form if it is the next one.
  bool take(const Form& form) {
    const Form& last = *forms.back();
    if (forms.size() == kFormLanes || form.terms.size() != last.terms.size() || form.step != last.step) return false;
    std::vector<std::int32_t> steps;
    for (std::size_t t = 0; t < form.terms.size(); ++t) {
      steps.push_back(form.terms[t].address - last.terms[t].address);
      if (steps.back() < 0 || steps.back() > 3) return false;
    }
    if (forms.size() > 1 && steps != apart) return false;
    if (forms.size() == 1 && steps == std::vector{0}) return false;  // the same coordinate twice
    apart = std::move(steps);
    forms.push_back(&form);
    return true;
  }
  // False if there are too few forms, or if a vector would end behind the state.
  [[nodiscard]] bool is_row(std::size_t size) const {
    if (forms.size() < kLeastInRow) return false;
    for (std::size_t t = 0; t < apart.size(); ++t) {
      if (idx(forms[0]->terms[t].address + kFormLanes * apart[t]) > size) return false;
    }
    return true;
  }
};

void OutputProgram::find_rows(std::size_t size) {
  std::vector<Form> forms;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    const Sum& s = sums_[i];
    const auto terms = std::span(sum_terms_).subspan(idx(s.begin), idx(s.end - s.begin));
    const auto first = std::find_if(terms.begin(), terms.end(), [&](const TermAt& t) { return t.address != one_; });
    if (first == terms.end() || *std::min_element(s.column.begin(), s.column.end()) < 0) continue;
    forms.push_back({i, s.column[0], s.column[1] - s.column[0], first->address, {terms.begin(), terms.end()}});
  }
  std::stable_sort(forms.begin(), forms.end(), [](const Form& a, const Form& b) { return a.first < b.first; });
  std::vector<Neighbours> all;
  for (const Form& form : forms) {
    const auto oldest = std::ssize(all) < kOpenRows ? all.begin() : all.end() - kOpenRows;
    if (std::none_of(oldest, all.end(), [&](Neighbours& n) { return n.take(form); })) all.push_back({{&form}, {}});
  }
  std::vector<std::uint8_t> in_row(sums_.size(), 0);
  for (const Neighbours& n : all) {
    if (!n.is_row(size)) continue;
    add_row(n);
    for (const Form* f : n.forms) in_row[f->number] = 1;
  }
  std::erase_if(sums_, [&](const Sum& s) { return in_row[static_cast<std::size_t>(&s - sums_.data())] != 0; });
}

void OutputProgram::add_row(const Neighbours& n) {
  FormRow row{};
  row.begin = static_cast<std::int32_t>(row_terms_.size());
  row.count = static_cast<std::int32_t>(n.forms.size());
  row.step = n.forms[0]->step;
  for (std::size_t t = 0; t < n.apart.size(); ++t) {
    using Kind = InputRow::Kind;
    static constexpr Kind kKinds[] = {Kind::same, Kind::consecutive, Kind::every_second, Kind::every_third};
    FormTerm term{{n.forms[0]->terms[t].address, kKinds[n.apart[t]]}, {}};
    for (std::size_t l = 0; l < n.forms.size(); ++l) term.factor[l] = n.forms[l]->terms[t].factor;
    row_terms_.push_back(term);
  }
  row.end = static_cast<std::int32_t>(row_terms_.size());
  for (std::size_t l = 0; l < n.forms.size(); ++l) row.column[l] = n.forms[l]->column;
  rows_.push_back(row);
}

// Values of which outputs consist.
class OutputProgram::StepWriter {
 public:
  StepWriter(const OutputProgram& of, Numbers numbers) : of_(of), side_by_side_(numbers == Numbers::loads) {}

  [[nodiscard]] StepProgram finish() const { return {{graph_.phase()}, {}}; }
  [[nodiscard]] Value load(Memory memory, std::size_t index) { return graph_.load(own(memory, index)); }
  void store(Memory memory, std::size_t index, const Value& value) { graph_.store(own(memory, index), value); }
  void put(std::int32_t column, const Value& value) {
    if (column >= 0) store(Memory::outputs, idx(column), value);
  }

  // The state, or its changes, by derivative.
  using Source = std::array<Memory, 3>;
  static constexpr Source kState = {Memory::state, Memory::state_rates, Memory::state_accelerations};
  static constexpr Source kChange = {Memory::past, static_cast<Memory>(static_cast<int>(Memory::past) + 1),
                                     static_cast<Memory>(static_cast<int>(Memory::past) + 2)};

  // Every sum begins with it, so that no output is -0.
  [[nodiscard]] Value zero() { return load(Memory::factors, 0); }
  // place: among numbers()
  [[nodiscard]] Value add(const Value& sum, std::size_t place, const TermAt& term, std::size_t d,
                          const Source& of = kState) {
    if (term.address == of_.one_) return d > 0 || of == kChange ? sum : sum + number(place, term.factor);
    const Reach reach = side_by_side_ ? Reach::from : Reach::one;
    return sum + number(place, term.factor) * graph_.load({of[d], static_cast<std::uint32_t>(term.address), reach});
  }
  [[nodiscard]] Value form(std::int32_t form, std::size_t d, const Source& of = kState) {
    Value sum = zero();
    for (std::int32_t t = of_.form_start_[idx(form)]; t < of_.form_start_[idx(form) + 1]; ++t) {
      sum = add(sum, of_.place_of_terms() + idx(t), of_.terms_[idx(t)], d, of);
    }
    return sum;
  }
  [[nodiscard]] Value size_of_terms(std::int32_t form, std::size_t d) {
    Value size = zero();
    for (std::int32_t t = of_.form_start_[idx(form)]; t < of_.form_start_[idx(form) + 1]; ++t) {
      size = size + abs(add(zero(), of_.place_of_terms() + idx(t), of_.terms_[idx(t)], d));
    }
    return size;
  }
  // Calls put(column, sum) for the linear outputs.
  template <class Put>
  void each_linear(const Source& source, const Put& put) {
    for (std::size_t d = 0; d < 3; ++d) {
      std::size_t place = 1;
      for (const Sum& sum : of_.sums_) {
        Value total = zero();
        for (std::int32_t t = sum.begin; t < sum.end; ++t)
          total = add(total, place++, of_.sum_terms_[idx(t)], d, source);
        put(sum.column[d], total);
      }
    }
  }

 private:
  [[nodiscard]] Slot own(Memory memory, std::size_t index) const {
    return {memory, static_cast<std::uint32_t>(index), side_by_side_ ? Reach::row : Reach::one};
  }
  [[nodiscard]] Value number(std::size_t place, double literal) {
    return side_by_side_ ? load(Memory::factors, place) : Value::set(literal);
  }

  const OutputProgram& of_;
  bool side_by_side_;
  Graph graph_;
};

bool OutputProgram::same_shape(const OutputProgram& o) const {
  const auto same = [](const auto& a, const auto& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const auto& x, const auto& y) { return x.is_like(y); });
  };
  return dimension_ == o.dimension_ && same(sums_, o.sums_) && same(sum_terms_, o.sum_terms_) &&
         same(terms_, o.terms_) && form_start_ == o.form_start_ && same(parts_, o.parts_);
}

StepProgram OutputProgram::output_step(Numbers numbers) const {
  StepWriter to(*this, numbers);
  to.each_linear(StepWriter::kState, [&](std::int32_t column, const Value& value) { to.put(column, value); });
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Measured& p = parts_[i];
    if (!p.is_signed_angle()) continue;
    const auto [x, y] = arm_by<Jet<Value>>(p, [&](std::int32_t form) {
      return Jet<Value>{to.form(form, 0), to.form(form, 1), to.form(form, 2)};
    });
    to.store(Memory::figures, i, x.value * x.value + y.value * y.value);
    Value angle = HWY_NAMESPACE::signed_angle_of(y.value, x.value);
    if (p.angle >= 0) angle = angle + Value::set(kTurn) * to.load(Memory::settings, idx(p.angle));
    const Jet<Value> m = assur::angle_of<Value>(angle, y, x);
    to.put(p.column[0], m.value);
    to.put(p.column[1], m.rate);
    to.put(p.column[2], m.acceleration);
  }
  return to.finish();
}

StepProgram OutputProgram::arm_step(Numbers numbers, std::size_t first_y) const {
  StepWriter to(*this, numbers);
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    const auto [x, y] = arm_by<Value>(parts_[angles_[i]], [&](std::int32_t form) { return to.form(form, 0); });
    to.store(Memory::work, i, x);
    to.store(Memory::work, first_y + i, y);
  }
  return to.finish();
}

StepProgram OutputProgram::change_step() const {
  using ArmDual = DualOf<Value>;
  StepWriter to(*this, Numbers::loads);
  to.each_linear(StepWriter::kChange, [&](std::int32_t column, const Value& value) { to.put(column, value); });
  std::size_t rounding = 0;
  for (const Measured& p : parts_) {
    if (!p.is_signed_angle()) continue;
    const auto [x, y] = arm_by<Jet<ArmDual>>(p, [&](std::int32_t form) {
      ArmDual of[3];
      for (std::size_t d = 0; d < 3; ++d) {
        const Value value = to.form(form, d), size = p.arm >= 0 ? to.size_of_terms(form, d) : value;
        of[d] = {value, to.form(form, d, StepWriter::kChange) + to.load(Memory::work, rounding++) * size};
      }
      return Jet<ArmDual>{of[0], of[1], of[2]};
    });
    const Jet<ArmDual> m = assur::angle_of<ArmDual>({{}, slope_of_angle(y.value, x.value)}, y, x);
    to.put(p.column[0], m.value.slope);
    to.put(p.column[1], m.rate.slope);
    to.put(p.column[2], m.acceleration.slope);
  }
  return to.finish();
}

std::size_t OutputProgram::roundings() const {
  std::size_t sum = 0;
  for (const Measured& p : parts_)
    sum += p.is_signed_angle() ? 3 * idx(p.arm >= 0 ? 2 : p.forms_end - p.forms_begin) : 0;
  return sum;
}

std::size_t OutputProgram::operations() const {
  constexpr std::size_t kOfAngle = 150;  // an estimate: operations of an angle with two derivatives
  const auto angles = static_cast<std::size_t>(
      std::count_if(parts_.begin(), parts_.end(), [](const Measured& p) { return p.is_signed_angle(); }));
  return 3 * (sum_terms_.size() + terms_.size()) + kOfAngle * angles;
}

std::int32_t OutputProgram::add_arm(const Measured& part) {
  if (part.kind == MeasureForms::Kind::absolute_angle) return part.forms_begin;
  if (!find_arm(part)) return -1;
  const auto arm = static_cast<std::int32_t>(form_start_.size()) - 1;
  for (const std::vector<TermAt>& terms : arm_terms_) {
    terms_.insert(terms_.end(), terms.begin(), terms.end());
    form_start_.push_back(static_cast<std::int32_t>(terms_.size()));
    of_forms_.push_back(-1);
  }
  return arm;
}

bool OutputProgram::find_arm(const Measured& part) {
  const std::int32_t count = dimension_;
  double constant[9] = {};  // of the forms that are constants
  bool is_constant[3] = {true, true, true};
  for (std::int32_t f = 0; f < part.forms_end - part.forms_begin; ++f) {
    for (const TermAt& t : terms_of(part.forms_begin + f)) {
      is_constant[f / count] = is_constant[f / count] && t.address == one_;
      constant[f] += t.factor;
    }
  }
  const bool from = is_constant[0], to = is_constant[1];
  if (!is_constant[2] || from == to) return false;
  // The arm is linear in the other direction: its share of each of its components
  ArmOf<double> share[3];
  const std::int32_t moves = from ? count : 0;
  for (std::int32_t k = 0; k < count; ++k) {
    double forms[9];
    std::copy(std::begin(constant), std::end(constant), forms);
    for (std::int32_t i = 0; i < count; ++i) forms[moves + i] = i == k ? 1 : 0;
    share[k] = arm_of<double>(part.kind, forms, dimension_);
  }
  for (const bool is_x : {true, false}) {
    std::vector<TermAt>& terms = arm_terms_[is_x ? 0 : 1];
    terms.clear();
    for (std::int32_t k = 0; k < count; ++k) {
      const double by = is_x ? share[k].x : share[k].y;
      for (const TermAt& t : terms_of(part.forms_begin + moves + k)) {
        if (by != 0) terms.push_back({t.address, t.factor * by});
      }
    }
  }
  return true;
}

// False if other terms take part.
bool OutputProgram::renew_arm(const Measured& part) {
  if (part.arm < 0 || part.arm == part.forms_begin) return true;
  if (!find_arm(part)) return false;
  for (std::size_t i = 0; i < 2; ++i) {
    TermAt* const to = terms_.data() + form_start_[idx(part.arm) + i];
    const std::vector<TermAt>& terms = arm_terms_[i];
    const auto like = [](const TermAt& a, const TermAt& b) { return a.is_like(b); };
    const TermAt* const end = terms_.data() + form_start_[idx(part.arm) + i + 1];
    if (!std::equal(terms.begin(), terms.end(), static_cast<const TermAt*>(to), end, like)) return false;
    std::copy(terms.begin(), terms.end(), to);
  }
  return true;
}

void OutputProgram::mark(std::vector<std::uint8_t>& addresses) const {
  for (const TermAt& t : terms_) addresses[static_cast<std::size_t>(t.address)] = 1;
  for (const TermAt& t : sum_terms_) addresses[static_cast<std::size_t>(t.address)] = 1;
}

std::vector<std::size_t> OutputProgram::angles() const {
  std::vector<std::size_t> columns;
  for (const std::size_t part : angles_) columns.push_back(static_cast<std::size_t>(parts_[part].column[0]));
  return columns;
}

void OutputProgram::arm(std::size_t i, const double* q, double& x, double& y) const {
  const auto value_of = [&](std::int32_t form) {
    double value = 0;
    for (const TermAt& t : terms_of(form)) value += t.factor * q[t.address];
    return value;
  };
  const ArmOf<double> arm = arm_by<double>(parts_[angles_[i]], value_of);
  x = arm.x;
  y = arm.y;
}

double OutputProgram::size_of_arm(std::size_t i, const double* q) const {
  const Measured& part = parts_[angles_[i]];
  double size = 1;
  for (std::int32_t f = part.forms_begin; f < part.forms_end; f += dimension_) {  // f: first form of each vector
    double largest = 0;
    for (std::int32_t k = f; k < f + dimension_ && k < part.forms_end; ++k) {
      double sum = 0;
      for (const TermAt& t : terms_of(k)) sum += std::abs(t.factor * q[t.address]);
      largest = std::max(largest, sum);
    }
    size *= largest;
  }
  return size;
}

// output_step(), interpreted, takes 3 times as long for a four-bar, and 13 to 26 times as long for many outputs.
void OutputProgram::evaluate(const double* const (&state)[3], double* out, const double* turns, double* divisors,
                             std::size_t part, std::size_t parts) const {
  const std::span<const Measured> among = share(parts_, part, parts);
  evaluate_linear(state, out, part, parts);
  evaluate_angles(state, out, turns, divisors, among);
  evaluate_others(state, out, divisors, 1, among);
}

void OutputProgram::evaluate_others(const double* const (&state)[3], double* out, double* divisors, std::size_t apart,
                                    std::span<const Measured> among) const {
  for (const Measured& measure : among) {
    if (measure.is_signed_angle()) continue;
    Jet<double> forms[9];
    evaluate_forms(measure, state, forms);
    const auto i = static_cast<std::size_t>(&measure - parts_.data());
    divisors[i * apart] = divisor_of<double>(measure.kind, {forms, 9}, dimension_);
    put(measure, evaluate_measure<double>(measure.kind, {forms, 9}, dimension_), out, apart);
  }
}

void OutputProgram::put(const Measured& measure, const Jet<double>& m, double* out, std::size_t apart) {
  const double value[3] = {m.value, m.rate, m.acceleration};
  for (std::size_t d = 0; d < 3; ++d) {
    if (measure.column[d] >= 0) out[idx(measure.column[d]) * apart] = value[d] * measure.unit;
  }
}

// Signed angles, eight side by side. Their unit is 1.
void OutputProgram::evaluate_angles(const double* const (&state)[3], double* out, const double* turns, double* divisors,
                                    std::span<const Measured> among) const {
  const Measured* waiting[kAngleBlock];
  ArmOf<Jet<double>> arms[kAngleBlock];
  double x[kAngleBlock], y[kAngleBlock], angles[kAngleBlock];
  std::size_t count = 0;
  const auto finish = [&] {
    for (std::size_t i = 0; i < kAngleBlock; ++i) {
      x[i] = i < count ? arms[i].x.value : 1;
      y[i] = i < count ? arms[i].y.value : 0;
    }
    kernels_->angles(y, x, count, angles);
    for (std::size_t i = 0; i < count; ++i) {
      const Measured& measure = *waiting[i];
      divisors[&measure - parts_.data()] = x[i] * x[i] + y[i] * y[i];
      if (measure.angle >= 0) angles[i] += kTurn * turns[measure.angle];
      put(measure, angle_of<double>(angles[i], arms[i].y, arms[i].x), out);
    }
    count = 0;
  };
  for (const Measured& measure : among) {
    if (!measure.is_signed_angle()) continue;
    waiting[count] = &measure;
    arms[count] = arm_by<Jet<double>>(measure, [&](std::int32_t form) { return jet_of(form, state); });
    if (++count == kAngleBlock) finish();
  }
  if (count > 0) finish();
}

void OutputProgram::differentiate(const double* const (&state)[3], const double* const (&change)[3], RandomSign* sign,
                                  double* out) const {
  evaluate_linear(change, out, 0, 1);
  for (const Measured& measure : parts_) differentiate(measure, state, change, sign, out, 1);
  add_up_changes(out);
}

void OutputProgram::differentiate_others(const double* const (&state)[3], const double* const (&change)[3],
                                         RandomSign* sign, double* out, std::size_t apart) const {
  for (const Measured& measure : parts_) {
    if (!measure.is_signed_angle()) differentiate(measure, state, change, sign, out, apart);
  }
}

void OutputProgram::differentiate(const Measured& measure, const double* const (&state)[3],
                                  const double* const (&change)[3], RandomSign* sign, double* out,
                                  std::size_t apart) const {
  const auto rounding = [&] { return sign != nullptr ? (*sign)() * kEps : 0; };
  const auto with_rounding = [&](const Jet<double>& value, const Jet<double>& by, const Jet<double>& size) {
    return Jet<Dual>{{value.value, by.value + rounding() * size.value},
                     {value.rate, by.rate + rounding() * size.rate},
                     {value.acceleration, by.acceleration + rounding() * size.acceleration}};
  };
  if (measure.arm >= 0) {
    const auto [x, y] = arm_by<Jet<Dual>>(measure, [&](std::int32_t form) {
      return with_rounding(jet_of(form, state), jet_of(form, change), size_of_terms(form, state));
    });
    const Jet<Dual> m = atan2(y, x);
    return put(measure, {m.value.slope, m.rate.slope, m.acceleration.slope}, out, apart);
  }
  Jet<double> forms[9], changes[9];
  evaluate_forms(measure, state, forms);
  evaluate_forms(measure, change, changes);
  Jet<Dual> both[9];
  for (std::size_t f = 0; f < 9; ++f) both[f] = with_rounding(forms[f], changes[f], forms[f]);
  const Jet<Dual> m = evaluate_measure<Dual>(measure.kind, {both, 9}, dimension_);
  Jet<double> slope{m.value.slope, m.rate.slope, m.acceleration.slope};
  if (slope.value == 0 && !(divisor_of<double>(measure.kind, {forms, 9}, dimension_) > 0)) {  // at a kink
    for (std::size_t f = 0; f < 9; ++f) forms[f].value += both[f].value.slope;
    slope.value = evaluate_measure<double>(measure.kind, {forms, 9}, dimension_).value - m.value.value;
  }
  put(measure, slope, out, apart);
}

Jet<double> OutputProgram::size_of_terms(std::int32_t form, const double* const (&state)[3]) const {
  Jet<double> size;
  for (const TermAt& t : terms_of(form)) {
    size += Jet<double>{std::abs(t.factor * state[0][t.address]), std::abs(t.factor * state[1][t.address]),
                        std::abs(t.factor * state[2][t.address])};
  }
  return size;
}

// constant: factor of the constants.
void OutputProgram::add_up(double* out, double constant) const {
  for (const Total& total : totals_) {
    double sum = constant * total.constant;
    for (std::int32_t t = total.begin; t < total.end; ++t) {
      const TotalTerm& term = total_terms_[static_cast<std::size_t>(t)];
      sum += term.factor * out[term.column];
    }
    out[total.column] = sum;
  }
}

void OutputProgram::evaluate_linear(const double* const (&state)[3], double* out, std::size_t part,
                                    std::size_t parts) const {
  if (!rows_.empty()) evaluate_rows_(share(rows_, part, parts), row_terms_.data(), state, out);
  for (const Sum& sum : share(sums_, part, parts)) {
    double total[3] = {};
    for (std::int32_t t = sum.begin; t < sum.end; ++t) {
      const TermAt& term = sum_terms_[static_cast<std::size_t>(t)];
      for (std::size_t d = 0; d < 3; ++d) total[d] += term.factor * state[d][term.address];
    }
    for (std::size_t d = 0; d < 3; ++d) {
      if (sum.column[d] >= 0) out[sum.column[d]] = total[d];
    }
  }
}

void OutputProgram::evaluate_forms(const Measured& measure, const double* const (&state)[3],
                                   Jet<double> (&forms)[9]) const {
  for (std::int32_t f = measure.forms_begin; f < measure.forms_end; ++f) {
    forms[f - measure.forms_begin] = jet_of(f, state);
  }
}

Jet<double> OutputProgram::jet_of(std::int32_t form, const double* const (&state)[3]) const {
  // Unwanted derivatives are summed as well: branches would cost more than three sums in registers.
  double value = 0, rate = 0, acceleration = 0;
  for (const TermAt& term : terms_of(form)) {
    value += term.factor * state[0][term.address];
    rate += term.factor * state[1][term.address];
    acceleration += term.factor * state[2][term.address];
  }
  return {value, rate, acceleration};
}

}  // namespace assur
