#include "equations/lowering_parts.hpp"
#include "scene/axes.hpp"

namespace assur {

void DriverWriter::write_equations() {
  const auto& drivers = forms_.scene().drivers();
  for (std::size_t i = 0; i < drivers.size(); ++i) {
    if (shared_.fixes[i]) continue;
    const Index n = static_cast<Index>(i);
    const Index from = forms_.source("driver " + drivers[i].name);
    std::visit([&](const auto& kind) { write(from, drivers[i], kind, n); }, drivers[i].kind);
  }
}

void DriverWriter::write_equal(Index from, Index f, Index g) {
  Terms linear;
  forms_.append(linear, f, kPlus);
  forms_.append(linear, g, kMinus);
  forms_.equation(from, {}, linear);
}

void DriverWriter::write(Index from, const Driver&, const DrivenCoordinate& c, Index n) {
  write_equal(from, forms_.scalar_form(c.coordinate), input_form(n, 0));
}

void DriverWriter::write(Index from, const Driver& d, const PointAngle& a, Index n) {
  if (partner(n) >= 0) return write_polar_arm(from, d, a, n);
  const Item& to = forms_.item(a.b);
  for (int k = 0; k < forms_.dimension(); ++k) write_equal(from, to.form[k], arm_end(d, a, n, k));
}

// B - A - r (cos, sin) = 0 in the plane with the driven distance r; B - A - z n - rho (cos e1 + sin e2) = 0 about a
// fixed axis n in space, where the auxiliary rho > 0 is the length of the arm across the axis.
void DriverWriter::write_polar_arm(Index from, const Driver& d, const PointAngle& a, Index n) {
  const Item &foot = forms_.item(a.a), &end = forms_.item(a.b);
  const bool in_space = forms_.dimension() == 3;
  const Index length = in_space ? forms_.item(d.name + ".rho").form[0] : input_form(partner(n), 0);
  const Triple axis = in_space ? forms_.at(axis_of(a)) : Triple{}, e1 = zero_of(a), e2 = triple::cross(axis, e1);
  const Number z = along_axis(a);
  for (int k = 0; k < forms_.dimension(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    Terms linear;
    forms_.append(linear, end.form[k], kPlus);
    forms_.append(linear, foot.form[k], kMinus);
    Index direction = input_form(n, k);
    if (in_space) {
      forms_.append(linear, forms_.constant_form(-z * axis[i], 1), kPlus);
      direction =
          forms_.combination({{input_form(n, 0), forms_.constant(e1[i])}, {input_form(n, 1), forms_.constant(e2[i])}});
    }
    forms_.equation(from, {{length, direction, kMinus}}, linear);
  }
}

// With an angle driver of the same points, the length of its arm: nothing in the plane, rho^2 + z^2 = d^2 in space.
void DriverWriter::write(Index from, const Driver&, const DrivenDistance& d, Index n) {
  std::vector<Product> products;
  if (const Index angle = partner(n); angle >= 0) {
    if (forms_.dimension() == 2) return;
    const Driver& turning = forms_.scene().drivers()[static_cast<std::size_t>(angle)];
    const Index rho = forms_.item(turning.name + ".rho").form[0];
    const Index z = forms_.constant_form(along_axis(std::get<PointAngle>(turning.kind)), 1);
    products = {{rho, rho, kPlus}, {z, z, kPlus}, {input_form(n, 0), input_form(n, 0), kMinus}};
    return forms_.equation(from, products, {});
  }
  forms_.add_square(products, forms_.item(d.a), forms_.item(d.b), kPlus);
  products.push_back({input_form(n, 0), input_form(n, 0), kMinus});
  forms_.equation(from, products, {});
}

// d . e = rho cos, axis . (d x e) = rho sin with the auxiliary rho > 0, which is |d||e| if the axis is perpendicular to
// both.
void DriverWriter::write(Index from, const Driver& driver, const RelativeAngle& r, Index n) {
  const Forms::Components d = forms_.direction(r.d), e = forms_.direction(r.e);
  const Index rho = forms_.item(driver.name + ".rho").form[0];
  std::vector<Product> products;
  forms_.add_dot(products, d.form, e.form);
  products.push_back({rho, input_form(n, 0), kMinus});
  forms_.equation(from, products, {});
  products.clear();
  if (forms_.dimension() == 2) {
    products = {{d.form[0], e.form[1], kPlus}, {d.form[1], e.form[0], kMinus}};
  } else if (forms_.is_fixed(forms_.item(axis_of(r)))) {
    const Triple a = forms_.at(axis_of(r));
    for (int k = 0; k < 3; ++k) {
      const Number& c = a[static_cast<std::size_t>(k)];
      products.push_back({d.form[kNext[k]], e.form[kAfter[k]], forms_.constant(c)});
      products.push_back({d.form[kAfter[k]], e.form[kNext[k]], forms_.constant(-c)});
    }
  } else {
    const Item& across = forms_.item(driver.name + ".across");
    forms_.cross_equation(from, across.form, forms_.item(axis_of(r)).form, d.form);
    forms_.add_dot(products, across.form, e.form);
  }
  products.push_back({rho, input_form(n, 1), kMinus});
  forms_.equation(from, products, {});
}

void DriverWriter::note_own_forms() {
  for (DriverInput& in : forms_.system().inputs) {
    std::vector<Index> own;
    std::visit([&](const auto& kind) { note_own(own, kind); },
               forms_.scene().drivers()[static_cast<std::size_t>(in.driver)].kind);
    in.own = std::move(own);
  }
}

void DriverWriter::append_own(std::vector<Index>& own, const Direction& d) {
  const Forms::Components c = forms_.direction(d);
  own.insert(own.end(), c.form, c.form + forms_.dimension());
}

void DriverWriter::note_own(std::vector<Index>& own, const PointAngle& a) {
  const Triple zero = zero_of(a);
  for (int k = 0; k < forms_.dimension(); ++k) {
    own.push_back(forms_.constant_form(zero[static_cast<std::size_t>(k)], 0));
  }
  append_own(own, {a.a, a.b});
  if (forms_.dimension() == 3) append_own(own, axis_of(a));
}

void DriverWriter::note_own(std::vector<Index>& own, const RelativeAngle& r) {
  append_own(own, r.d);
  append_own(own, r.e);
  if (forms_.dimension() == 3) append_own(own, axis_of(r));
}

void DriverWriter::note_own(std::vector<Index>& own, const DrivenDistance& d) { append_own(own, {d.a, d.b}); }

void DriverWriter::note_own(std::vector<Index>& own, const DrivenCoordinate& c) {
  own.push_back(forms_.scalar_form(c.coordinate));
}

void DriverWriter::note_own(std::vector<Index>& own, const Pose& p) {
  const Body& b = body(p.body);
  const Item& origin = forms_.item(b.base.empty() ? b.origin : b.base[0]);
  own.insert(own.end(), origin.form, origin.form + forms_.dimension());
  for (const std::string& axis : b.frame) append_own(own, axis);
  for (std::size_t i = 1; i < b.base.size(); ++i) append_own(own, base_direction(forms_, b, i));
}

// In a declared group the base remains unknown.
void DriverWriter::write(Index from, const Driver&, const Pose& p, Index n) {
  const Body& b = body(p.body);
  if (b.frame.size() == 3) return write_posed_frame(from, b, n);
  for (const PoseTarget& t : pose_targets(b, n)) {
    const Item& item = forms_.item(t.item);
    for (int k = 0; k < forms_.dimension(); ++k) write_equal(from, item.form[k], t.form[k]);
  }
}

// O = o, |u| = |v| = |w| = 1, u.v = u.w = v.w = 0, v.a = w.a = w.b = 0.
void DriverWriter::write_posed_frame(Index from, const Body& b, Index n) {
  for (int k = 0; k < 3; ++k) write_equal(from, forms_.item(b.origin).form[k], input_form(n, k));
  const Item &u = forms_.item(b.frame[0]), &v = forms_.item(b.frame[1]), &w = forms_.item(b.frame[2]);
  for (const Item* axis : {&u, &v, &w}) forms_.unit_equation(from, *axis);
  forms_.orthogonal_equation(from, u.form, v.form);
  forms_.orthogonal_equation(from, u.form, w.form);
  forms_.orthogonal_equation(from, v.form, w.form);
  const Index a[3] = {input_form(n, 3), input_form(n, 4), input_form(n, 5)};
  const Index c[3] = {input_form(n, 6), input_form(n, 7), input_form(n, 8)};
  forms_.orthogonal_equation(from, v.form, a);
  forms_.orthogonal_equation(from, w.form, a);
  forms_.orthogonal_equation(from, w.form, c);
}

}  // namespace assur
