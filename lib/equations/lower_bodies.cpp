#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <random>
#include <string_view>

#include "equations/lowering_parts.hpp"
#include "equations/own_values.hpp"

namespace assur {

namespace {

constexpr unsigned kElsewhere = 3;  // values of the drivers at which quantities are compared; a choice
constexpr double kSpan = 3;         // SI units: the largest of these values
constexpr double kSameDot = 1e-12;  // relative difference of products that are equal but for rounding; a choice

// Local axes of a base with three entries, in ground coordinates in the posture as written.
std::array<Triple, 3> base_axes(const Forms& forms, const Body& body) {
  const Triple x = direction_of(forms.at(base_direction(forms, body, 1)));
  const Triple z = direction_of(triple::cross(x, forms.at(base_direction(forms, body, 2))));
  return {x, triple::cross(z, x), z};
}

// Of the local coordinates of a member.
double size_of_locals(const Member& m) { return triple::norm(m.local).value(); }

}  // namespace

Direction base_direction(const Forms& forms, const Body& body, std::size_t i) {
  if (forms.item(body.base[i]).dimension == 0) return {body.base[i]};
  return {body.base[0], body.base[i]};
}

BaseShape base_shape(const Forms& forms, const Shared& shared, const Body& b) {
  const auto is_point = [&](std::size_t i) { return forms.item(b.base[i]).dimension == 1; };
  const auto is_given = [&](std::size_t i, std::size_t j) {
    return shared.lengths.count(pair_key(b.base[i], b.base[j])) != 0;
  };
  const auto length = [&](std::size_t i, std::size_t j) -> Number {
    if (!is_point(j)) return triple::length(forms.at(b.base[j]));
    const auto given = shared.lengths.find(pair_key(b.base[i], b.base[j]));
    if (given != shared.lengths.end()) return given->second;
    return triple::length(triple::subtract(forms.at(b.base[j]), forms.at(b.base[i])));
  };
  BaseShape shape{length(0, 1)};
  if (b.base.size() == 2) return shape;
  const bool any_given = is_given(0, 1) || is_given(0, 2) || is_given(1, 2);
  if (!any_given || !is_point(1) || !is_point(2)) {
    const auto [x, y, z] = base_axes(forms, b);
    const Triple third = forms.at(base_direction(forms, b, 2));
    const Number stretched = is_given(0, 2) ? length(0, 2) / triple::length(third) : Number(1);
    shape.x = stretched * triple::dot(third, x);
    shape.y = stretched * triple::dot(third, y);
    return shape;
  }
  const Number p = shape.length, q = length(0, 2), r = length(1, 2);
  if (!(p < q + r && q < p + r && r < p + q)) {
    throw Error(Error::Kind::input,
                {{"/bodies/" + b.name + "/base",
                  "the distances between its three points do not form a triangle; each must be smaller "
                  "than the sum of the others"}});
  }
  shape.x = ((p - r) * (p + r) + q * q) / (2 * p);
  shape.y = sqrt((q - shape.x) * (q + shape.x));
  return shape;
}

// ---- members

void BodyWriter::declare_members() {
  for (const Body& b : forms_.scene().bodies()) {
    if (b.name == "ground") {
      for (const Member& m : b.points) forms_.declare(m.name, m.local, true, 1);
      for (const Member& m : b.vectors) forms_.declare(m.name, m.local, true, 0);
    } else if (!b.frame.empty()) {
      declare_in_frame(b);
    } else if (b.base.empty()) {
      declare_translating(b);
    } else if (forms_.dimension() == 2) {
      declare_in_plane(b);
    } else {
      declare_in_space(b);
    }
  }
}

void BodyWriter::declare_translating(const Body& b) {
  const Item o = forms_.item(b.origin);
  for (const Member& m : b.points) {
    Index f[3] = {-1, -1, -1};
    for (int k = 0; k < forms_.dimension(); ++k) {
      const Index local = forms_.constant_form(m.local[static_cast<std::size_t>(k)], 1);
      f[k] = forms_.combination({{o.form[k], kPlus}, {local, kPlus}});
    }
    forms_.declare_derived(m.name, 1, f);
  }
  for (const Member& m : b.vectors) {
    Index f[3] = {-1, -1, -1};
    for (int k = 0; k < forms_.dimension(); ++k) {
      f[k] = forms_.constant_form(m.local[static_cast<std::size_t>(k)], 0);
    }
    forms_.declare_derived(m.name, 0, f);
  }
}

void BodyWriter::declare_in_frame(const Body& b) {
  const Item o = forms_.item(b.origin);
  std::vector<Item> axes;
  for (const std::string& a : b.frame) axes.push_back(forms_.item(a));
  const auto declare = [&](const Member& m, int power) {
    Index f[3] = {-1, -1, -1};
    for (int k = 0; k < forms_.dimension(); ++k) {
      Terms terms;
      if (power == 1) forms_.append(terms, o.form[k], kPlus);
      if (forms_.dimension() == 3) {
        for (std::size_t j = 0; j < 3; ++j) {
          forms_.append(terms, axes[j].form[k], forms_.constant(m.local[j], power, size_of_locals(m)));
        }
      } else {  // the second axis is the first one turned left
        forms_.append(terms, axes[0].form[k], forms_.constant(m.local[0], power, size_of_locals(m)));
        forms_.append(terms, axes[0].form[1 - k],
                      forms_.constant(k == 0 ? -m.local[1] : m.local[1], power, size_of_locals(m)));
      }
      f[k] = forms_.form(terms);
    }
    forms_.declare_derived(m.name, power, f);
  };
  for (const Member& m : b.points) declare(m, 1);
  for (const Member& m : b.vectors) declare(m, 0);
}

// Points are A + alpha (B - A) + beta (B - A) turned left; vectors lack A.
void BodyWriter::declare_in_plane(const Body& b) {
  const Item first = forms_.item(b.base[0]);
  const Direction side = base_direction(forms_, b, 1);
  const Number length = base_shape(forms_, shared_, b).length;
  const auto declare = [&](const Member& m, int power) {
    const Number alpha = m.local[0] / length, beta = m.local[1] / length;
    const double size = size_of_locals(m) / length.value();
    Index f[3] = {-1, -1, -1};
    for (int k = 0; k < 2; ++k) {
      const Forms::Components along = forms_.direction(side);
      Terms terms;
      if (power == 1) forms_.append(terms, first.form[k], kPlus);
      forms_.append(terms, along.form[k], forms_.constant(alpha, power - along.power, size));
      forms_.append(terms, along.form[1 - k], forms_.constant(k == 0 ? -beta : beta, power - along.power, size));
      f[k] = forms_.form(terms);
    }
    forms_.declare_derived(m.name, power, f);
  };
  for (const Member& m : b.points) declare(m, 1);
  for (const Member& m : b.vectors) declare(m, 0);
}

// Points are A + alpha d + beta e + z normal with the directions d and e of the base; vectors lack A. The normal exists
// if a member is off the plane.
void BodyWriter::declare_in_space(const Body& b) {
  const Item first = forms_.item(b.base[0]);
  const bool is_line = b.base.size() == 2;
  const Direction side = base_direction(forms_, b, 1);
  const Direction other = is_line ? side : base_direction(forms_, b, 2);
  const BaseShape shape = base_shape(forms_, shared_, b);
  const auto out_of_plane = [](const Member& m) { return m.local[2] != 0; };
  const bool with_normal = std::any_of(b.points.begin(), b.points.end(), out_of_plane) ||
                           std::any_of(b.vectors.begin(), b.vectors.end(), out_of_plane);
  const std::string normal = b.name + ".normal";
  if (with_normal) {
    forms_.declare(normal, base_axes(forms_, b)[2], false, 0);
    shared_.without_norm.insert(normal);
    area_[b.name] = shape.length * shape.y;
  }
  const auto declare = [&](const Member& m, int power) {
    const Number beta = is_line ? Number(0) : m.local[1] / shape.y;
    const Number alpha = (m.local[0] - beta * shape.x) / shape.length;
    // The base is rounded, too: its height y by as much as its side.
    const double of_base = std::abs(beta.value()) * std::hypot(shape.x.value(), shape.y.value()),
                 of_beta = is_line ? 0 : (size_of_locals(m) + of_base) / shape.y.value(),
                 of_alpha = (size_of_locals(m) + of_base + of_beta * std::abs(shape.x.value())) / shape.length.value();
    const Forms::Components d = forms_.direction(side), e = forms_.direction(other);
    Index f[3] = {-1, -1, -1};
    for (int k = 0; k < 3; ++k) {
      Terms terms;
      if (power == 1) forms_.append(terms, first.form[k], kPlus);
      forms_.append(terms, d.form[k], forms_.constant(alpha, power - d.power, of_alpha));
      if (!is_line) forms_.append(terms, e.form[k], forms_.constant(beta, power - e.power, of_beta));
      if (with_normal)
        forms_.append(terms, forms_.item(normal).form[k], forms_.constant(m.local[2], power, size_of_locals(m)));
      f[k] = forms_.form(terms);
    }
    forms_.declare_derived(m.name, power, f);
  };
  for (const Member& m : b.points) declare(m, 1);
  for (const Member& m : b.vectors) declare(m, 0);
}

// ---- equations

void BodyWriter::write_equations() {
  const auto& drivers = forms_.scene().drivers();
  for (std::size_t i = 0; i < drivers.size(); ++i) {
    const auto* p = std::get_if<Pose>(&drivers[i].kind);
    if (p != nullptr && !shared_.fixes[i]) posed_.insert(p->body);
  }
  std::set<std::vector<std::string>> framed;
  const auto& bodies = forms_.scene().bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& b = bodies[i];
    if (b.name == "ground") continue;
    if (!b.frame.empty() && forms_.dimension() == 3) {
      for (const std::string& a : b.frame) shared_.without_norm.insert(a);
      if (framed.insert(b.frame).second) write_frame(b, static_cast<Index>(i));
    } else if (!b.frame.empty() && posed_by_equations(b)) {
      shared_.without_norm.insert(b.frame[0]);
    } else if (!b.base.empty()) {
      write_base(b);
    }
    note_written(b, static_cast<Index>(i));
  }
}

void BodyWriter::note_written(const Body& b, Index index) {
  const auto note = [&](const std::string& name) { written_[name].push_back(index); };
  if (!b.origin.empty()) note(b.origin);
  for (const auto* names : {&b.frame, &b.base}) std::for_each(names->begin(), names->end(), note);
  for (const auto* members : {&b.points, &b.vectors}) {
    for (const Member& m : *members) note(m.name);
  }
}

void BodyWriter::write_frame(const Body& b, Index index) {
  const Item axis[3] = {forms_.item(b.frame[0]), forms_.item(b.frame[1]), forms_.item(b.frame[2])};
  forms_.system().frames.push_back(
      {{forms_.item_index(b.frame[0]), forms_.item_index(b.frame[1]), forms_.item_index(b.frame[2])}, index});
  int known = -1, unknown = 0;
  for (int j = 0; j < 3; ++j) unknown += forms_.all_known(axis[j]) ? 0 : 1;
  // Of two known axes, takes the one whose next axis is known as well: the third is their product.
  for (int j = 0; j < 3; ++j) {
    if (forms_.all_known(axis[j]) && (unknown == 2 || forms_.all_known(axis[kNext[j]]))) known = j;
  }
  if (posed_by_equations(b)) return;
  const Index from = forms_.source("body " + b.name);
  for (int j = 0; j < 3; ++j) {  // known axes that drivers turn against each other
    const int k = kNext[j];
    if (!forms_.all_known(axis[j]) || !forms_.all_known(axis[k]) || is_constant(b.frame[j], b.frame[k])) continue;
    forms_.orthogonal_equation(from, axis[j].form, axis[k].form);
  }
  if (unknown == 0) return;
  if (known >= 0) return write_frame_about(from, axis[known], axis[kNext[known]], axis[kAfter[known]]);
  forms_.unit_equation(from, axis[0]);
  forms_.unit_equation(from, axis[1]);
  forms_.orthogonal_equation(from, axis[0].form, axis[1].form);
  forms_.cross_equation(from, axis[2].form, axis[0].form, axis[1].form);
}

// If one axis is known: a unit vector perpendicular to it, and the third axis by the cross product.
void BodyWriter::write_frame_about(Index from, const Item& known, const Item& next, const Item& after) {
  if (!forms_.all_known(next)) {
    forms_.unit_equation(from, next);
    forms_.orthogonal_equation(from, next.form, known.form);
  }
  if (!forms_.all_known(after)) forms_.cross_equation(from, after.form, known.form, next.form);
}

// True if one of the bodies written before has all of these items, and therefore keeps them rigid.
bool BodyWriter::is_kept(std::initializer_list<std::string_view> names) const {
  std::vector<Index> common;
  for (bool first = true; const std::string_view name : names) {
    const auto found = written_.find(name);
    if (found == written_.end()) return false;
    if (std::exchange(first, false)) {
      common = found->second;
      continue;
    }
    std::vector<Index> both;
    std::set_intersection(common.begin(), common.end(), found->second.begin(), found->second.end(),
                          std::back_inserter(both));
    common = std::move(both);
  }
  return !common.empty();
}

// Compares the product at some values of the drivers.
bool BodyWriter::is_constant(const Direction& d, const Direction& e) {
  const System& s = forms_.system();
  if (s.inputs.empty()) return true;
  for (unsigned i = static_cast<unsigned>(elsewhere_.size()); i < kElsewhere; ++i) {
    std::mt19937 random(i);
    std::vector<std::vector<double>> values;
    for (const DriverInput& in : s.inputs) {
      for (double& v : values.emplace_back(in.laws.size())) v = kSpan * (static_cast<double>(random()) / 0x1p31 - 1);
    }
    drive_by_values(s, values, elsewhere_.emplace_back(s.guess));
  }
  const Forms::Components a = forms_.direction(d), b = forms_.direction(e);
  double least = HUGE_VAL, most = -HUGE_VAL, size = 0;
  for (const std::vector<double>& q : elsewhere_) {
    double dot = 0;
    for (std::size_t k = 0; k < idx(forms_.dimension()); ++k) {
      const auto value = [&](Index form, double& terms) {
        for (const Term& t : s.form(form)) terms += std::abs(s.constants[idx(t.constant)] * q[idx(t.coordinate)]);
        return form_value<double>(s, form, q);
      };
      double of_a = 0, of_b = 0;
      dot += value(a.form[k], of_a) * value(b.form[k], of_b);
      size = std::max(size, of_a * of_b);
    }
    least = std::min(least, dot), most = std::max(most, dot);
  }
  return most - least <= kSameDot * size;
}

void BodyWriter::write_base(const Body& b) {
  const auto known = [&](std::size_t i) { return forms_.all_known(forms_.item(b.base[i])); };
  // Omits a distance that another body or a constraint has written already, or that no driver changes.
  const auto keep_distance = [&](const std::string& p, const std::string& q) {
    const Item a = forms_.item(p), c = forms_.item(q);
    if (is_kept({p, q})) return;
    const Direction side{p, q};
    if (forms_.all_known(a) && forms_.all_known(c) && is_constant(side, side)) return;
    if (!shared_.distances.insert(pair_key(p, q)).second) return;
    forms_.distance_equation(forms_.source("body " + b.name), a, c,
                             triple::length(triple::subtract(forms_.at(p), forms_.at(q))));
  };
  if (!posed_by_equations(b)) {
    const auto is_point = [&](std::size_t i) { return forms_.item(b.base[i]).dimension == 1; };
    for (std::size_t i = 1; i < b.base.size(); ++i) {
      if (is_point(i)) keep_distance(b.base[0], b.base[i]);
    }
    if (b.base.size() == 3 && is_point(1) && is_point(2)) {
      keep_distance(b.base[1], b.base[2]);
    } else if (b.base.size() == 3) {
      const bool all_known = known(1) && known(2) && (known(0) || (!is_point(1) && !is_point(2)));
      const bool kept =
          is_point(1) || is_point(2) ? is_kept({b.base[0], b.base[1], b.base[2]}) : is_kept({b.base[1], b.base[2]});
      if (!kept && !(all_known && is_constant(base_direction(forms_, b, 1), base_direction(forms_, b, 2)))) keep_dot(b);
    }
  }
  if (const auto area = area_.find(b.name); area != area_.end()) write_normal(b, area->second);
}

// The dot product of the two directions of a base is that of the posture as written.
void BodyWriter::keep_dot(const Body& b) {
  const Direction side = base_direction(forms_, b, 1), other = base_direction(forms_, b, 2);
  const BaseShape shape = base_shape(forms_, shared_, b);
  const Forms::Components d = forms_.direction(side), e = forms_.direction(other);
  std::vector<Product> products;
  forms_.add_dot(products, d.form, e.form);
  const Index value = forms_.constant_form(-shape.length * shape.x, d.power + e.power);
  Terms linear;
  forms_.append(linear, value, kPlus);
  forms_.equation(forms_.source("body " + b.name), products, linear);
}

// area * normal = d x e with the directions d and e of the base
void BodyWriter::write_normal(const Body& b, const Number& area) {
  const Item n = forms_.item(b.name + ".normal");
  const Index from = forms_.source("body " + b.name);
  const Direction side = base_direction(forms_, b, 1), other = base_direction(forms_, b, 2);
  const Forms::Components d = forms_.direction(side), e = forms_.direction(other);
  for (int k = 0; k < 3; ++k) {
    Terms linear;
    forms_.append(linear, n.form[k], forms_.constant(area, d.power + e.power));
    const int i = kNext[k], j = kAfter[k];
    forms_.equation(from, {{d.form[i], e.form[j], kMinus}, {d.form[j], e.form[i], kPlus}}, linear);
  }
}

}  // namespace assur
