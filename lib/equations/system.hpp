// A scene written as equations: quadratic polynomials over linear forms in scalar coordinates.
//
//   form_f(q)   = sum_terms constant * q[coordinate]
//   Phi_i(q)    = sum_products constant * form_a(q) * form_b(q) + linear form_i(q)        (or a callback's row)
//
// Coordinate 0 is the constant 1, so forms are affine. Differences are forms, products come after: (P - Q)^2 is never
// expanded. Everything is in internal units: lengths in 2^length_exponent metres (exact in binary), so scaling all
// lengths of a scene by a power of two changes no bit.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <variant>
#include <vector>

#include "assur/scene.hpp"
#include "index.hpp"

namespace assur {

inline constexpr Index kOne = 0;       // coordinate: the constant 1
inline constexpr Index kPlus = 0;      // constant: +1
inline constexpr Index kMinus = 1;     // constant: -1
inline constexpr Index kLiterals = 2;  // constants below are part of an equation's type, the others are values

enum class Role : std::uint8_t {
  one,      // coordinate 0
  driven,   // known: a driver's input, or a coordinate that a driver fixes
  unknown,  // solved for
};

struct Coordinate {
  Index item = -1;            // index into System::items
  std::int8_t component = 0;  // 0, 1, 2 = x, y, z; -1: the item is a scalar
  std::int8_t dimension = 0;  // power of length
  Role role = Role::unknown;
  bool moving = true;  // driven coordinates: false if every law behind it is constant
};

struct Term {
  Index coordinate;
  Index constant;
};

struct Product {
  Index a, b;  // forms
  Index constant;
};

struct Equation {
  Index products_begin = 0, products_end = 0;  // range in System::products
  Index linear = -1;                           // form; -1: none
  Index source = 0;                            // index into System::sources
  Index callback = -1;                         // index into System::callbacks; then products and linear are empty
  Index row = 0;                               // row within the source
};

// Origin of an equation, for messages: "coupler", "|e1| = 1", "body terminal", "driver motor".
struct Source {
  std::string name;
};

// A named point, vector or scalar: its components as forms (derived members are affine in their base).
struct Item {
  std::string name;
  Index form[3] = {-1, -1, -1};
  std::int8_t components = 1;  // 1: scalar, else the dimension of the scene
  std::int8_t dimension = 0;   // power of length
  bool derived = false;        // a body's member
  bool hidden = false;         // a driver's input: no output
  bool fixed = false;          // fixed in the scene; presolve may find further coordinates that never move
};

// 8 bytes: a scene may have millions of names.
struct NamedItem {
  std::uint32_t hash;
  Index item;
};

// The known scalars of one driver, in consecutive coordinates from `first`.
struct DriverInput {
  enum class Kind : std::uint8_t {
    scalar,     // s
    direction,  // cos, sin
    frame,      // 3D pose: o (3), a (3), b (3), c (3); 2D: o (2), cos, sin; a translation: o
  };
  Index driver = 0;  // index into Scene::drivers
  Kind kind = Kind::scalar;
  Index first = 0;
  Index count = 0;
  std::vector<Law> laws;         // scalar, direction: 1; frame: the translation's, then the rotation's
  std::int8_t dimension = 0;     // of a scalar or of the translation
  bool must_not_vanish = false;  // a driven distance
  // Forms of the driven quantity, for own_values(): a coordinate, the components of a distance, two directions (and in
  // space the axis), or the origin and axes of a body.
  std::vector<Index> own;
  Number zero = 0;              // SI unit; a driver with one law: added to the value that a program sets
  std::vector<Number> written;  // values of the driver in the posture as written, one for each law, SI units
};

// An auxiliary unknown that must be > 0: rho of a relative angle. With rho < 0 the angle is wrong by half a turn.
struct Positive {
  Index coordinate;
  Index driver;           // index into System::drivers
  std::int8_t dimension;  // power of length
};

// coordinate := form, in order; the forms use known coordinates only.
struct Assignment {
  Index coordinate;
  Index form;
};

struct CallbackBlock {
  const Callback* callback = nullptr;  // owned by the scene
  std::vector<Index> coordinates;      // forms of its arguments
  std::vector<double> unit;            // SI value of one internal unit, for each argument
  Index first_equation = 0;
};

// Three unit vectors that must stay right-handed.
struct Frame {
  Index item[3];
  Index body;
};

struct SystemGroup {
  std::string name;
  std::vector<Index> unknowns;  // coordinates
  bool keep = false;
};

// A measure in forms; outputs/output_program.hpp evaluates it.
struct MeasureForms {
  // sum, sum_of_angles: of other measures
  enum class Kind : std::uint8_t {
    form,
    distance,
    absolute_angle,
    signed_angle,
    unsigned_angle,
    sum,
    sum_of_angles,
    quaternion_w,
    quaternion_x,
    quaternion_y,
    quaternion_z,
    turn_x,  // has no value: angular velocity and acceleration
    turn_y,
    turn_z
  };
  struct SumTerm {
    Index measure;
    Number factor;
  };
  std::string name;
  Kind kind = Kind::form;
  // form: {f}; distance: {dx, dy(, dz)}; absolute_angle: {dx, dy}; angles: d, e (, axis) components in a row;
  // quaternion and turn: the components of three axes in a row
  std::vector<Index> forms;
  std::int8_t dimension = 0;   // power of length of the value
  std::vector<SumTerm> terms;  // terms of a sum
  Number constant = 0;         // constant of a sum, SI units

  [[nodiscard]] bool is_sum() const { return kind == Kind::sum || kind == Kind::sum_of_angles; }
};

// One bound of a limit.
struct Bound {
  Index measure = 0;   // index into System::measures
  Number value = 0;    // SI units
  bool is_max = true;  // the largest allowed value; false: the smallest one
  bool ends = true;    // the motion ends there
  Index input = -1;    // index into System::inputs: the driver of the coordinate of a joint; -1: it is not driven
};

[[nodiscard]] inline bool is_quaternion(MeasureForms::Kind kind) {
  return kind >= MeasureForms::Kind::quaternion_w && kind <= MeasureForms::Kind::quaternion_z;
}
[[nodiscard]] inline bool is_turn(MeasureForms::Kind kind) {
  return kind >= MeasureForms::Kind::turn_x && kind <= MeasureForms::Kind::turn_z;
}
// True if the value, or the integral of the rate, is in rad.
[[nodiscard]] bool is_angle(MeasureForms::Kind kind);

// "rad", "m", "1", "m^2"
[[nodiscard]] std::string unit_of(const MeasureForms& measure);

// Origins of the numbers in an array that follow from parameters of a table: few do, and a scene may have millions of
// numbers.
class Origins {
 public:
  [[nodiscard]] Number of(const std::vector<double>& values, Index i) const {
    const double value = values[static_cast<std::size_t>(i)];
    if (origins_.empty()) return value;
    const auto found = origins_.find(i);
    return found != origins_.end() ? found->second : Number(value);
  }
  // Appends a number. Returns its place.
  Index add(std::vector<double>& values, const Number& value) {
    const auto i = static_cast<Index>(values.size());
    values.push_back(value.value());
    if (value.has_origin()) origins_.emplace(i, value);
    return i;
  }

 private:
  std::unordered_map<Index, Number> origins_;
};

class System {
 public:
  std::shared_ptr<const Scene> scene;  // null if load_plan() made this; then only the members below exist
  std::vector<std::string> drivers;    // names, in the order of the scene
  std::vector<std::string> outputs;    // wanted, as the scene has them; empty: everything
  int dimension = 2;
  int length_exponent = 0;  // one internal length unit is 2^length_exponent m

  std::vector<Coordinate> coordinates;
  std::vector<double> guess;  // for each coordinate, internal units; driven ones at the start time
  std::vector<double> constants;
  std::vector<Index> form_start = {0};
  std::vector<Term> terms;
  std::vector<Product> products;
  std::vector<Equation> equations;
  std::vector<Source> sources;
  std::vector<Item> items;
  std::vector<NamedItem> by_name;  // all items, for find_item(); set by index_names()
  std::vector<DriverInput> inputs;
  std::vector<Assignment> assignments;
  std::vector<Positive> positive;
  std::vector<CallbackBlock> callbacks;
  int teeth = 1;  // most of Callback::teeth
  std::vector<Frame> frames;
  std::vector<SystemGroup> groups;
  std::vector<MeasureForms> measures;  // measures of the scene, in its order
  std::vector<Bound> bounds;           // bounds of the limits of the scene, in their order
  std::vector<Diagnostic> notes;       // e.g. a driver that overrules a guess

  [[nodiscard]] std::span<const Term> form(Index f) const {
    return {terms.data() + form_start[static_cast<std::size_t>(f)],
            terms.data() + form_start[static_cast<std::size_t>(f) + 1]};
  }
  [[nodiscard]] std::span<const Product> products_of(const Equation& e) const {
    return {products.data() + e.products_begin, products.data() + e.products_end};
  }
  // Constants and guesses with their origins, and what adds them.
  [[nodiscard]] Number constant(Index c) const { return constant_origins_.of(constants, c); }
  [[nodiscard]] Number guess_of(Index coordinate) const { return guess_origins_.of(guess, coordinate); }
  Index add_constant(const Number& value) { return constant_origins_.add(constants, value); }
  void add_guess(const Number& value) { guess_origins_.add(guess, value); }

  // Fills by_name; to be called after all items were added.
  void index_names();
  // The item of that name; -1: there is none.
  [[nodiscard]] Index find_item(std::string_view name) const;
  // Throws std::out_of_range if there is none.
  [[nodiscard]] const Item& item(std::string_view name) const;
  [[nodiscard]] Index forms() const { return static_cast<Index>(form_start.size()) - 1; }
  [[nodiscard]] std::string coordinate_name(Index coordinate) const;
  [[nodiscard]] std::string equation_name(Index equation) const;

  // The coordinates that an equation mentions (without the constant 1), ascending, each once.
  void mentioned(Index equation, std::vector<Index>& out) const;

  // SI value of one internal unit of a quantity with this power of length.
  [[nodiscard]] double unit(int power) const;

 private:
  Origins constant_origins_, guess_origins_;
};

// Values of the forms and equations at a posture q (all coordinates); T = double or a quad type.
template <class T>
T form_value(const System& s, Index form, std::span<const T> q) {
  T sum = 0;
  for (const Term& t : s.form(form)) {
    sum += T(s.constants[static_cast<std::size_t>(t.constant)]) * q[static_cast<std::size_t>(t.coordinate)];
  }
  return sum;
}

template <class T>
T residual(const System& s, Index equation, std::span<const T> q) {
  const Equation& e = s.equations[static_cast<std::size_t>(equation)];
  if (e.callback >= 0) {
    const CallbackBlock& block = s.callbacks[static_cast<std::size_t>(e.callback)];
    std::vector<double> x, phi(static_cast<std::size_t>(block.callback->equations));
    for (std::size_t i = 0; i < block.coordinates.size(); ++i) {
      x.push_back(static_cast<double>(form_value<T>(s, block.coordinates[i], q)) * block.unit[i]);
    }
    block.callback->residual(x, phi);
    return T(phi[static_cast<std::size_t>(e.row)]);
  }
  T sum = e.linear >= 0 ? form_value<T>(s, e.linear, q) : T(0);
  for (const Product& p : s.products_of(e)) {
    sum += T(s.constants[static_cast<std::size_t>(p.constant)]) * form_value<T>(s, p.a, q) * form_value<T>(s, p.b, q);
  }
  return sum;
}

// Calls add(coordinate, value) such that the values for each coordinate add up to dPhi/dcoordinate.
template <class T, class Add>
void gradient(const System& s, Index equation, std::span<const T> q, Add&& add) {
  const Equation& e = s.equations[static_cast<std::size_t>(equation)];
  const auto through = [&](Index form, const T& factor) {
    for (const Term& t : s.form(form)) {
      add(t.coordinate, T(s.constants[static_cast<std::size_t>(t.constant)]) * factor);
    }
  };
  if (e.callback >= 0) {
    const CallbackBlock& block = s.callbacks[static_cast<std::size_t>(e.callback)];
    const std::size_t m = block.coordinates.size();
    std::vector<double> x, jacobian(m * static_cast<std::size_t>(block.callback->equations));
    for (std::size_t i = 0; i < m; ++i) {
      x.push_back(static_cast<double>(form_value<T>(s, block.coordinates[i], q)) * block.unit[i]);
    }
    block.callback->jacobian(x, jacobian);
    for (std::size_t i = 0; i < m; ++i) {
      through(block.coordinates[i], T(jacobian[static_cast<std::size_t>(e.row) * m + i] * block.unit[i]));
    }
    return;
  }
  if (e.linear >= 0) through(e.linear, T(1));
  for (const Product& p : s.products_of(e)) {
    const T c = T(s.constants[static_cast<std::size_t>(p.constant)]);
    through(p.a, c * form_value<T>(s, p.b, q));
    through(p.b, c * form_value<T>(s, p.a, q));
  }
}

// use(index into System::inputs, k, function) for every function among the parts of its k-th law.
template <class Use>
void for_each_function(const System& s, const Use& use) {
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    for (std::size_t k = 0; k < s.inputs[i].laws.size(); ++k) {
      for (const Law::Part& part : s.inputs[i].laws[k].parts()) {
        if (const auto* function = std::get_if<Law::Function>(&part)) use(i, k, *function);
      }
    }
  }
}

// Scale of the residual of an equation: size_of_terms() with the lower bound that residual_scale.hpp explains.
double residual_scale(const System& s, Index equation, std::span<const double> q);

// Inputs and assignments that are needed.
struct Driven {
  std::vector<Index> inputs;       // indices into System::inputs
  std::vector<Index> assignments;  // indices into System::assignments, in order
};
[[nodiscard]] Driven all_driven(const System& s);
// The inputs and assignments that marked coordinates depend on.
[[nodiscard]] Driven driven_behind(const System& s, std::vector<std::uint8_t> needed);

// Sets the driven coordinates of q (and of its derivatives where not null) at time t.
// Returns out_of_range, actuator_zero or ok; `where` is the driver.
Status drive(const System& s, double t, double* q, double* rate, double* acceleration);

}  // namespace assur
