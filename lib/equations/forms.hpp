// A System under construction: named items, linear forms and quadratic equations, in internal units.
#pragma once

#include <cmath>
#include <initializer_list>
#include <memory>
#include <memory_resource>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "assur/number.hpp"
#include "equations/system.hpp"

namespace assur {

using Terms = std::vector<Term>;

// The two components that follow each one, in cyclic order.
inline constexpr int kNext[3] = {1, 2, 0};
inline constexpr int kAfter[3] = {2, 0, 1};  // the second one

class Forms {
 public:
  // The components of a point, a vector or a pair's difference.
  struct Components {
    Index form[3];
    int power;  // of length
  };

  Forms(std::shared_ptr<const Scene> scene, int length_exponent);

  [[nodiscard]] const Scene& scene() const { return *s_.scene; }
  [[nodiscard]] int dimension() const { return s_.dimension; }
  [[nodiscard]] System& system() { return s_; }
  [[nodiscard]] const System& system() const { return s_; }

  // The finished system, without unused memory: a scene may have millions of equations.
  [[nodiscard]] System finish();

  // Constants and forms. Values are in SI units, `power` is their power of length.
  Index constant(const Number& value, int power = 0) { return constant(value, power, std::abs(value.value())); }
  // size: magnitude of the numbers that the value is computed from; far smaller values may be their rounding.
  Index constant(const Number& value, int power, double size);
  Index form(Terms terms, double least = 0);
  Index constant_form(const Number& value, int power) { return form({{kOne, constant(value, power)}}); }
  Index combination(std::initializer_list<std::pair<Index, Index>> parts);  // (form, constant)
  Index difference(Index a, Index b) { return combination({{a, kPlus}, {b, kMinus}}); }
  // terms += constant `factor` * form f
  void append(Terms& terms, Index f, Index factor);

  // Items and coordinates. References to items are valid until the next item is added.
  Index add_item(Item item);
  Index add_coordinate(Index item, int component, int power, Role role, const Number& guess, bool moving = true);
  Index coordinate_form(Index coordinate) { return form({{coordinate, kPlus}}); }
  void declare(const std::string& name, const Triple& at, bool fixed, int power);          // a point or vector
  void declare_derived(const std::string& name, int power, const Index (&components)[3]);  // a body's member
  void declare_scalar(const std::string& name, int power, const Number& guess);

  // Both throw std::out_of_range for a name that a valid scene cannot contain.
  [[nodiscard]] const Item& item(const std::string& name) const;
  [[nodiscard]] Index item_index(const std::string& name) const { return item_of_.at(name); }

  // "P.x" or "name.lambda"
  [[nodiscard]] Index scalar_form(const std::string& text) const;
  [[nodiscard]] int scalar_dimension(const std::string& text) const;

  [[nodiscard]] Components direction(const Direction& d);
  [[nodiscard]] int power(const Direction& d) const { return d.is_pair() ? 1 : int{item(d.first).dimension}; }

  // Posture as written, SI units.
  [[nodiscard]] Triple at(const Item& item) const;
  [[nodiscard]] Triple at(const std::string& name) const { return at(item(name)); }
  [[nodiscard]] Triple at(const Direction& d) const;

  // Known and unknown coordinates.
  [[nodiscard]] bool is_fixed(const Item& item) const;   // constant
  [[nodiscard]] bool all_known(const Item& item) const;  // true if all components are fixed or driven
  // The unknown coordinate if the form is a single one; else -1.
  [[nodiscard]] Index own_coordinate(Index form) const;

  // Equations = 0. Equations after a call of source() are rows of that source.
  Index source(std::string name);
  void equation(Index source, const std::vector<Product>& products, const Terms& linear);
  void callback_row(Index source, Index callback, Index row);
  void unit_equation(Index source, const Item& vector);
  void distance_equation(Index source, const Item& p, const Item& q, const Number& length);
  void orthogonal_equation(Index source, const Index* d, const Index* e);
  void cross_equation(Index source, const Index* c, const Index* a, const Index* b);  // c = a x b
  // products += d . e, factor 1; += and -= |p - q|^2
  void add_dot(std::vector<Product>& products, const Index* d, const Index* e) const;
  void add_square(std::vector<Product>& products, const Item& p, const Item& q, Index factor);

 private:
  [[nodiscard]] int shift(int power) const { return -s_.length_exponent * power; }  // power of two, to internal units
  [[nodiscard]] Number scaled(const Number& value, int power) const { return ldexp(value, shift(power)); }
  void drop_rounding(Terms& terms, double least);
  struct Exact;  // a constant in double-double, with the size of its numbers
  [[nodiscard]] Exact exact(Index constant) const;
  Index internal_constant(const Exact& exact);
  Index times(Index a, Index b);

  System s_;
  std::pmr::monotonic_buffer_resource names_;  // freed as a whole, because millions of small pieces would leave gaps
  std::pmr::unordered_map<std::string, Index> item_of_{&names_};
  std::vector<double> rests_;  // rounding error of each constant
  Origins rest_origins_;
  std::vector<double> sizes_;  // magnitude of the numbers that each constant is computed from
  Index row_ = 0;
};

}  // namespace assur
