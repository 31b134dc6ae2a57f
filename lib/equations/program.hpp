// The constraint program of a group class: it computes Phi, the Jacobian, and the right-hand sides of velocity and
// acceleration over the lanes of a pack. It contains no numbers or pointers: coordinates and coefficients are slots, so
// that all groups of the class, and all members of an ensemble, share it. Differences (forms) come first, then
// products.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "assur/structure.hpp"

namespace assur {

// Content of a coefficient slot: literal * product of up to three constants of the group (-1: none).
struct Coefficient {
  double literal = 1;
  std::int32_t constant[3] = {-1, -1, -1};

  friend bool operator==(const Coefficient&, const Coefficient&) = default;
};

// The program. Registers: 0..n-1 are unknowns, n..n+inputs-1 inputs, then the number one, then forms that are no plain
// coordinate. Every list is processed in order; a range is [begin, end) of the list that its comment names.
struct Program {
  struct Operand {  // coefficient * register
    std::int32_t coefficient, reg;
  };
  struct Product {  // coefficient * a * b
    std::int32_t coefficient, a, b;
  };
  struct Range {
    std::int32_t begin, end;
  };
  // A register as a sum of `operands`: first constants and inputs at rest, then moving inputs, then unknowns.
  struct Form {
    std::int32_t reg, begin, moving, unknowns, end;
  };
  // Phi_i = linear + products. -Phi_h h' = -(input_linear + input_products), with the rate of register a.
  // -d/dt(Phi_q) q' = -curvature, with the rates of both registers. From `factors` on, the linear operands are products
  // with a constant factor.
  struct Equation {
    Range linear, products, input_linear, input_products, curvature;
    std::int32_t factors;
    std::int32_t gear;  // -1: none
  };
  struct CallbackEntry {  // chain rule through an argument of a callback: J[row, argument] * coefficient
    std::int32_t nonzero, callback, row, argument, coefficient;
  };

  std::int32_t n = 0, inputs = 0, equations_count = 0, registers = 0;
  [[nodiscard]] std::int32_t one() const { return n + inputs; }
  Pattern pattern;
  std::vector<Coefficient> coefficients;
  std::vector<Form> forms;
  std::vector<Operand> operands;  // of forms
  std::vector<Equation> equations;
  std::vector<Operand> linear, input_linear;
  std::vector<Product> products, input_products, curvature;
  std::vector<Range> entries;  // nnz: each nonzero of the Jacobian as a sum of `entry_operands`
  std::vector<Operand> entry_operands;
  struct CallbackRow {
    std::int32_t equation, row;  // local equation, row of the callback
  };
  struct CallbackUse {
    std::int32_t callback;                // index into System::callbacks
    std::vector<CallbackRow> rows;        // rows in this group; redundant rows may be missing
    std::vector<std::int32_t> arguments;  // registers; ~coefficient for a constant one
  };
  std::vector<CallbackUse> callbacks;
  std::vector<CallbackEntry> callback_entries;
  struct Gear {
    GroupClass::Gear numbers;
    std::vector<std::int32_t> arguments;      // registers; ~coefficient for a constant one
    std::int32_t first = 0, first_angle = 0;  // arguments, and angles, of the gears before it
  };
  struct GearEntry {  // chain rule through an argument of a gear, as CallbackEntry; ordered by nonzero
    std::int32_t nonzero, gear, argument, coefficient;
  };
  std::vector<Gear> gears;
  std::int32_t gear_arguments = 0, gear_angles = 0;  // of all gears
  std::vector<GearEntry> gear_entries;

  // For the branch check. Row i of block b: sum_j,l |d2 Phi_i / dq_j dq_l| over the block's unknowns j and all moving
  // coordinates l, as a sum of |coefficient|s; see lipschitz().
  std::vector<std::int32_t> unknown_block, equation_block;
  std::int32_t blocks = 1;
};

// Indices of the coefficients 0 and 1 of a pack, which follow those of the program.
[[nodiscard]] inline std::int32_t zero_coefficient(const Program& p) {
  return static_cast<std::int32_t>(p.coefficients.size());
}
[[nodiscard]] inline std::int32_t one_coefficient(const Program& p) { return zero_coefficient(p) + 1; }

// `group_class` in program form; `pattern` is Structure::pattern of the class.
[[nodiscard]] Program compile(const GroupClass& group_class, Pattern pattern);

// Coefficients of instances side by side. constants: of the group x lanes; out: coefficients of the program x lanes
void bind_coefficients(const Program& program, const double* constants, double* out, std::size_t lanes);

// Row-wise Lipschitz constants of the Jacobian of each irreducible block in the maximum norm:
// |J_i.(x) - J_i.(y)|_1 <= lipschitz_i |x - y|_inf, columns of the row's block only. Infinite for callback rows.
// Of instances side by side, constants as above; out: equations x lanes; lanes: at most kMostLanes
void lipschitz(const GroupClass& group_class, const double* constants, double* out, std::size_t lanes);

}  // namespace assur
