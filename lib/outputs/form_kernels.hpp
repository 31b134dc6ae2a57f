// Linear forms side by side, in the SIMD target of the machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "evaluation/input_row.hpp"

namespace assur {

inline constexpr int kFormLanes = 8;  // forms side by side: the widest vector

// A term of the forms of a row.
struct FormTerm {
  InputRow coordinate;  // not scattered
  double factor[kFormLanes];
};
// Forms with the same number of terms: sums of factor * coordinate, with all derivatives.
struct FormRow {
  std::int32_t begin, end;          // range of its terms
  std::int32_t count;               // forms
  std::int32_t step;                // from the column of a value to that of its rate, and on to the acceleration
  std::int32_t column[kFormLanes];  // of the values
};

// Writes the columns of all rows. terms: of all rows; state[d]: d-th derivative. The results are those of a loop
// over single forms, bit for bit.
using EvaluateForms = void (*)(std::span<const FormRow> rows, const FormTerm* terms, const double* const (&state)[3],
                               double* out);
[[nodiscard]] EvaluateForms evaluate_forms();

}  // namespace assur
