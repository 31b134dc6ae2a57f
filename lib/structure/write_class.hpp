// Writes the program of a class from the equations of a group in local numbers.
#pragma once

#include <vector>

#include "equations/system.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// Local coordinates: 0 to n - 1 are unknowns, n to n + inputs - 1 inputs, -1 is the constant 1. Local constants: -1 is
// the literal +1, -2 the literal -1, other numbers are slots. Phi_i = sum_products constant * form_a * form_b + linear
// form_i.
struct LocalEquations {
  struct Term {  // of a form: constant * coordinate
    Index coordinate, constant;
    friend bool operator==(const Term&, const Term&) = default;
  };
  struct Product {
    Index a, b, constant;  // a, b: forms
    friend bool operator==(const Product&, const Product&) = default;
  };
  struct Equation {
    Index products_begin, products_end;  // of a callback: its arguments, the forms `a`
    Index linear;                        // the form that is added; -1: none
    Index callback, row;                 // callback (-1: none), and its row that gives this equation
    Index gear = -1;                     // index into `gears`, if the callback is a gear
    friend bool operator==(const Equation&, const Equation&) = default;
  };

  GroupClass outline;  // its numbers of unknowns, inputs and constants, and its blocks; no lists of the program
  std::vector<Index> form_start = {0};  // forms + 1: first of the terms
  std::vector<Term> terms;
  std::vector<Product> products;
  std::vector<Equation> equations;
  std::vector<GroupClass::Gear> gears;  // without arguments

  [[nodiscard]] Index forms() const { return static_cast<Index>(form_start.size()) - 1; }
  friend bool operator==(const LocalEquations&, const LocalEquations&) = default;
};

// The class of these equations, with the pattern of its Jacobian.
[[nodiscard]] GroupClass write_class(const LocalEquations& equations);

}  // namespace assur
