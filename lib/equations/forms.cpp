#include "equations/forms.hpp"

#include <algorithm>
#include <cmath>

#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "scene/triple.hpp"

namespace assur {
namespace {
constexpr double kLocalRounding = 8 * kEps;  // of local coordinates; a choice: some roundings
}

// A number with its rounding error. Far from the origin, the sum of a fixed point and an offset on its body loses the
// last digits of the offset, which a difference with another point nearby needs.
struct Forms::Exact {
  Number value, rest;
  double size;

  friend Exact operator+(const Exact& a, const Exact& b) {
    const Number sum = a.value + b.value, of_b = sum - a.value;
    return rounded(sum, (a.value - (sum - of_b)) + (b.value - of_b) + (a.rest + b.rest), a.size + b.size);
  }
  friend Exact operator*(const Exact& a, const Exact& b) {
    const Number product = a.value * b.value;
    return rounded(product, fma(a.value, b.value, -product) + (a.value * b.rest + a.rest * b.value), a.size * b.size);
  }
  static Exact rounded(const Number& sum, const Number& rest, double size) {
    const Number value = sum + rest;
    return {value, isfinite(value) ? rest - (value - sum) : Number(0), size};
  }
};

Forms::Forms(std::shared_ptr<const Scene> scene, int length_exponent) {
  s_.scene = std::move(scene);
  s_.dimension = s_.scene->dimension();
  for (const Driver& d : s_.scene->drivers()) s_.drivers.push_back(d.name);
  s_.outputs = s_.scene->outputs();
  s_.length_exponent = length_exponent;
  s_.constants = {1.0, -1.0};
  rests_ = {0, 0};
  sizes_ = {1, 1};
  s_.coordinates.push_back({-1, -1, 0, Role::one, false});
  s_.guess.push_back(1.0);

  // Drivers add some items of their own.
  const std::size_t named = s_.scene->points().size() + s_.scene->vectors().size() + 8 * s_.drivers.size();
  const std::size_t scalars = 1 + named * static_cast<std::size_t>(s_.dimension);
  s_.items.reserve(named);
  item_of_.reserve(named);
  s_.coordinates.reserve(scalars);
  s_.guess.reserve(scalars);
  // Enough for distances, the most frequent constraint; unused memory is not touched.
  const std::size_t constraints = s_.scene->constraints().size(), size = static_cast<std::size_t>(s_.dimension);
  s_.sources.reserve(constraints);
  s_.equations.reserve(constraints);
  s_.products.reserve(constraints * (size + 1));
  s_.form_start.reserve(scalars + constraints * (size + 1));
  s_.terms.reserve(scalars + constraints * (2 * size + 1));
  s_.constants.reserve(scalars + constraints);
  rests_.reserve(scalars + constraints);
  sizes_.reserve(scalars + constraints);
}

System Forms::finish() {
  rests_ = {};
  sizes_ = {};
  s_.index_names();
  s_.constants.shrink_to_fit();
  s_.form_start.shrink_to_fit();
  s_.terms.shrink_to_fit();
  s_.products.shrink_to_fit();
  s_.equations.shrink_to_fit();
  s_.sources.shrink_to_fit();
  return std::move(s_);
}

// ---- constants and forms

Index Forms::internal_constant(const Exact& exact) {
  rest_origins_.add(rests_, exact.rest);
  sizes_.push_back(exact.size);
  return s_.add_constant(exact.value);
}

Forms::Exact Forms::exact(Index constant) const {
  return {s_.constant(constant), rest_origins_.of(rests_, constant), sizes_[idx(constant)]};
}

Index Forms::constant(const Number& value, int power, double size) {
  return internal_constant({scaled(value, power), 0, std::ldexp(size, shift(power))});
}

Index Forms::form(Terms terms, double least) {
  drop_rounding(terms, least);
  s_.terms.insert(s_.terms.end(), terms.begin(), terms.end());
  s_.form_start.push_back(static_cast<Index>(s_.terms.size()));
  return s_.forms() - 1;
}

// If all coefficients cancelled, the constant is rounding, too, if it is as small as that, or at most `least`.
void Forms::drop_rounding(Terms& terms, double least) {
  const auto constant = [&](const Term& t) { return s_.constants[idx(t.constant)]; };
  const auto most = [&](const Term& t) {
    return std::max(least, terms.size() > 1 ? kLocalRounding * sizes_[idx(t.constant)] : 0);
  };
  bool drops = least > 0;
  for (const Term& t : terms) {
    if (t.coordinate != kOne && constant(t) != 0) return;
    drops = drops || (t.coordinate == kOne && constant(t) != 0 && std::abs(constant(t)) <= most(t));
  }
  if (!drops) return;
  // The same for a tape, so that members in which it counts are prepared alone.
  for (const Term& t : terms) {
    if (t.coordinate != kOne && s_.constant(t.constant) != 0) return;
  }
  for (Term& t : terms) {
    if (t.coordinate != kOne || !(abs(s_.constant(t.constant)) <= most(t))) continue;
    t.constant = internal_constant({0, 0, sizes_[idx(t.constant)]});
  }
}

// The product of a literal and a value is the constant of the value, or a new constant.
Index Forms::times(Index a, Index b) {
  if (a == kPlus) return b;
  if (b == kPlus) return a;
  if (a == kMinus && b == kMinus) return kPlus;
  return internal_constant(exact(a) * exact(b));
}

void Forms::append(Terms& terms, Index f, Index factor) {
  const Index begin = s_.form_start[idx(f)], end = s_.form_start[idx(f) + 1];
  for (Index i = begin; i < end; ++i) {
    const Term t = s_.terms[idx(i)];
    const Index c = times(factor, t.constant);
    const auto same =
        std::find_if(terms.begin(), terms.end(), [&](const Term& o) { return o.coordinate == t.coordinate; });
    // If both ends are on one body, the coefficients add up; literals whose sum is zero cancel exactly.
    const auto cancels = [&] { return same->constant < kLiterals && c < kLiterals && same->constant != c; };
    if (same == terms.end()) {
      terms.push_back({t.coordinate, c});
    } else if (t.coordinate != kOne && cancels()) {
      terms.erase(same);
    } else {
      // A coefficient that is only rounding is zero: two members may be at one place of their body.
      // A tape compares with the coefficients, so that the scale of other numbers does not matter.
      const Exact a = exact(same->constant), b = exact(c), sum = a + b;
      const auto is_rounding = [&] {
        const Number larger = std::max(abs(a.value), abs(b.value));
        const double share = larger.value() > 0 ? sum.size / larger.value() : 1;
        return abs(sum.value) <= kLocalRounding * share * larger;
      };
      same->constant = internal_constant(t.coordinate != kOne && is_rounding() ? Exact{0, 0, sum.size} : sum);
    }
  }
}

Index Forms::combination(std::initializer_list<std::pair<Index, Index>> parts) {
  Terms terms;
  for (const auto& [f, factor] : parts) append(terms, f, factor);
  return form(std::move(terms));
}

// ---- items and coordinates

Index Forms::add_item(Item item) {
  const Index id = static_cast<Index>(s_.items.size());
  item_of_.emplace(item.name, id);
  s_.items.push_back(std::move(item));
  return id;
}

const Item& Forms::item(const std::string& name) const { return s_.items[idx(item_index(name))]; }

Index Forms::add_coordinate(Index item, int component, int power, Role role, const Number& guess, bool moving) {
  s_.coordinates.push_back({item, static_cast<std::int8_t>(component), static_cast<std::int8_t>(power), role, moving});
  s_.add_guess(scaled(guess, power));
  return static_cast<Index>(s_.coordinates.size()) - 1;
}

void Forms::declare(const std::string& name, const Triple& at, bool fixed, int power) {
  Item item;
  item.name = name;
  item.components = static_cast<std::int8_t>(dimension());
  item.dimension = static_cast<std::int8_t>(power);
  const Index id = add_item(item);
  for (int k = 0; k < dimension(); ++k) {
    const Number& a = at[static_cast<std::size_t>(k)];
    s_.items[idx(id)].form[k] =
        fixed ? constant_form(a, power) : coordinate_form(add_coordinate(id, k, power, Role::unknown, a));
  }
}

void Forms::declare_derived(const std::string& name, int power, const Index (&components)[3]) {
  Item item;
  item.name = name;
  item.components = static_cast<std::int8_t>(dimension());
  item.dimension = static_cast<std::int8_t>(power);
  item.derived = true;
  std::copy_n(components, 3, item.form);
  add_item(item);
}

void Forms::declare_scalar(const std::string& name, int power, const Number& guess) {
  Item item;
  item.name = name;
  item.dimension = static_cast<std::int8_t>(power);
  const Index id = add_item(item);
  s_.items[idx(id)].form[0] = coordinate_form(add_coordinate(id, -1, power, Role::unknown, guess));
}

Index Forms::scalar_form(const std::string& text) const {
  const auto whole = item_of_.find(text);
  if (whole != item_of_.end()) return s_.items[idx(whole->second)].form[0];
  const std::size_t point = text.rfind('.');
  return item(text.substr(0, point)).form[text[point + 1] - 'x'];
}

int Forms::scalar_dimension(const std::string& text) const {
  const auto whole = item_of_.find(text);
  if (whole != item_of_.end()) return s_.items[idx(whole->second)].dimension;
  return item(text.substr(0, text.rfind('.'))).dimension;
}

Forms::Components Forms::direction(const Direction& d) {
  Components c{};
  if (!d.is_pair()) {
    const Item& v = item(d.first);
    std::copy_n(v.form, 3, c.form);
    c.power = v.dimension;
    return c;
  }
  const Item &a = item(d.first), &b = item(d.second);
  for (int k = 0; k < dimension(); ++k) c.form[k] = difference(b.form[k], a.form[k]);
  c.power = 1;
  return c;
}

Triple Forms::at(const Item& item) const {
  Triple r{};
  for (int k = 0; k < item.components; ++k) {
    Number sum = 0;
    for (const Term& t : s_.form(item.form[k])) {
      sum += s_.constant(t.constant) * s_.guess_of(t.coordinate);
    }
    r[idx(k)] = ldexp(sum, s_.length_exponent * item.dimension);
  }
  return r;
}

Triple Forms::at(const Direction& d) const {
  return d.is_pair() ? triple::subtract(at(d.second), at(d.first)) : at(d.first);
}

// ---- known coordinates

bool Forms::is_fixed(const Item& item) const {
  for (int k = 0; k < item.components; ++k) {
    for (const Term& t : s_.form(item.form[k])) {
      if (t.coordinate != kOne) return false;
    }
  }
  return true;
}

bool Forms::all_known(const Item& item) const {
  for (int k = 0; k < item.components; ++k) {
    for (const Term& t : s_.form(item.form[k])) {
      if (s_.coordinates[idx(t.coordinate)].role == Role::unknown) return false;
    }
  }
  return true;
}

Index Forms::own_coordinate(Index form) const {
  const auto terms = s_.form(form);
  if (terms.size() != 1 || terms[0].constant != kPlus) return -1;
  return s_.coordinates[idx(terms[0].coordinate)].role == Role::unknown ? terms[0].coordinate : -1;
}

// ---- equations

Index Forms::source(std::string name) {
  s_.sources.push_back({std::move(name)});
  row_ = 0;
  return static_cast<Index>(s_.sources.size()) - 1;
}

void Forms::equation(Index source, const std::vector<Product>& products, const Terms& linear) {
  Equation e;
  e.products_begin = static_cast<Index>(s_.products.size());
  s_.products.insert(s_.products.end(), products.begin(), products.end());
  e.products_end = static_cast<Index>(s_.products.size());
  // The constant of a linear equation may also be a contradiction, but as a relative residual any rounding would look
  // like one.
  e.linear = linear.empty() ? -1 : form(linear, products.empty() ? kConsistent : 0);
  e.source = source;
  e.row = row_++;
  s_.equations.push_back(e);
}

void Forms::callback_row(Index source, Index callback, Index row) {
  Equation e;
  e.products_begin = e.products_end = static_cast<Index>(s_.products.size());
  e.source = source;
  e.row = row;
  e.callback = callback;
  s_.equations.push_back(e);
}

void Forms::unit_equation(Index source, const Item& vector) {
  std::vector<Product> products;
  add_dot(products, vector.form, vector.form);
  equation(source, products, {{kOne, kMinus}});
}

void Forms::distance_equation(Index source, const Item& p, const Item& q, const Number& length) {
  std::vector<Product> products;
  add_square(products, p, q, kPlus);
  const Index l = constant_form(length, 1);
  products.push_back({l, l, kMinus});
  equation(source, products, {});
}

void Forms::orthogonal_equation(Index source, const Index* d, const Index* e) {
  std::vector<Product> products;
  add_dot(products, d, e);
  equation(source, products, {});
}

void Forms::cross_equation(Index source, const Index* c, const Index* a, const Index* b) {
  for (int k = 0; k < 3; ++k) {
    Terms linear;
    append(linear, c[k], kPlus);
    const int i = kNext[k], j = kAfter[k];
    equation(source, {{a[i], b[j], kMinus}, {a[j], b[i], kPlus}}, linear);
  }
}

void Forms::add_dot(std::vector<Product>& products, const Index* d, const Index* e) const {
  for (int k = 0; k < dimension(); ++k) products.push_back({d[k], e[k], kPlus});
}

void Forms::add_square(std::vector<Product>& products, const Item& p, const Item& q, Index factor) {
  for (int k = 0; k < dimension(); ++k) {
    const Index d = difference(p.form[k], q.form[k]);
    products.push_back({d, d, factor});
  }
}

}  // namespace assur
