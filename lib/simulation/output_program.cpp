#include "simulation/output_program.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace assur {

void OutputProgram::bind(const System& s, std::span<const std::int32_t> address) {
  dimension_ = s.dimension;
  motions_.clear();
  lines_.clear();
  sums_.clear();
  sum_terms_.clear();
  terms_.clear();
  form_start_.assign(1, 0);
  parts_.clear();
  std::int32_t next = 0;  // column
  for (const Output& o : wanted_outputs(s)) {
    const auto parts = static_cast<std::int32_t>(o.part_count);
    std::int32_t first[3];  // column of the first part
    for (int d = 0; d < 3; ++d) {
      first[d] = o.wanted[d] ? next : -1;
      if (o.wanted[d]) next += parts;
    }
    for (std::int32_t k = 0; k < parts; ++k) {
      const auto column = [&](int d) { return first[d] < 0 ? -1 : first[d] + k; };
      add(s, address, o.all_parts[static_cast<std::size_t>(k)], {column(0), column(1), column(2)});
    }
  }
}

void OutputProgram::add(const System& s, std::span<const std::int32_t> address, const OutputPart& m,
                        const std::array<std::int32_t, 3>& column) {
  const auto term_at = [&](const Term& t) {
    return TermAt{address[static_cast<std::size_t>(t.coordinate)], s.constants[static_cast<std::size_t>(t.constant)]};
  };
  const double unit = s.unit(m.dimension);
  if (m.kind == MeasureForms::Kind::form && add_line(s, address, m.forms[0], unit, column)) return;
  if (m.kind == MeasureForms::Kind::form) {
    const auto begin = static_cast<std::int32_t>(sum_terms_.size());
    for (const Term& t : s.form(m.forms[0])) {
      sum_terms_.push_back(term_at(t));
      sum_terms_.back().factor *= unit;  // a power of two
    }
    sums_.push_back({begin, static_cast<std::int32_t>(sum_terms_.size()), column});
    return;
  }
  Part part{m.kind, static_cast<std::int32_t>(form_start_.size()) - 1,
            0,      unit,
            column, m.kind == MeasureForms::Kind::absolute_angle || m.kind == MeasureForms::Kind::signed_angle};
  for (const Index f : m.forms) {
    for (const Term& t : s.form(f)) terms_.push_back(term_at(t));
    form_start_.push_back(static_cast<std::int32_t>(terms_.size()));
  }
  part.forms_end = static_cast<std::int32_t>(form_start_.size()) - 1;
  parts_.push_back(part);
}

bool OutputProgram::add_line(const System& s, std::span<const std::int32_t> address, Index form, double unit,
                             const std::array<std::int32_t, 3>& column) {
  Line line{address[kOne], column, 0, 0};
  bool moves = false;
  for (const Term& t : s.form(form)) {
    const double factor = s.constants[static_cast<std::size_t>(t.constant)] * unit;  // a power of two
    if (t.coordinate == kOne) {
      line.offset += factor;
      continue;
    }
    if (moves) return false;
    moves = true;
    line.address = address[static_cast<std::size_t>(t.coordinate)];
    line.factor = factor;
  }
  const bool all = std::all_of(column.begin(), column.end(), [](std::int32_t c) { return c >= 0; });
  (all ? motions_ : lines_).push_back(line);
  return true;
}

void OutputProgram::mark(std::vector<std::uint8_t>& addresses) const {
  for (const auto* lines : {&motions_, &lines_}) {
    for (const Line& l : *lines) addresses[static_cast<std::size_t>(l.address)] = 1;
  }
  for (const TermAt& t : terms_) addresses[static_cast<std::size_t>(t.address)] = 1;
  for (const TermAt& t : sum_terms_) addresses[static_cast<std::size_t>(t.address)] = 1;
}

std::vector<std::size_t> OutputProgram::angles() const {
  std::vector<std::size_t> columns;
  for (const Part& part : parts_) {
    if (part.angle && part.column[0] >= 0) columns.push_back(static_cast<std::size_t>(part.column[0]));
  }
  return columns;
}

void OutputProgram::evaluate(const double* const (&state)[3], double* out, const double* previous, double dt,
                             std::size_t part, std::size_t parts) const {
  const auto share = [&](const auto& list) {
    const std::size_t begin = list.size() * part / parts, end = list.size() * (part + 1) / parts;
    return std::span(list).subspan(begin, end - begin);
  };
  for (const Line& l : share(motions_)) {
    out[l.column[0]] = l.offset + l.factor * state[0][l.address];
    out[l.column[1]] = l.factor * state[1][l.address];
    out[l.column[2]] = l.factor * state[2][l.address];
  }
  for (const Line& l : share(lines_)) {
    for (std::size_t d = 0; d < 3; ++d) {
      if (l.column[d] >= 0) out[l.column[d]] = (d == 0 ? l.offset : 0) + l.factor * state[d][l.address];
    }
  }
  for (const Sum& sum : share(sums_)) {
    double total[3] = {};
    for (std::int32_t t = sum.begin; t < sum.end; ++t) {
      const TermAt& term = sum_terms_[static_cast<std::size_t>(t)];
      for (std::size_t d = 0; d < 3; ++d) total[d] += term.factor * state[d][term.address];
    }
    for (std::size_t d = 0; d < 3; ++d) {
      if (sum.column[d] >= 0) out[sum.column[d]] = total[d];
    }
  }
  for (const Part& measure : share(parts_)) {
    Jet<double> forms[9];
    for (std::int32_t f = measure.forms_begin; f < measure.forms_end; ++f) {
      // Derivatives that nobody wants are added as well: three sums stay in registers.
      double value = 0, rate = 0, acceleration = 0;
      for (std::int32_t t = form_start_[static_cast<std::size_t>(f)]; t < form_start_[static_cast<std::size_t>(f) + 1];
           ++t) {
        const TermAt& term = terms_[static_cast<std::size_t>(t)];
        value += term.factor * state[0][term.address];
        rate += term.factor * state[1][term.address];
        acceleration += term.factor * state[2][term.address];
      }
      forms[f - measure.forms_begin] = {value, rate, acceleration};
    }
    Jet<double> m = evaluate_measure<double>(measure.kind, {forms, 9}, dimension_);
    if (measure.angle && previous != nullptr && measure.column[0] >= 0) {
      double expected = previous[measure.column[0]];
      if (measure.column[1] >= 0) expected += dt * (previous[measure.column[1]] + m.rate) / 2;
      m.value += 2 * std::numbers::pi * std::round((expected - m.value) / (2 * std::numbers::pi));
    }
    const double value[3] = {m.value, m.rate, m.acceleration};
    for (std::size_t d = 0; d < 3; ++d) {
      if (measure.column[d] >= 0) out[measure.column[d]] = value[d] * measure.unit;
    }
  }
}

}  // namespace assur
