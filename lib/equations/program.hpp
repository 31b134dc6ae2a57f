// The constraint program of a group class: Phi, its Jacobian, the right-hand sides of velocity and acceleration, over
// the lanes of a pack. It is data without numbers or pointers: coordinates and coefficients are slots, so every
// instance of the class, and every member of an ensemble, runs the same program. Differences (forms) come first, then
// products.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "assur/structure.hpp"

namespace assur {

// literal * product of up to three constants of the instance (-1: none): what a coefficient slot holds.
struct Coefficient {
  double literal = 1;
  std::int32_t constant[3] = {-1, -1, -1};

  friend bool operator==(const Coefficient&, const Coefficient&) = default;
};

// Registers: 0..n-1 unknowns, n..n+inputs-1 inputs, then the forms that are no plain coordinate.
struct Program {
  struct Operand {
    std::int32_t coefficient;
    std::int32_t reg;
  };
  struct Form {
    std::int32_t reg;
    std::int32_t offset;                        // coefficient of the constant part, -1: none
    std::int32_t inputs_begin, inputs_end;      // operands that are inputs
    std::int32_t unknowns_begin, unknowns_end;  // operands that are unknowns
    std::int32_t moving_begin, moving_end;      // operands that are inputs and move
  };
  struct Product {
    std::int32_t a, b;         // registers, or -1 for a constant form: its value is coefficient a_constant / b_constant
    std::int32_t coefficient;  // of the whole product
    bool a_moves, b_moves;     // an input that moves is behind it
    bool a_unknown, b_unknown;
    bool constant;  // both factors are constant forms: part of the constant of the equation
  };
  struct Equation {
    std::int32_t products_begin, products_end;
    std::int32_t linear;  // register, -1: none
    bool linear_moves, linear_unknown;
    std::int32_t offset;         // coefficient: constant linear form, -1: none
    std::int32_t callback, row;  // -1: none
  };
  // One nonzero of the Jacobian: sum of coefficient * register (reg -1: the coefficient alone).
  struct Entry {
    std::int32_t begin, end;
  };
  struct CallbackEntry {  // chain rule through an argument of a callback: J[row, argument] * coefficient
    std::int32_t nonzero, callback, row, argument, coefficient;
  };

  std::int32_t n = 0, inputs = 0, equations_count = 0, registers = 0;
  Pattern pattern;
  std::vector<Coefficient> coefficients;
  std::vector<Operand> operands;
  std::vector<Form> forms;
  std::vector<Product> products;
  std::vector<Equation> equations;
  std::vector<Entry> entries;  // nnz
  std::vector<Operand> entry_operands;
  struct CallbackRow {
    std::int32_t equation, row;  // local equation, row of the callback
  };
  struct CallbackUse {
    std::int32_t callback;                // index into System::callbacks
    std::vector<CallbackRow> rows;        // those that belong to the group: redundant ones may be missing
    std::vector<std::int32_t> arguments;  // registers; ~coefficient for a constant one
  };
  std::vector<CallbackUse> callbacks;
  std::vector<CallbackEntry> callback_entries;

  // For the branch check. Row i of block b: sum_j,l |d2 Phi_i / dq_j dq_l| over the block's unknowns j and all moving
  // coordinates l, as a sum of |coefficient|s; see lipschitz().
  std::vector<std::int32_t> unknown_block, equation_block;
  std::int32_t blocks = 1;
};

// `group_class` in program form; `pattern` is Structure::pattern of the class.
[[nodiscard]] Program compile(const GroupClass& group_class, Pattern pattern);

// Coefficients of one instance: out[k * stride] for every coefficient k of the program.
void bind_coefficients(const Program& program, std::span<const double> constants, double* out, std::size_t stride);

// Row-wise Lipschitz constants of the Jacobian of each irreducible block in the maximum norm, for one instance:
// |J_i.(x) - J_i.(y)|_1 <= lipschitz_i |x - y|_inf, columns of the row's block only. Infinite for callback rows.
// out[i * stride] for every equation i.
void lipschitz(const GroupClass& group_class, std::span<const double> constants, double* out, std::size_t stride);

}  // namespace assur
