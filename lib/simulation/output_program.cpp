#include "simulation/output_program.hpp"

#include <cmath>
#include <numbers>

namespace assur {

OutputProgram::OutputProgram(const System& s, std::span<const std::int32_t> address) : dimension_(s.dimension) {
  for (const Output& o : wanted_outputs(s)) {
    const auto first = static_cast<std::int32_t>(columns_.size());
    append_columns(o, columns_);
    std::int32_t place[3], next = first;
    for (int d = 0; d < 3; ++d) {
      place[d] = o.wanted[d] ? next : -1;
      if (o.wanted[d]) next += static_cast<std::int32_t>(o.parts.size());
    }
    for (std::size_t k = 0; k < o.parts.size(); ++k) {
      const MeasureForms& m = o.parts[k];
      Part part{m.kind,
                static_cast<std::int32_t>(form_start_.size()) - 1,
                0,
                s.unit(m.dimension),
                {-1, -1, -1},
                o.derivatives(),
                m.kind == MeasureForms::Kind::absolute_angle || m.kind == MeasureForms::Kind::signed_angle};
      for (const Index f : m.forms) {
        for (const Term& t : s.form(f)) {
          terms_.push_back(
              {address[static_cast<std::size_t>(t.coordinate)], s.constants[static_cast<std::size_t>(t.constant)]});
        }
        form_start_.push_back(static_cast<std::int32_t>(terms_.size()));
      }
      part.forms_end = static_cast<std::int32_t>(form_start_.size()) - 1;
      for (int d = 0; d < 3; ++d) {
        if (place[d] >= 0) part.column[d] = place[d] + static_cast<std::int32_t>(k);
      }
      parts_.push_back(part);
    }
  }
}

void OutputProgram::evaluate(const double* const (&state)[3], double* out, const double* previous, double dt) const {
  for (const Part& part : parts_) {
    Jet<double> forms[9];
    for (std::int32_t f = part.forms_begin; f < part.forms_end; ++f) {
      double sum[3] = {};
      for (int d = 0; d <= part.derivatives; ++d) {
        for (std::int32_t t = form_start_[static_cast<std::size_t>(f)];
             t < form_start_[static_cast<std::size_t>(f) + 1]; ++t) {
          const TermAt& term = terms_[static_cast<std::size_t>(t)];
          sum[d] += term.factor * state[d][term.address];
        }
      }
      forms[f - part.forms_begin] = {sum[0], sum[1], sum[2]};
    }
    Jet<double> m = evaluate_measure<double>(part.kind, {forms, 9}, dimension_);
    if (part.angle && previous != nullptr && part.column[0] >= 0) {
      double expected = previous[part.column[0]];
      if (part.column[1] >= 0) expected += dt * (previous[part.column[1]] + m.rate) / 2;
      m.value += 2 * std::numbers::pi * std::round((expected - m.value) / (2 * std::numbers::pi));
    }
    const double value[3] = {m.value, m.rate, m.acceleration};
    for (int d = 0; d < 3; ++d) {
      if (part.column[d] >= 0) out[part.column[d]] = value[d] * part.unit;
    }
  }
}

}  // namespace assur
